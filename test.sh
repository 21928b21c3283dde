#!/usr/bin/env bash
# Every test. Installs missing programs with scripts/install-packages.sh.
#   ./test.sh                        all tests, and today's tenth of `raypath verify` at level regression
#   ./test.sh --quick                format, clippy and unit tests: the inner loop
#   ./test.sh --long                 also runs long tests, verifies at level full, hours, fuzzes for an hour, and checks licences
#   RAYPATH_GOLDEN=DIR ./test.sh     also replays the whole set of golden vectors in DIR
# The table at the end has the time of each step; target/test-times.json has it for programs.
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

target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
mkdir -p "$target"
times_file=$target/test-times.txt
: >"$times_file"
name=''
wall=0
cpu=0

# step NAME: ends the step before, and begins this one.
step() {
  local now
  times >"$target/times" # not in a subshell, which would count its own programs
  now=$(sed -n 2p "$target/times" | awk '{ for (i = 1; i <= NF; i++) { split($i, p, /[ms]/); s += p[1] * 60 + p[2] } print s }')
  if [ -n "$name" ]; then
    printf '%s\t%d\t%.0f\n' "$name" "$((SECONDS - wall))" "$(echo "$now $cpu" | awk '{ print $1 - $2 }')" >>"$times_file"
  fi
  name=$1 wall=$SECONDS cpu=$now
  printf '\n== %s (after %d s)\n' "$name" "$SECONDS"
}

# The table of times, also after a failure.
report() {
  local status=$?
  [ -z "$name" ] || step 'End' >/dev/null
  awk -F'\t' '
    BEGIN { printf "\n%-24s %10s %10s\n", "step", "wall s", "CPU s" }
    { printf "%-24s %10d %10d\n", $1, $2, $3; wall += $2; cpu += $3 }
    END { printf "%-24s %10d %10d\n", "all", wall, cpu }' "$times_file"
  awk -F'\t' '
    BEGIN { printf "[" }
    { printf "%s\n  {\"step\": \"%s\", \"wall\": %d, \"cpu\": %d}", separator, $1, $2, $3; separator = "," }
    END { print "\n]" }' "$times_file" >"$target/test-times.json"
  [ "$status" = 0 ] || echo "test.sh: failed in step '$(tail -n 1 "$times_file" | cut -f 1)'" >&2
}
trap report EXIT

if ! "$quick"; then
  step 'Programs'
  if [ "$level" = full ]; then scripts/install-packages.sh --long; else scripts/install-packages.sh; fi
fi

step 'Format'
cargo fmt --all --check

step 'Clippy'
# In the profile of the tests, so that macros and build scripts are compiled once.
cargo clippy --workspace --all-targets --profile "$profile" --locked -- -D warnings
# What `cargo run` compiles without `--features full`.
cargo check --profile "$profile" --locked

if "$quick"; then
  step 'Unit tests'
  cargo test --workspace --lib --profile "$profile" --locked
  exit
fi

step 'Documentation'
RUSTDOCFLAGS='-D warnings' cargo doc --workspace --no-deps --profile "$profile" --locked --quiet

# Programs that Verilator compiled, for the next run: they are named by a hash of what they were compiled from.
export RAYPATH_VERILATED=$target/verilated
mkdir -p "$RAYPATH_VERILATED"
find "$RAYPATH_VERILATED" -type f -atime +7 -delete
# Files that examples and simulators compile with Verilator or CMake.
export OBJCACHE=ccache CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache
export CCACHE_DIR="$target/ccache" CCACHE_MAXSIZE=1G
# Tests compile in temporary folders, whose names are not part of what is compiled.
export CCACHE_BASEDIR=${TMPDIR:-/tmp} CCACHE_NOHASHDIR=true

step 'Compiling the tests'
cargo test --workspace --profile "$profile" --locked --no-run

step 'Tests'
long=''
if [ "$level" = full ]; then long='-- --include-ignored'; fi
# shellcheck disable=SC2086 # $long is two words or none
cargo test --workspace --profile "$profile" --locked --no-fail-fast $long

step 'Python'
export RAYPATH_PROFILE=$profile
if [ "$level" = full ]; then scripts/test-python.sh -m 'long or not long'; else scripts/test-python.sh; fi

step 'Verification'
# The program that the tests were made with: `cargo run` would compile it once more, without the feature `full`.
"$target/$profile/raypath" verify --level "$level"

if [ "$level" = full ]; then
  step 'Fuzzing'
  fuzz/run.sh 260
  step 'Features'
  # What a crate with an operation of its own compiles.
  cargo check --package raypath-cli --features workbench --profile "$profile" --locked
  examples/within_radius/bindings/try.sh "$target/python/venv/bin/python"
  step 'Licences'
  command -v cargo-deny >/dev/null || cargo install cargo-deny --locked
  cargo deny check bans licenses sources
fi
