# Simulates a run.
# usage: simulate.sh [RUN]     RUN: a number, or "task", the index of the task in its array
run=$(number "${1:-task}")
go_on "simulate-$run" simulate "${scenes[run - 1]}" -o "${runs[run - 1]}" --resume \
  --threads "$(task_processors)" "${simulate_options[@]}"
