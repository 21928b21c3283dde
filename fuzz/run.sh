#!/usr/bin/env bash
# Builds the fuzz targets with libFuzzer and runs each from its corpus. Prints the inputs, and the edges covered by the
# corpus and at the end. Stable Rust and a C++ compiler are enough.
#   fuzz/run.sh SECONDS [TARGET...]           for each target
#   fuzz/run.sh --whole SECONDS [TARGET...]   also follows edges of other authors' crates, and runs the C interface: for
#                                             long runs, because it compiles everything anew
# New inputs go to target/fuzz/TARGET, and the next run begins with them too; failing inputs to target/fuzz/failed.
set -euo pipefail
cd "$(dirname "$0")/.."

target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
# A short run begins with the same random numbers each time, so that CI does not find a fault in one run and not in the
# next. 0 is another seed each time.
build=$target profile=tests features=libfuzzer wrapper=RUSTC_WORKSPACE_WRAPPER seed=1
if [ "$1" = --whole ]; then
  shift
  build=$target/fuzz/build profile=release features=libfuzzer,c_interface wrapper=RUSTC_WRAPPER seed=0
  export RAYPATH_FUZZ_WHOLE=1
fi
seconds=$1
shift
# Cargo keeps what it compiles with a wrapper for the workspace apart, so that the other builds stay as they are.
env "$wrapper=$PWD/fuzz/rustc.sh" CARGO_INCREMENTAL=0 CARGO_TARGET_DIR="$build" \
  cargo build --profile "$profile" --locked --quiet --package raypath-fuzz --features "$features"
mkdir -p "$target/fuzz/failed"
# Readers of vectors take a path, so that their inputs are files.
if [ -d /dev/shm ]; then export TMPDIR=/dev/shm; fi
all=("$@")
if [ $# -eq 0 ]; then
  mapfile -t all < <(ls fuzz/corpus)
  [ "$build" != "$target" ] || mapfile -t all < <(ls fuzz/corpus | grep -v '^c_interface$')
fi

run() {
  local log=$target/fuzz/$1.log begin end
  mkdir -p "$target/fuzz/$1"
  # Some kilobytes for an input; a second of time, with a margin for a busy machine.
  if ! RAYPATH_FUZZ=$1 "$build/$profile/fuzz" "$target/fuzz/$1" "fuzz/corpus/$1" -seed="$seed" -max_total_time="$seconds" \
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
export build profile seconds seed target
printf '%s\0' "${all[@]}" | xargs -0 -P "$(nproc)" -I{} bash -c 'run {}'
