#!/bin/sh
# rustc for fuzzing, which Cargo calls for all crates (RUSTC_WRAPPER). Crates have counters of edges and values of
# comparisons for libFuzzer, and checks of overflow.
case " $* " in
  *' build_script_build '* | *' --crate-type proc-macro '* | *' --print='* | *' -vV '*) exec "$@" ;;
esac
exec "$@" -Cdebug-assertions -Cpasses=sancov-module \
  -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
  -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares
