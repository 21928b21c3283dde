#!/usr/bin/env bash
# Builds the wheel with all commands, installs it in a virtual environment under target/python, and runs mypy, ruff
# and pytest.
#   scripts/test-python.sh [ARGUMENTS OF PYTEST]
#   RAYPATH_PROFILE=release scripts/test-python.sh    with another of Cargo's profiles than `tests`
set -euo pipefail
cd "$(dirname "$0")/.."

profile=${RAYPATH_PROFILE:-tests}
folder=$(realpath -m "${CARGO_TARGET_DIR:-target}/python")
venv=$folder/venv
requirements=crates/raypath-python/tests/requirements.txt

# A new environment if the requirements or the interpreter changed since the last one was complete.
stamp=$(python3 --version; cat "$requirements")
if [ "$(cat "$venv/stamp" 2>/dev/null)" != "$stamp" ]; then
  rm -rf "$venv"
  # Without a pip of its own, which needs the package python3-venv on Debian.
  python3 -m venv --without-pip "$venv"
  # uv takes 3 s for the packages, pip 30 s.
  python3 -m pip --python "$venv/bin/python" install --quiet --disable-pip-version-check 'uv>=0.5'
  "$venv/bin/uv" pip install --quiet --python "$venv/bin/python" --requirement "$requirements"
  printf '%s' "$stamp" >"$venv/stamp"
fi
export PATH=$venv/bin:$PATH VIRTUAL_ENV=$venv MPLCONFIGDIR=$folder/matplotlib

rm -rf "$folder/wheels"
maturin build --profile "$profile" --features verify --locked --quiet --out "$folder/wheels" --compression-level 1
uv pip install --quiet --no-deps --reinstall "$folder"/wheels/raypath-*.whl

# uv compiles nothing, and the tests start Python a hundred times: the first start has to keep what it compiles.
unset PYTHONDONTWRITEBYTECODE
# The tests start the program a hundred times too, and the one that cargo builds starts faster than that of the wheel.
program=$(realpath -m "${CARGO_TARGET_DIR:-target}/$profile/raypath")
if [ -z "${RAYPATH_PROGRAM:-}" ] && "$program" verify --list >/dev/null 2>&1; then export RAYPATH_PROGRAM=$program; fi

ruff format --check --quiet
ruff check --quiet
mypy
stubtest raypath._raypath
pytest --quiet "$@"
