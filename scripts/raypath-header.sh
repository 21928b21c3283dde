#!/usr/bin/env bash
# Generates crates/raypath-capi/include/raypath.h with cbindgen, which it installs to target/tools if it is missing.
#   scripts/raypath-header.sh            writes the header
#   scripts/raypath-header.sh --check    fails if the committed header is not the generated one
set -euo pipefail
cd "$(dirname "$0")/.."

version=0.29.4
tools="${CARGO_TARGET_DIR:-target}/tools"
header=crates/raypath-capi/include/raypath.h
if [ "$("$tools/bin/cbindgen" --version 2>/dev/null)" != "cbindgen $version" ]; then
  cargo install cbindgen --version "$version" --locked --debug --quiet --root "$tools"
fi
case "${1:-}" in
  '') "$tools/bin/cbindgen" --quiet --output "$header" crates/raypath-capi ;;
  --check)
    if ! "$tools/bin/cbindgen" --quiet crates/raypath-capi | diff "$header" - >&2; then
      echo "raypath-header.sh: $header is stale; run scripts/raypath-header.sh" >&2
      exit 1
    fi
    ;;
  *) echo "raypath-header.sh: unknown argument '$1', expected --check or nothing" >&2; exit 2 ;;
esac
