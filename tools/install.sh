#!/usr/bin/env bash
# Installs the C library so that a build finds it: the static library, its header, and what CMake and pkg-config ask for.
#
#   tools/install.sh PREFIX [TARGET]      PREFIX/include, PREFIX/lib; TARGET as for tools/staticlib.sh (this machine's)
#
# Then, with PREFIX in CMAKE_PREFIX_PATH:          find_package(flicr REQUIRED)
#                                                  target_link_libraries(firmware PRIVATE flicr::flicr)
# or, with PREFIX/lib/pkgconfig in PKG_CONFIG_PATH: cc client.c $(pkg-config --cflags --libs flicr)
# The folder can be moved, or copied to another machine, as a whole.
set -euo pipefail

(($# == 1 || $# == 2)) || { echo "usage: tools/install.sh PREFIX [TARGET]" >&2; exit 2; }
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
target=${2:-$(uname -m)-unknown-linux-gnu}
library=$("$here/staticlib.sh" "$target")
version=$(awk -F '"' '/^version = / { print $2; exit }' "$here/../Cargo.toml")

mkdir -p "$1"
prefix=$(cd "$1" && pwd)
install -D -m 644 "$here/../include/flicr.h" "$prefix/include/flicr.h"
install -D -m 644 "$library" "$prefix/lib/libflicr.a"
for template in flicr.pc:pkgconfig flicrConfig.cmake:cmake/flicr flicrConfigVersion.cmake:cmake/flicr; do
    name=${template%%:*}
    folder=$prefix/lib/${template#*:}
    mkdir -p "$folder"
    sed "s/@VERSION@/$version/g" "$here/package/$name.in" >"$folder/$name"
done
echo "$prefix"
