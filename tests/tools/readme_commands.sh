#!/usr/bin/env bash
# Runs every `umax …` command of the README in an empty folder, as a reader would, only with small pictures.
# usage: readme_commands.sh README.md PROGRAM
set -euo pipefail
readme=$(realpath "$1") program=$(realpath "$2")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# the reader's copy of the measurements that come with the program
mkdir scenes
ln -s "$(dirname "$readme")/scenes/measurements" scenes/measurements

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
# and two hexes, one of them askew, for the reader's part
cat >part.msh <<'MSH'
$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
12
1 0 0 0
2 1 0 0
3 2 0.2 0
4 0 1 0
5 1 1 0
6 2 1 0
7 0 0 1
8 1 0 1
9 2 0 1.1
10 0 1 1
11 1 1 1
12 2.1 1 1
$EndNodes
$Elements
2
1 5 2 1 1 1 2 5 4 7 8 11 10
2 5 2 1 1 2 3 6 5 8 9 12 11
$EndElements
MSH
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
    strip) words+=("${small[@]}") ;;
    turntable) words+=("${small[@]}" --frames 1-2) ;;
    tune) words+=(--size 32x18 --set clip.frames=8) ;;
    reproduce) words+=(corrections --quick) ;;  # the one experiment that takes no time
  esac
  echo "-- ${words[*]}"
  "$program" "${words[@]:1}" --quiet </dev/null || { echo "FAILED with $?: $line"; exit 1; }
  count=$((count + 1))
done <commands
[ "$count" -ge 8 ] || { echo "only $count commands found in $readme"; exit 1; }
echo "$count commands of the README run"
