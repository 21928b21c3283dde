#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
# Tests registers, rings, driver and model of the device: examples/device/run.sh [EPISODES [SEED]]
# EPISODES (2000) of the rings, for each of two widths of the memory; below 1000 for one, from 10000 on for four.
#   VERILATOR='PROGRAM'  from 5.006 on
#   PYTHON='PROGRAM'     with the packages peakrdl 1.5.0 and peakrdl-regblock 1.3.1
# The model needs libraypath: scripts/install-libraypath.sh PREFIX, then PKG_CONFIG_PATH=PREFIX/lib/pkgconfig.
set -euo pipefail
cd "$(dirname "$0")/../.."
episodes=${1:-2000} seed=${2:-1}
for number in "$episodes" "$seed"; do
  [[ $number =~ ^[1-9][0-9]*$ ]] || { echo "run.sh: '$number', expected a number from 1 on" >&2; exit 2; }
done
verilator=${VERILATOR:-verilator} python=${PYTHON:-python3}
here=examples/device rtl=crates/raypath-traversal/src build=build/device
mkdir -p "$build"
missing=0
not_run() { echo "$1: not run: $2" >&2; missing=1; }

for tool in "$verilator" cc c++ make; do
  command -v "$tool" >/dev/null || { echo "run.sh: found no program $tool, which all parts need" >&2; exit 1; }
done
# Compiling takes longer than simulating. C flags are before those of Verilator.
export MAKEFLAGS='OPT_FAST=-O1 OPT_SLOW=-O0 OPT_GLOBAL=-O0 VM_PARALLEL_BUILDS=0'
cc -O1 -std=c99 -Wall -Wextra -Werror -c software/raypath_driver.c -o "$build/driver.o"

# compile NAME TOP ARGUMENT...: the program build/device/NAME/VTOP.
compile() {
  local name=$1 top=$2
  shift 2
  "$verilator" --cc --exe --build -j 2 -Wno-fatal -Wno-WIDTH -Wno-PINCONNECTEMPTY --assert --Mdir "$build/$name" \
    --top-module "$top" "$@" >"$build/$name.log" 2>&1 || { cat "$build/$name.log" >&2; exit 1; }
}

if "$python" -c 'import peakrdl, peakrdl_regblock, systemrdl' 2>/dev/null; then
  "$python" scripts/registers.py --check
  "$python" -m peakrdl regblock "$rtl/system/rtl/raypath_device.rdl" -o "$build/peakrdl" --cpuif axi4-lite-flat \
    --default-reset arst_n --addr-width 12 --type-style hier --rename raypath_device_registers_peakrdl
  compile registers registers "$build"/peakrdl/*_pkg.sv "$build/peakrdl/raypath_device_registers_peakrdl.sv" \
    "$rtl/system/rtl/raypath_device_registers.sv" "$here/registers.sv" "$PWD/$here/registers.cpp" \
    -CFLAGS "-I$PWD/software"
  "$build/registers/Vregisters" "$((10 * episodes))" "$seed"
else
  not_run registers "pip install peakrdl==1.5.0 peakrdl-regblock==1.3.1, or set PYTHON to a Python that has both"
fi

widths=(128:32)
[ "$episodes" -lt 1000 ] || widths+=(1024:40)
[ "$episodes" -lt 10000 ] || widths+=(256:33 512:64)
for width in "${widths[@]}"; do
  data=${width%:*} address=${width#*:}
  compile "rings_$data" rings "-GDataWidth=$data" "-GAddressWidth=$address" \
    crates/raypath-hdl/src/verilog/raypath_ram_1r1w.sv "$rtl/hardware/raypath_queue.sv" \
    "$rtl/system/rtl/raypath_device_registers.sv" "$rtl/system/rtl/raypath_rings.sv" "$here/rings.sv" \
    "$PWD/$here/rings.cpp" "$PWD/$build/driver.o" -CFLAGS "-I$PWD/software -DDATA_WIDTH=$data -DADDRESS_WIDTH=$address"
  "$build/rings_$data/Vrings" "$episodes" "$seed"
done

if pkg-config --exists raypath 2>/dev/null; then
  # shellcheck disable=SC2046 # several words
  cc -O1 -std=c11 -Wall -Wextra -Isoftware $(pkg-config --cflags raypath) "$here/model.c" "$build/driver.o" \
    $(pkg-config --libs raypath) "-Wl,-rpath,$(pkg-config --variable=libdir raypath)" -o "$build/model"
  "$build/model"
else
  not_run model "scripts/install-libraypath.sh PREFIX, then PKG_CONFIG_PATH=PREFIX/lib/pkgconfig"
fi
exit "$missing"
