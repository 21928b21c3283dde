#!/usr/bin/env bash
# Every test. Installs missing programs with scripts/install-packages.sh.
#   ./test.sh                        all tests, and `raypath verify` at level regression
#   ./test.sh --quick                format, clippy and unit tests: the inner loop
#   ./test.sh --long                 also runs long tests, verifies at level full, hours, fuzzes for an hour, and checks licences
#   RAYPATH_GOLDEN=DIR ./test.sh     also replays the whole set of golden vectors in DIR
set -euo pipefail
cd "$(dirname "$0")"

level=regression
quick=false
# The profile in Cargo.toml that compiles fast. Campaigns of hours are worth optimised programs.
profile=tests
case "${1:-}" in
  '') ;;
  --quick) quick=true ;;
  --long) level=full profile=release ;;
  *) echo "test.sh: unknown argument '$1', expected --quick, --long or nothing" >&2; exit 2 ;;
esac

step() { printf '\n== %s (after %d s)\n' "$1" "$SECONDS"; }

if ! "$quick"; then
  step 'Programs'
  if [ "$level" = full ]; then scripts/install-packages.sh --long; else scripts/install-packages.sh; fi
fi

step 'Format'
cargo fmt --all --check

step 'Clippy'
# In the profile of the tests, so that macros and build scripts are compiled once.
cargo clippy --workspace --all-targets --profile "$profile" --locked -- -D warnings
# What `cargo run` compiles without `--features full`, and what a crate with an operation of its own compiles.
cargo clippy --profile "$profile" --locked -- -D warnings
cargo clippy --package raypath-cli --features workbench --profile "$profile" --locked -- -D warnings

if "$quick"; then
  step 'Unit tests'
  cargo test --workspace --lib --profile "$profile" --locked
  step 'Done'
  exit
fi

step 'Documentation'
RUSTDOCFLAGS='-D warnings' cargo doc --workspace --no-deps --profile "$profile" --locked --quiet

step 'Tests'
# Programs that Verilator compiled, for the next run: they are named by a hash of what they were compiled from.
RAYPATH_VERILATED=$(realpath -m "${CARGO_TARGET_DIR:-target}/verilated")
export RAYPATH_VERILATED
mkdir -p "$RAYPATH_VERILATED"
find "$RAYPATH_VERILATED" -type f -atime +7 -delete
# Files that examples and simulators compile with Verilator or CMake.
export OBJCACHE=ccache CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache
export CCACHE_DIR="${RAYPATH_VERILATED%verilated}ccache" CCACHE_MAXSIZE=1G
long=''
if [ "$level" = full ]; then long='-- --include-ignored'; fi
# shellcheck disable=SC2086 # $long is two words or none
cargo test --workspace --profile "$profile" --locked --no-fail-fast $long

step 'Python'
export RAYPATH_PROFILE=$profile
if [ "$level" = full ]; then scripts/test-python.sh -m 'long or not long'; else scripts/test-python.sh; fi

step 'Verification'
# The program that the tests were made with: `cargo run` would compile it once more, without the feature `full`.
"${CARGO_TARGET_DIR:-target}/$profile/raypath" verify --level "$level"

step 'Fuzzing'
# At level full an hour in all, on two cores.
if [ "$level" = full ]; then fuzz/run.sh --whole 260; else fuzz/run.sh 2; fi

if [ "$level" = full ]; then
  step 'Licences'
  command -v cargo-deny >/dev/null || cargo install cargo-deny --locked
  cargo deny check bans licenses sources
fi

step 'Done'
