#!/usr/bin/env bash
# Builds the bench around a traversal unit with Verilator, and runs it: examples/agent/run.sh [FOLDER [PLUSARG...]]
# What FOLDER (build/agent) lacks of the files of `raypath generate --unit`, unit.toml (the same configuration for
# libraypath), scene.bin and rays.txt is made: a unit with barycentrics, and the mesh Suzanne.
#   RAYPATH='PROGRAM'    the program raypath; else Cargo builds it
#   VERILATOR='PROGRAM'  from 5.052 on, the covergroups are compiled
set -euo pipefail
folder=$(realpath -m "${1:-build/agent}")
[ $# = 0 ] || shift
cd "$(dirname "$0")/../.."
here=$PWD/examples/agent
build=$folder/bench
mkdir -p "$build"
raypath() { ${RAYPATH:-cargo raypath} "$@" >>"$build/log"; }
verilator=${VERILATOR:-verilator}

mesh=$folder/suzanne.ply
[ -f "$mesh" ] || gunzip -c crates/raypath-render/tests/data/suzanne.ply.gz >"$mesh"
[ -f "$folder/raypath_unit.f" ] || raypath generate --unit --barycentrics --rays 50 --out "$folder"
[ -f "$folder/unit.toml" ] || printf 'barycentrics = true\nnode-limit = 40\n' >"$folder/unit.toml"
[ -f "$folder/scene.bin" ] || raypath scene "$mesh" --out "$folder/scene.bin"
[ -f "$folder/rays.txt" ] || raypath render "$mesh" --through unit --no-timing --size "${SIZE:-60x45}" \
  --camera-rays "$folder/rays.txt" --hits "$folder/hits.txt" --out "$folder/model.png"
if ! pkg-config --exists raypath; then
  export PKG_CONFIG_PATH=$folder/libraypath/lib/pkgconfig
  [ -d "$folder/libraypath" ] || scripts/install-libraypath.sh "$folder/libraypath" >>"$build/log"
fi

# The ports of the unit, and the widths of four of them, of which some are parameters.
unit=$folder/rtl/raypath_unit.sv
parameter() { sed -n "s/^  parameter *logic \[31:0\] $1 *= *\([0-9]*\).*/\1/p" "$unit"; }
context=0
while (((1 << context) < $(parameter Contexts))); do context=$((context + 1)); done
ports=$(sed -n "/^) (/,/^);/{s/ContextWidth-1/$((context - 1))/;s/IdWidth-1/$(($(parameter IdWidth) - 1))/
  s/AddressWidth-1/$(($(parameter AddressWidth) - 1))/
  s/^ *\(input\|output\) *logic *\(\[\([^:]*\):0\]\)\? *\([a-z_0-9]*\).*/\4 \3/p}" "$unit")
awk '{ print (NR > 1 ? ", ." : ".") $1 "(bus." $1 ")" }' <<<"$ports" >"$build/raypath_unit_ports.svh"
options=$(awk 'BEGIN { name["ray_id_i"] = "Id"; name["mem_req_tag_o"] = "Tag"; name["mem_req_addr_o"] = "Address"
  name["mem_rsp_data_i"] = "Memory" } $1 in name { print "-G" name[$1] "Width=" $2 + 1 }' <<<"$ports")
version=$("$verilator" --version | sed -n 's/^Verilator \([0-9.]*\).*/\1/p')
if [[ $version > 5.051 ]]; then
  options+=' -DRAYPATH_COVERGROUPS --coverage-user'
  set -- "+verilator+coverage+file+$build/coverage.dat" "$@"
fi

# Compiling takes longer than simulating: each module once, all in one file, without optimisation of the C++.
export MAKEFLAGS='OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0 VM_PARALLEL_BUILDS=0'
cd "$folder" # and paths below it, so that ccache knows the files of another folder
# shellcheck disable=SC2046,SC2086 # several words
{
  cc -O1 -Wall -Wextra -Werror -c "$here/raypath_agent.c" -o "$build/raypath_agent.o" \
    $(pkg-config --cflags raypath) -I"$("$verilator" --getenv VERILATOR_ROOT)/include/vltstd"
  "$verilator" --binary --timing --assert -j 2 -O3 -fno-inline -Wno-WIDTH --output-split 1000000000 --Mdir bench \
    --top-module bench $options -Ibench $(cat raypath_unit.f) raypath_properties.sv \
    "$here"/{raypath_agent_pkg,raypath_unit_if,raypath_agent{,_driver,_memory,_scoreboard,_coverage},bench}.sv \
    -LDFLAGS "$build/raypath_agent.o $(pkg-config --libs raypath) -Wl,-rpath,$(pkg-config --variable=libdir raypath)"
} >>"$build/log" 2>&1 || { cat "$build/log" >&2; exit 1; }
# The port node_limit_i is a parameter of the model.
limit=$(sed -n 's/^node-limit *= *//p' "$folder/unit.toml")
exec "$build/Vbench" "+folder=$folder" "+node_limit=${limit:-16777216}" "$@"
