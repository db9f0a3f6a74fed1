#!/usr/bin/env bash
# tools/lint --format passes a well-formatted file and refuses a badly formatted one, by name.
# usage: lint_format.sh SOURCE_FOLDER
set -euo pipefail
house=$(mktemp -d)
trap 'rm -rf "$house"' EXIT
mkdir "$house/tools" "$house/core" "$house/build"
cp "$1"/.clang-format "$house"
cp "$1"/tools/{lint,install.sh,packages*} "$house/tools"

fail() { echo "lint_format: $1" >&2; cat "$house/output" >&2; exit 1; }
lint() { "$house/tools/lint" --format "$@" >"$house/output" 2>&1; }

echo 'int twice(int number) { return 2*number ; }' >"$house/build/generated.cpp"
printf 'int twice(int number) {\n  return 2 * number;\n}\n' >"$house/core/good.cpp"
lint || fail "a well-formatted file is refused"

echo 'int twice(int number) { return 2*number ; }' >"$house/core/bad.h"
code=0
lint || code=$?
[ "$code" = 1 ] || fail "a badly formatted file ends in $code"
grep -q 'core/bad.h:1' "$house/output" || fail "the badly formatted file is not named"
lint "$house/core/good.cpp" || fail "a file is refused for another"

code=0
lint --fromat || code=$?
[ "$code" = 2 ] || fail "an unknown option ends in $code"
