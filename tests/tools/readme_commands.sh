#!/usr/bin/env bash
# Runs every `umax …` command of the README in an empty folder, as a reader would, only with small pictures.
# usage: readme_commands.sh README.md PROGRAM
set -euo pipefail
readme=$(realpath "$1") program=$(realpath "$2")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# the reader's mesh: an octahedron stands in for the cow
cat >cow.obj <<'OBJ'
v 1 0 0
v -1 0 0
v 0 1 0
v 0 -1 0
v 0 0 1
v 0 0 -1
f 1 3 5
f 3 2 5
f 2 4 5
f 4 1 5
f 3 1 6
f 2 3 6
f 4 2 6
f 1 4 6
OBJ
# the README's scene file
awk '/^```toml/ { inside = 1; next } /^```/ { inside = 0 } inside' "$readme" >cow.toml

awk '/^```sh/ { inside = 1; next } /^```/ { inside = 0 } inside' "$readme" | grep '^umax ' >commands

small=(--samples 1 --size 64x36)
count=0
while read -r line; do
  line=${line%%#*}
  eval "words=($line)"
  case "${words[1]}" in
    run | drop)
      words+=("${small[@]}")
      [[ "$line" == *--frames* ]] || words+=(--frames 60)  # simulates up to 60, draws that one
      ;;
    turntable) words+=("${small[@]}" --frames 1-2) ;;
  esac
  echo "-- ${words[*]}"
  "$program" "${words[@]:1}" --quiet </dev/null || { echo "FAILED with $?: $line"; exit 1; }
  count=$((count + 1))
done <commands
[ "$count" -ge 8 ] || { echo "only $count commands found in $readme"; exit 1; }
echo "$count commands of the README run"
