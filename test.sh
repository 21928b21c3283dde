#!/usr/bin/env bash
# Every test. Installs the programs that it needs where it can, and says what is missing where it cannot.
#   ./test.sh                        every test but the long ones, some minutes
#   ./test.sh --long                 also verifies at level full, about an hour
#   RAYPATH_GOLDEN=DIR ./test.sh     also replays the whole set of golden vectors in DIR
set -euo pipefail
cd "$(dirname "$0")"

is_long=false
case "${1:-}" in
  '') ;;
  --long) is_long=true ;;
  *) echo "test.sh: unknown argument '$1', expected --long or nothing" >&2; exit 2 ;;
esac

step() { printf '\n== %s (after %d s)\n' "$1" "$SECONDS"; }

# ensure_debian WHAT PACKAGE: installs PACKAGE with apt-get unless WHAT, a program or a file by its path, is there.
ensure_debian() {
  is_there "$1" && return
  local root=()
  [ "$(id -u)" = 0 ] || root=(sudo -n)
  if command -v apt-get >/dev/null; then
    echo "installing $2"
    "${root[@]}" apt-get update -qq && "${root[@]}" apt-get install -y -qq "$2" >/dev/null || true
  fi
  is_there "$1" && return
  echo "test.sh: $1 is missing and could not be installed; try: sudo apt-get install $2" >&2
  exit 1
}

is_there() { command -v "$1" >/dev/null || [ -f "$1" ]; }

# ensure_python MODULE PACKAGE: installs PACKAGE with pip unless Python has MODULE.
ensure_python() {
  python3 -c "import $1" 2>/dev/null && return
  echo "installing $2"
  python3 -m pip install --quiet "$2" 2>/dev/null || python3 -m pip install --quiet --break-system-packages "$2" || true
  python3 -c "import $1" 2>/dev/null && return
  echo "test.sh: the Python module $1 is missing and could not be installed; try: python3 -m pip install $2" >&2
  exit 1
}

step 'Programs'
if ! command -v cargo >/dev/null; then
  echo 'test.sh: cargo is missing; install Rust 1.95 or newer' >&2
  exit 1
fi
ensure_debian c++ g++
ensure_debian make make
ensure_debian verilator verilator
ensure_debian yosys yosys
ensure_debian sta opensta
ensure_debian chromium chromium
ensure_debian /usr/share/qflow/tech/osu018/osu018_stdcells.lib qflow-tech-osu018
ensure_debian python3 python3
python3 -m pip --version >/dev/null 2>&1 || ensure_debian pip3 python3-pip
ensure_python pyslang pyslang
ensure_python pyosys pyosys
ensure_python fusesoc fusesoc
ensure_python cocotb 'cocotb<2'

step 'Format'
cargo fmt --all --check

step 'Clippy'
# In the profile of the tests, so that macros and build scripts are compiled once.
cargo clippy --workspace --all-targets --release --locked -- -D warnings

step 'Documentation'
RUSTDOCFLAGS='-D warnings' cargo doc --workspace --no-deps --release --locked --quiet

step 'Tests'
cargo test --workspace --release --locked

step 'Verification'
level=regression
if "$is_long"; then level=full; fi
# The program that the tests were made with; `cargo run` would compile most of it once more, with other features.
"${CARGO_TARGET_DIR:-target}/release/raypath" verify --level "$level"

step 'Done'
