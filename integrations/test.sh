#!/usr/bin/env bash
# Builds and runs the tests of the adapters.
#   integrations/test.sh PREFIX BUILD          PREFIX: where scripts/install-libraypath.sh has installed; BUILD: a folder
#   integrations/test.sh PREFIX BUILD --long   also SystemC in a configuration with credits and units of two steps
set -euo pipefail

if [ $# -lt 2 ]; then
  echo 'integrations/test.sh: expected PREFIX BUILD [--long]' >&2
  exit 2
fi
configurations=skid
if [ "${3:-}" = --long ]; then configurations='skid;credit'; fi

cmake -S "$(dirname "$0")" -B "$2" -DCMAKE_PREFIX_PATH="$(realpath "$1")" -DRAYPATH_CONFIGURATIONS="$configurations"
cmake --build "$2" --parallel 2
ctest --test-dir "$2" --output-on-failure
