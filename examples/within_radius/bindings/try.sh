#!/usr/bin/env bash
# Builds the library for C and the module for Python, and runs a job through each.
#   ./try.sh PYTHON     the interpreter, which has the package raypath of the same release
set -euo pipefail
python=$(command -v "$1")
python=$(cd "$(dirname "$python")" && pwd)/$(basename "$python")
cd "$(dirname "$0")"
profile=${RAYPATH_PROFILE:-release}
library=$(realpath -m "${CARGO_TARGET_DIR:-../../../target}")/$profile
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT

cargo build --profile "$profile" --locked --quiet --features c
# It is libraypath, with one operation more.
cp "$library/libwithin_radius.so" "$folder/libraypath.so.1"
cc -std=c11 -Wall -Wextra -Werror -I ../../../crates/raypath-capi/include example.c "$folder/libraypath.so.1" \
  -Wl,-rpath,"$folder" -o "$folder/example"
"$folder/example" | tee "$folder/c"

cargo build --profile "$profile" --locked --quiet --features python
cp "$library/libwithin_radius.so" "$folder/within_radius.abi3.so"
PYTHONPATH=$folder "$python" example.py | tee "$folder/python"

grep -qx 'near, as four bits: 3' "$folder/c"
cmp "$folder/c" "$folder/python"
