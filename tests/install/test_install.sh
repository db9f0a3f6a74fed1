#!/usr/bin/env bash
# Installs the build into a prefix, moves that, and uses it as others do: the program, the Python module, and a project of
# CMake with default flags, Debug and Release.
# usage: test_install.sh BUILD_FOLDER SOURCE_FOLDER CMAKE
set -euo pipefail
build=$1 source=$2 cmake=$3
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
fail() { echo "FAILED: $*"; exit 1; }

"$cmake" --install "$build" --prefix "$scratch/first" >"$scratch/install.log" || { cat "$scratch/install.log"; exit 1; }
mv "$scratch/first" "$scratch/prefix"
prefix=$scratch/prefix
cd "$scratch"

# the program, with its helper, its pages and licences
[ "$("$prefix/bin/umax" --version | head -1)" = "$("$build/bin/umax" --version | head -1)" ] || fail "another version"
"$prefix/bin/umax" doctor >doctor.txt || true
grep -q "umax-import reads" doctor.txt || { cat doctor.txt; fail "the helper program is not found"; }
for file in share/man/man1/umax.1 share/bash-completion/completions/umax share/zsh/site-functions/_umax \
  share/umax/scenes/figure.toml share/umax/scenes/presets.toml share/doc/umax/LICENSE share/doc/umax/GPL-3 \
  share/doc/umax/copyright; do
  [ -s "$prefix/$file" ] || fail "$file is missing"
done

# headers: the interface, and no more
for header in core/step/step.h tools/setup/stepping.h; do
  [ -s "$prefix/include/umax/$header" ] || fail "$header is missing"
done
for header in core/step/exact_step.h core/linear tools/run tools/cli; do
  [ ! -e "$prefix/include/umax/$header" ] || fail "$header is installed"
done

# the Python module, which reads a mesh by the helper program
if ls "$prefix"/lib/python*/site-packages/umax >/dev/null 2>&1; then
  printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n' >mesh.obj
  cat >mesh.gltf <<'GLTF'
{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
               {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
 "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
 "buffers": [{"byteLength": 72, "uri": "tetrahedron.bin"}]}
GLTF
  PYTHONPATH=$(echo "$prefix"/lib/python*/site-packages) /usr/bin/python3 -B - <<'PYTHON'
import struct
open("tetrahedron.bin", "wb").write(struct.pack("<12f12H", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3))
import umax
simulation = umax.Simulation({"body": {"a": {"mesh": "mesh.gltf", "cage.cells": 8}}})
simulation.step()
assert len(simulation.surface()) == 4
PYTHON
fi

# a project that uses the libraries
awk '$0 == "```cpp" { inside = 1; next } /^```/ { inside = 0 } inside' "$source/docs/library.md" >example.cpp
awk '$0 == "```text" { inside = 1; next } /^```/ { inside = 0 } inside' "$source/docs/library.md" >expected.txt
[ "$(wc -l <example.cpp)" -le 40 ] || fail "the example of docs/library.md has grown"
for kind in Debug Release; do
  "$cmake" -G Ninja -S "$source/tests/install" -B "$kind" -DCMAKE_BUILD_TYPE=$kind -DCMAKE_PREFIX_PATH="$prefix" \
    -DEXAMPLE="$scratch/example.cpp" -DCMAKE_EXE_LINKER_FLAGS=-Wl,--as-needed >configure.log 2>&1 || { cat configure.log; fail "$kind cannot be configured"; }
  "$cmake" --build "$kind" >build.log 2>&1 || { cat build.log; fail "$kind cannot be built"; }
  # whichever BLAS the machine prefers, also where the linker drops what nothing calls
  readelf -d "$kind/box_on_plane" | grep -q 'NEEDED.*libopenblas' || fail "$kind does without OpenBLAS"
  "$kind/box_on_plane" | tee box.txt
  awk '!($3 > 0.5 && $3 <= 1.001 && $4 > 0 && $6 == 0) { exit 1 }' FS='[ ,]+' box.txt || fail "the box in $kind"
  "$kind/example" >printed.txt
  diff expected.txt printed.txt || fail "the example of docs/library.md prints something else in $kind"
  cp box.txt "$kind.txt"
done
cmp Debug.txt Release.txt || fail "Debug and Release step apart"
OPENBLAS_NUM_THREADS=1 Release/scene_steps beam >lowest.txt || fail "the scene"
echo passed
