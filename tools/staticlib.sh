#!/usr/bin/env bash
# Builds the C ABI (include/flicr.h) as a static library and prints where it lies:
#
#   tools/staticlib.sh aarch64-unknown-none
#   tools/staticlib.sh thumbv7em-none-eabihf
#   tools/staticlib.sh aarch64-unknown-linux-gnu
#
# The library is the same no_std code on every target: nothing of it needs an operating system, an allocator or libm.
set -euo pipefail

(($# == 1)) || { echo "usage: tools/staticlib.sh TARGET" >&2; exit 2; }
tools=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

# The panic handler that a no_std library must bring is behind --cfg flicr_staticlib and not behind a feature: firmware
# in Rust that uses the crate, C ABI included, brings its own, and features cannot be taken back.
"$tools/cross.sh" rustc --lib --crate-type staticlib --features capi --profile staticlib --target "$1" \
    -- --cfg flicr_staticlib >&2

echo "$("$tools/cross.sh" --target-dir "$1")/$1/staticlib/libflicr.a"
