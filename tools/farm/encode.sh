# Makes a run's clip of all its frames.
# usage: encode.sh [RUN]       RUN: a number, or "task", the index of the task in its array
run=$(number "${1:-task}")
go_on "encode-$run" encode "${runs[run - 1]}"
