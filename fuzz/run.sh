#!/usr/bin/env bash
# Builds the fuzz targets with libFuzzer and runs each from its corpus. Prints the inputs, and the edges covered by the
# corpus and at the end. Stable Rust and a C++ compiler are enough.
#   fuzz/run.sh SECONDS [TARGET...]
# It compiles everything anew, for the counters. New inputs go to target/fuzz/TARGET, and the next run begins with them
# too; failing inputs to target/fuzz/failed.
set -euo pipefail
cd "$(dirname "$0")/.."

target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
build=$target/fuzz/build seconds=$1
shift
RUSTC_WRAPPER=$PWD/fuzz/rustc.sh CARGO_INCREMENTAL=0 CARGO_TARGET_DIR=$build \
  cargo build --release --locked --quiet --package raypath-fuzz --features libfuzzer
mkdir -p "$target/fuzz/failed"
# Readers of vectors take a path, so that their inputs are files.
if [ -d /dev/shm ]; then export TMPDIR=/dev/shm; fi
all=("$@")
[ $# -gt 0 ] || mapfile -t all < <(ls fuzz/corpus)

run() {
  local log=$target/fuzz/$1.log begin end
  mkdir -p "$target/fuzz/$1"
  # Some kilobytes for an input; a second of time, with a margin for a busy machine.
  if ! RAYPATH_FUZZ=$1 "$build/release/fuzz" "$target/fuzz/$1" "fuzz/corpus/$1" -max_total_time="$seconds" \
    -max_len=16384 -timeout=20 -rss_limit_mb=1024 -malloc_limit_mb=512 -artifact_prefix="$target/fuzz/failed/$1-" \
    >"$log" 2>&1; then
    tail -n 40 "$log" >&2
    echo "fuzz: $1 fails; its input is in $target/fuzz/failed" >&2
    return 1
  fi
  begin=$(sed -n 's/.*INITED cov: \([0-9]*\).*/\1/p' "$log")
  end=$(sed -n 's/.*DONE   *cov: \([0-9]*\).*/\1/p' "$log")
  printf '  %-18s %9s inputs, %6s edges by the corpus, %6s at the end\n' "$1" \
    "$(sed -n 's/^Done \([0-9]*\) runs.*/\1/p' "$log")" "$begin" "$end"
}
export -f run
export build seconds target
printf '%s\0' "${all[@]}" | xargs -0 -P "$(nproc)" -I{} bash -c 'run {}'
