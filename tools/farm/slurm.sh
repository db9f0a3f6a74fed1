# How a farm's jobs speak to their queue: Slurm. "umax farm" calls these functions in bash, and every job reads this
# file when it begins. For another queue write them anew, and name the file: umax farm SCENE --queue FILE.

# The programs of the queue that are called here.
queue_programs() {
  echo sbatch squeue scancel scontrol
}

# The lines at the head of a job's script. NAME of the job; LOG, the beginning of the files for what its tasks say;
# PROCESSORS and MEMORY [MiB] that a task gets, 0: as the queue gives them.
job_header() { # NAME LOG PROCESSORS MEMORY
  local log=${2//%/%%}
  log=${log//\"/\\\"}
  echo "#SBATCH --job-name=\"$1\""
  echo "#SBATCH --output=\"$log-%A-%a.log\""
  [ "$3" = 0 ] || echo "#SBATCH --cpus-per-task=$3"
  [ "$4" = 0 ] || echo "#SBATCH --mem=$4M"
  echo "# should the job before fail, this one goes, too; should a machine fail, the job begins again on another one"
  echo "#SBATCH --kill-on-invalid-dep=yes"
  echo "#SBATCH --requeue"
}

# Submits an array of TASKS tasks that run SCRIPT with the words behind it, and prints the array's number. AFTER: "-";
# "all:ID", once all tasks of that array have ended well; "each:ID:ID…", each task once those of the same index have.
# With UMAX_DRY_RUN it only prints the command.
submit() { # TASKS AFTER SCRIPT [WORD…]
  local tasks=$1 after=$2
  shift 2
  local command=(sbatch --parsable "--array=1-$tasks")
  case $after in
    all:*) command+=("--dependency=afterok:${after#all:}") ;;
    each:*) command+=("--dependency=aftercorr:${after#each:}") ;;
  esac
  if [ -n "${UMAX_DRY_RUN:-}" ]; then
    echo "${command[@]}" "${@@Q}"
    return
  fi
  local answer
  answer=$("${command[@]}" "$@") || return
  echo "${answer%%;*}" # with several clusters their name stands behind it
}

# The index of the task that calls this, from 1.
task_index() {
  echo "${SLURM_ARRAY_TASK_ID:-1}"
}

# The processors that the task which calls this was given.
task_processors() {
  echo "${SLURM_CPUS_ON_NODE:-$(nproc)}"
}

# The task that calls this, as the queue's programs name it: the number of an array's last task is that of the whole array.
own_task() {
  echo "${SLURM_ARRAY_JOB_ID:-$SLURM_JOB_ID}${SLURM_ARRAY_TASK_ID:+_$SLURM_ARRAY_TASK_ID}"
}

# How long [s] the queue lets the task which calls this go on before it cuts it off; nothing where there is no limit, or it
# does not say.
task_seconds_left() {
  local left
  [ -n "${SLURM_JOB_ID:-}" ] || return 0
  left=$(squeue --noheader --jobs="$(own_task)" --format=%L) || return 0
  [[ $left =~ ^(([0-9]+)-)?(([0-9]+):)?([0-9]+):([0-9]+)$ ]] || return 0
  echo $((10#${BASH_REMATCH[2]:-0} * 86400 + 10#${BASH_REMATCH[4]:-0} * 3600 + 10#${BASH_REMATCH[5]} * 60 + 10#${BASH_REMATCH[6]}))
}

# Puts the task that calls this back into the queue, which ends it: it begins again, and goes on, when it gets a machine.
requeue_task() {
  scontrol requeue "$(own_task)" && sleep 600
}

# One line for each task of ours that has not ended: the array's number, and in a word what it does.
unfinished_tasks() {
  squeue --noheader --array --me --format='%F %T'
}

# Takes arrays out of the queue, and ends their tasks.
cancel() { # ID…
  scancel "$@"
}
