#!/usr/bin/env bash
# Builds libraypath and installs it under a prefix: headers for C and C++, the shared and the static library, a
# pkg-config file and a CMake package.
#   scripts/install-libraypath.sh PREFIX                       for example /usr/local, or $HOME/.local
#   RAYPATH_BUILT=DIR scripts/install-libraypath.sh PREFIX     installs the libraries that Cargo left in DIR
set -euo pipefail

if [ $# -ne 1 ] || [ -z "$1" ] || [ "${1#-}" != "$1" ]; then
  echo "usage: install-libraypath.sh PREFIX" >&2
  exit 2
fi
mkdir -p "$1"
prefix="$(cd "$1" && pwd)"
cd "$(dirname "$0")/.."

built="${RAYPATH_BUILT:-${CARGO_TARGET_DIR:-target}/release}"
[ -n "${RAYPATH_BUILT:-}" ] || cargo build --release --locked --quiet -p raypath-capi
crate=crates/raypath-capi
version="$(sed -n '/^\[workspace.package\]/,/^$/s/^version = "\(.*\)"$/\1/p' Cargo.toml)"
abi="$(sed -n 's/^#define RAYPATH_ABI_VERSION \([0-9]*\)$/\1/p' "$crate/include/raypath.h")"
# What a program needs besides the static library: Rust's standard library calls these.
static_libraries="-lpthread -ldl -lm -lgcc_s -lutil -lrt"

# put MODE FILE TARGET: installs a file under the prefix; the target is replaced at once.
put() {
  install -D -m "$1" "$2" "$prefix/$3.new"
  mv "$prefix/$3.new" "$prefix/$3"
}
# fill FILE TARGET: installs a template with the values of this build.
fill() {
  local filled
  filled="$(mktemp)"
  sed -e "s|@VERSION@|$version|g; s|@ABI@|$abi|g; s|@STATIC_LIBRARIES@|$static_libraries|g" \
    "$1" > "$filled"
  put 644 "$filled" "$2"
  rm "$filled"
}

put 644 "$crate/include/raypath.h" include/raypath.h
put 644 "$crate/include/raypath.hpp" include/raypath.hpp
put 755 "$built/libraypath_capi.so" "lib/libraypath.so.$version"
put 644 "$built/libraypath_capi.a" lib/libraypath.a
# Without the debugging information of Rust's standard library.
! command -v strip >/dev/null || strip --strip-debug "$prefix/lib/libraypath.so.$version" "$prefix/lib/libraypath.a"
ln -sfn "libraypath.so.$version" "$prefix/lib/libraypath.so.$abi"
ln -sfn "libraypath.so.$abi" "$prefix/lib/libraypath.so"
fill "$crate/package/raypath.pc" lib/pkgconfig/raypath.pc
fill "$crate/package/raypath-config.cmake" lib/cmake/raypath/raypath-config.cmake
fill "$crate/package/raypath-config-version.cmake" lib/cmake/raypath/raypath-config-version.cmake
echo "Installed raypath $version to $prefix: include/raypath.h, include/raypath.hpp, lib/libraypath.so, lib/libraypath.a,"
echo "lib/pkgconfig/raypath.pc, lib/cmake/raypath."
