# The number that a word of the command line stands for: "task" is the task's index in its array.
number() { # WORD
  if [ "$1" = task ]; then task_index; else echo "$1"; fi
}

# Puts down when and where a call of umax begins, and with which exit code it ends: umax farm status counts them.
note_call() { # CALL WORD
  echo "$(date -u +%FT%TZ) ${HOSTNAME:-unknown} $2" >>"$calls/$1"
}

# Calls umax until it has done its work.
# 75: the time that the queue gives is nearly over, and the task goes back into the queue; or the folder is in use: it
# waits, and goes on. 74, or ended by a signal: a disk, a machine's memory, somebody's hand; what was finished is whole, and
# it goes on. All others would come again: the job ends with them.
go_on() { # CALL WORD…
  local call=$1 code lost=0 waits=0 left=()
  shift
  while true; do
    # since the task began
    [ "$deadline_seconds" = 0 ] || left=(--deadline "$((SECONDS < deadline_seconds ? deadline_seconds - SECONDS : 1))")
    code=0
    note_call "$call" begins
    "$umax" "$@" --progress plain "${left[@]}" || code=$?
    note_call "$call" "$code"
    [ "$code" != 0 ] || return 0
    if [ "$code" = 75 ] && [ "$deadline_seconds" != 0 ] && [ "$SECONDS" -ge "$deadline_seconds" ]; then
      echo "the deadline is over: the task goes back into the queue"
      requeue_task || return
    elif [ "$code" = 75 ]; then
      [ "$((waits += 1))" -le "$most_waits" ] || return "$code"
      sleep "$wait_seconds"
    elif [ "$code" = 74 ] || [ "$code" -gt 128 ]; then
      [ "$((lost += 1))" -le "$most_lost" ] || return "$code"
      echo "umax ended with exit code $code; it goes on ($lost of at most $most_lost times)"
      sleep "$lost"
    else
      return "$code"
    fi
  done
}
