# The number that a word of the command line stands for: "task" is the task's index in its array.
number() { # WORD
  if [ "$1" = task ]; then task_index; else echo "$1"; fi
}

# Puts down when and where a call of umax begins, and with which exit code it ends: umax farm status counts them.
note_call() { # CALL WORD
  echo "$(date -u +%FT%TZ) ${HOSTNAME:-unknown} $2" >>"$calls/$1"
}

# When the task has to end [s since it began]; 0: never. That is its deadline, or before the queue would cut it off, if that
# comes first, by as much as it takes to end cleanly.
task_end() {
  local end=$deadline_seconds left=
  ! declare -F task_seconds_left >/dev/null || left=$(task_seconds_left)
  if [ -n "$left" ]; then
    left=$((SECONDS + (left > 2 * spare_seconds ? left - spare_seconds : left / 2)))
    [ "$end" != 0 ] && [ "$end" -le "$left" ] || end=$((left > 0 ? left : 1))
  fi
  echo "$end"
}

# How many frames of the run, given by its number, are finished.
frames_finished() { # RUN
  find "${runs[$1 - 1]}/states" "${runs[$1 - 1]}/frames" -type f ! -name '.*' 2>/dev/null | wc -l
}

# Calls umax until it has done its work on the run of the number $run.
# 75: the time that the task has is over, and it goes back into the queue, unless nothing was finished in that time: then
# nothing ever would be; or the folder is in use: it waits, and goes on. 74, or ended by a signal: a disk, a machine's
# memory, somebody's hand; what was finished is whole, and it goes on. All others would come again: the job ends with them.
go_on() { # CALL WORD…
  local call=$1 code lost=0 waits=0 end finished left=()
  shift
  finished=$(frames_finished "$run")
  while true; do
    end=$(task_end)
    [ "$end" = 0 ] || left=(--deadline "$((SECONDS < end ? end - SECONDS : 1))")
    code=0
    note_call "$call" begins
    "$umax" "$@" --progress plain "${left[@]}" || code=$?
    note_call "$call" "$code"
    [ "$code" != 0 ] || return 0
    if [ "$code" = 75 ] && [ "$end" != 0 ] && [ "$SECONDS" -ge "$end" ]; then
      if [ "$(frames_finished "$run")" -le "$finished" ]; then
        echo "nothing was finished in the time that the task has: give it more, by --deadline or the queue's time limit"
        return "$code"
      fi
      echo "the time that the task has is over: it goes back into the queue"
      requeue_task || return
      finished=$(frames_finished "$run")
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
