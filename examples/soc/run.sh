#!/usr/bin/env bash
# Builds a LiteX system with raypath_device, and draws a picture with it: examples/soc/run.sh [sim|ulx3s [FOLDER]]
#   sim    (default) in Verilator, and compares hits and picture with the model's
#   ulx3s  builds the bitstream of the same system for the board
# What FOLDER (build/soc) lacks of the files of `raypath generate --unit`, scene.bin, rays.txt and hits.txt is made.
#   RAYPATH='PROGRAM'  the program raypath; else Cargo builds it
#   PYTHON='PROGRAM'   a Python with the packages of requirements.txt; else they are installed below FOLDER
#   SIZE='32x24'       of the picture
set -euo pipefail
board=${1:-sim}
[[ $board == sim || $board == ulx3s ]] || { echo "run.sh: '$board', expected sim or ulx3s" >&2; exit 2; }
folder=$(realpath -m "${2:-build/soc}")
cd "$(dirname "$0")/../.."
mkdir -p "$folder"
raypath() { ${RAYPATH:-cargo raypath} "$@" >>"$folder/log"; }
need() { "${@:2}" >/dev/null 2>&1 || { echo "missing: $1" >&2; exit 2; }; }

need "riscv64-unknown-elf-gcc (Debian: gcc-riscv64-unknown-elf)" command -v riscv64-unknown-elf-gcc
if [ "$board" = sim ]; then
  need "Verilator 5 (Debian: verilator)" command -v verilator
  need "libevent (Debian: libevent-dev)" pkg-config --exists libevent
  need "json-c (Debian: libjson-c-dev)" pkg-config --exists json-c
fi
python=${PYTHON:-$folder/venv/bin/python}
if [ -z "${PYTHON:-}" ] && [ ! -f "$folder/venv/complete" ]; then
  python3 -m venv "$folder/venv"
  "$python" -m pip install -q --disable-pip-version-check -r examples/soc/requirements.txt
  touch "$folder/venv/complete"
fi
need "the packages of examples/soc/requirements.txt in $python" "$python" -c 'import litex, litex_boards'

size=${SIZE:-32x24}
mesh=$folder/teapot.obj
[ -f "$mesh" ] || gunzip -c crates/raypath-render/tests/data/teapot.obj.gz >"$mesh"
[ -f "$folder/raypath_device.f" ] || raypath generate --unit --preset compact --interval 4 --multiplier inferred \
  --contexts 8 --stack 4 --memory-width 128 --rays 100 --out "$folder"
[ -f "$folder/scene.bin" ] || raypath scene "$mesh" --out "$folder/scene.bin"
[ -f "$folder/hits.txt" ] || raypath render "$mesh" --through unit --no-timing --size "$size" \
  --camera-rays "$folder/rays.txt" --hits "$folder/hits.txt" --out "$folder/model.png"
"$python" examples/soc/soc.py "$folder" --board "$board"
[ "$board" = sim ] || exit 0
raypath render "$mesh" --draw "$folder/soc-hits.txt" --size "$size" --out "$folder/soc.png"
cmp "$folder/model.png" "$folder/soc.png"
echo "the picture $folder/soc.png is the model's"
