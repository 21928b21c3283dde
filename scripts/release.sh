#!/usr/bin/env bash
# Builds what a release offers, installs each part in a fresh prefix and tries it.
#   scripts/release.sh [DIR]    writes to DIR, by default target/dist:
#     raypath-VERSION-*.whl                  the Python package with the command line, for every Python from 3.9 on
#     libraypath-VERSION-TARGET.tar.gz       headers, shared and static library, pkg-config and CMake files
#     raypath-VERSION-TARGET.tar.gz          the program with all commands
set -euo pipefail
cd "$(dirname "$0")/.."

mkdir -p "${1:-target/dist}"
out=$(realpath "${1:-target/dist}")
version=$(sed -n '/^\[workspace.package\]/,/^$/s/^version = "\(.*\)"$/\1/p' Cargo.toml)
target=$(rustc -vV | sed -n 's/^host: //p')
built=${CARGO_TARGET_DIR:-target}/release
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

python3 -m venv "$folder/build"
"$folder/build/bin/pip" install --quiet 'maturin>=1.9,<2'
"$folder/build/bin/maturin" build --release --features verify --locked --quiet --out "$folder/wheels"

library=libraypath-$version-$target
scripts/install-libraypath.sh "$folder/$library" >/dev/null
tar -C "$folder" -czf "$folder/$library.tar.gz" "$library"

program=raypath-$version-$target
cargo build --release --locked --quiet --package raypath --features full
install -D -s "$built/raypath" "$folder/$program/raypath"
cp README.md LICENSE-APACHE LICENSE-MIT "$folder/$program/"
tar -C "$folder" -czf "$folder/$program.tar.gz" "$program"

# Each part, as a user installs it.
prefix=$folder/prefix
mkdir "$prefix"
python3 -m venv "$prefix/python"
"$prefix/python/bin/pip" install --quiet "$folder"/wheels/raypath-*.whl
(cd "$prefix" && python/bin/raypath configs >/dev/null && python/bin/python -c '
import numpy, raypath
assert raypath.Datapath().euclidean(numpy.zeros((1, 9)), numpy.ones((1, 9))).tolist() == [9]')
tar -C "$prefix" -xzf "$folder/$library.tar.gz"
tar -C "$prefix" -xzf "$folder/$program.tar.gz"
(cd "$prefix" && "$program/raypath" generate --jobs 100 >/dev/null && [ -s build/raypath.sv ])
sed -n '/^```c$/,/^```$/p' docs/integration/c.md | sed '1d;/^```$/,$d' >"$prefix/first.c"
export PKG_CONFIG_PATH=$prefix/$library/lib/pkgconfig
read -ra flags <<<"$(pkg-config --cflags --libs raypath)"
cc "$prefix/first.c" "${flags[@]}" -o "$prefix/first"
LD_LIBRARY_PATH=$prefix/$library/lib "$prefix/first" | grep -q 'job 7 after 12 cycles'
read -ra flags <<<"$(pkg-config --cflags --libs --static raypath)"
cc -Wl,--gc-sections "$prefix/first.c" "${flags[@]/-lraypath/-l:libraypath.a}" -lm -s -o "$prefix/static"
"$prefix/static" | grep -q 'job 7 after 12 cycles'

mv "$folder"/wheels/raypath-*.whl "$folder/$library.tar.gz" "$folder/$program.tar.gz" "$out"
du -h "$out"/*"$version"* "$prefix/static"
