# Draws a chunk of a run's frames.
# usage: render.sh RUN CHUNK   numbers, or "task", the index of the task in its array
run=$(number "$1")
chunk=$(number "$2")
# the last chunk may reach past the clip: umax leaves out what is not there
frames=$(((chunk - 1) * frames_per_job + 1))-$((chunk * frames_per_job))
go_on "render-$run-$chunk" render "${runs[run - 1]}" --frames "$frames" --no-clip --resume \
  --threads "$(task_processors)"
