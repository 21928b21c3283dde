#!/usr/bin/env bash
# Builds the wheel, installs it in a virtual environment under target/python, and runs mypy, ruff and pytest.
#   scripts/test-python.sh [ARGUMENTS OF PYTEST]
set -euo pipefail
cd "$(dirname "$0")/.."

folder=$(realpath -m "${CARGO_TARGET_DIR:-target}/python")
venv=$folder/venv
python=$(command -v python3)
pip=("$python" -m pip --python "$venv/bin/python" --quiet --disable-pip-version-check install --no-compile)
requirements=crates/raypath-python/tests/requirements.txt

# A new environment if the requirements or the interpreter changed since the last one was complete.
stamp=$("$python" --version; cat "$requirements")
if [ "$(cat "$venv/stamp" 2>/dev/null)" != "$stamp" ]; then
  rm -rf "$venv"
  # Without a pip of its own, which needs the package python3-venv on Debian.
  "$python" -m venv --without-pip "$venv"
  "${pip[@]}" 'numpy>=1.23' --requirement "$requirements"
  printf '%s' "$stamp" >"$venv/stamp"
fi
export PATH=$venv/bin:$PATH VIRTUAL_ENV=$venv MPLCONFIGDIR=$folder/matplotlib

rm -rf "$folder/wheels"
maturin build --release --locked --quiet --out "$folder/wheels" --compression-level 1
"${pip[@]}" --no-deps --force-reinstall "$folder"/wheels/raypath-*.whl

ruff format --check --quiet
ruff check --quiet
mypy
stubtest raypath._raypath
pytest --quiet "$@"
