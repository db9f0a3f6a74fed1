# A queue that is none: a farm's tasks run on this machine, one after the other, while "umax farm" waits. For trying the
# scripts, and as an example of these functions for a queue other than Slurm; slurm.sh says what each of them is for.

queue_programs() {
  :
}

# A script may begin with commands, too: here what a task says goes into its file.
job_header() { # NAME LOG PROCESSORS MEMORY
  echo "# $1"
  echo "exec >>${2@Q}-\"\$UMAX_TASK\".log 2>&1"
}

# What a job waits for has ended when this is called: a task that fails ends the whole farm.
submit() { # TASKS AFTER SCRIPT [WORD…]
  local tasks=$1 task
  shift 2
  if [ -n "${UMAX_DRY_RUN:-}" ]; then
    echo "for UMAX_TASK in {1..$tasks}: bash" "${@@Q}"
    return
  fi
  for ((task = 1; task <= tasks; ++task)); do
    UMAX_TASK=$task bash "$@" >&2 || {
      echo "task $task of $1 has failed" >&2
      return 1
    }
  done
  echo here
}

task_index() {
  echo "${UMAX_TASK:-1}"
}

task_processors() {
  nproc
}

task_seconds_left() {
  :
}

# There is nobody to whom it could leave the machine: it goes on at once, as if it began again.
requeue_task() {
  SECONDS=0
}

unfinished_tasks() {
  :
}

cancel() { # ID…
  :
}
