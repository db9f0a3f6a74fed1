#!/usr/bin/env bash
# Runs every `umax …` command of pages as a reader would, only with small pictures: each page's in order, in a folder of
# its own that holds cow.obj, part.msh and the page's scenes. Other commands are scripts of the project, which must be there.
# usage: page_commands.sh PROGRAM [PAGE…]    without pages: all of the project's
set -euo pipefail
program=$(realpath "$1")
shift
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
[ $# -gt 0 ] || set -- "$root"/*.md "$root"/docs/*.md
mapfile -t pages < <(realpath "$@")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
small=(--samples 1 --size 64x36)

# the lines of a page's blocks of a language
blocks() { # LANGUAGE PAGE
  awk -v fence="\`\`\`$1" '$0 == fence { inside = 1; next } /^```/ { inside = 0 } inside' "$2"
}

# what the reader has
make_files() { # PAGE
  # the measurements that come with the program
  mkdir scenes
  ln -s "$root/scenes/measurements" scenes/measurements
  # a mesh: an octahedron stands in for the cow
  cp "$root/tests/support/octahedron.obj" cow.obj
  # and two hexes, one of them askew
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
  # the page's scenes: blocks that begin with "# NAME.toml"
  awk '$0 == "```toml" { first = 1; next } /^```/ { name = "" } first { name = $2; first = 0 } name { print > name }' "$1"
}

# a command with what makes it quick
run() { # LINE
  local line=${1%%#*}
  local words
  eval "words=($line)"
  case "${words[1]}" in
    presets | scenes | help) ;;
    live) words+=(--no-browser) ;;
    *) words+=(--quiet) ;;
  esac
  case "${words[1]}" in
    run | drop)
      words+=("${small[@]}")
      # a run is simulated up to frame 60, which later commands ask for, and that one is drawn
      case "$line" in
        *--frames*) ;;
        "umax run cow"*) words+=(--frames 60) ;;
        *) words+=(--frames 20) ;;
      esac
      ;;
    render | strip) words+=("${small[@]}") ;;
    turntable) words+=("${small[@]}" --frames 1-2) ;;
    tune) words+=(--size 32x18 --set clip.frames=8) ;;
    aim) words+=("${small[@]}") ;;
    farm) case "${words[2]}" in status | cancel) ;; *) words+=("${small[@]}") ;; esac ;;
    reproduce) words+=(corrections --quick) ;;  # the one experiment that takes no time
  esac
  echo "-- ${words[*]}"
  if [ "${words[1]}" = live ]; then  # until it is told to end
    local code=0
    timeout --preserve-status -s INT 6 "$program" "${words[@]:1}" </dev/null || code=$?
    [ "$code" = 130 ] || { echo "FAILED with $code: $line"; exit 1; }
    return
  fi
  "$program" "${words[@]:1}" </dev/null || { echo "FAILED with $?: $line"; exit 1; }
}

total=0
for page in "${pages[@]}"; do
  folder=$scratch/$(basename "$page" .md)
  mkdir "$folder"
  cd "$folder"
  make_files "$page"
  count=0
  while read -r line; do
    case "$line" in
      "" | "#"*) ;;
      "umax "*)
        run "$line"
        count=$((count + 1))
        ;;
      tools/*) [ -x "$root/${line%%[ #]*}" ] || { echo "FAILED: no such script: $line"; exit 1; } ;;
      cmake*) ;;
      *) echo "FAILED: neither a command of umax nor a script: $line"; exit 1 ;;
    esac
  done < <(blocks sh "$page")
  echo "$count commands of $(basename "$page") run"
  total=$((total + count))
done
[ "$total" -ge 1 ] || { echo "no command found"; exit 1; }
