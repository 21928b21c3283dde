#!/bin/sh
# rustc for fuzzing. Cargo calls it for the crates of the workspace (RUSTC_WORKSPACE_WRAPPER), so that a short run shares
# the crates of other authors with the other builds, or for all crates (RUSTC_WRAPPER). Crates that read have counters of
# edges and values of comparisons for libFuzzer, and checks of overflow. For a short run, crates that read little have
# none, and the crates of the workspace are optimised little, because the build takes longer than the run.
case " $* " in
  *' build_script_build '* | *' --crate-type proc-macro '* | *' --print='* | *' -vV '*) exec "$@" ;;
esac
case "${RAYPATH_FUZZ_WHOLE:+whole}$CARGO_PKG_NAME" in
  raypath-float | raypath-model | raypath-ops) exec "$@" -Copt-level=1 -Cdebug-assertions ;;
  raypath-embed | raypath-fuzz | raypath-hdl | raypath-oracle | raypath-rtl | raypath-timing | raypath-verify)
    exec "$@" -Copt-level=0 -Cdebug-assertions ;;
  raypath-*) optimised=-Copt-level=1 ;;
  *) optimised= ;;
esac
# shellcheck disable=SC2086 # one word or none
exec "$@" $optimised -Cdebug-assertions -Cpasses=sancov-module \
  -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
  -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares
