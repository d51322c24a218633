#!/usr/bin/env bash
# Lists what of Rust's panic machinery has got into linked code, one symbol a line; fails if any has.
#
#   tools/no_panic.sh              the smallest firmware for Cortex-M that encodes (examples/footprint), of every kind
#   tools/no_panic.sh LIBRARY.a    what a C program gets that calls every flicr_* function of this static library for Cortex-M
#   tools/no_panic.sh --program TOOLS PROGRAM    this program, by TOOLS-nm: arm-none-eabi or aarch64-linux-gnu
set -euo pipefail
shopt -s inherit_errexit

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "$here/.."
scratch=${CARGO_TARGET_DIR:-target}/size

# Panics, failed slicing and unwrapping, and the formatting that they bring along.
machinery='core::panicking|panic_fmt|panic_bounds_check|_fail\b|unwrap_failed|expect_failed|core::fmt::|begin_unwind'

# linked LIBRARY: everything that its C functions reach, and nothing else.
linked() {
    local roots
    roots=$(arm-none-eabi-nm --defined-only "$1" 2>/dev/null | awk '$2 == "T" && $3 ~ /^flicr_/ { print "--undefined=" $3 }')
    [[ -n $roots ]] || { echo "no_panic.sh: no flicr_ function in $1" >&2; exit 2; }
    # shellcheck disable=SC2086 # one option a word
    arm-none-eabi-ld --gc-sections --entry=0 --unresolved-symbols=ignore-all $roots "$1" -o "$scratch/linked.elf"
    echo "$scratch/linked.elf"
}

# panics PROGRAM: nothing, where there are none.
panics() {
    local symbols
    symbols=$("$tools-nm" --demangle=rust "$1" | sed 's/^[0-9a-f ]* . //' | sort -u)
    grep -E "$machinery" <<<"$symbols" || true
}

mkdir -p "$scratch"
tools=arm-none-eabi
programs=()
if [[ ${1:-} == --program ]]; then
    tools=${2:?--program TOOLS PROGRAM}
    programs+=("${3:?--program TOOLS PROGRAM}")
elif [[ $# == 0 ]]; then
    for kind in $("$here/footprint.sh" --kinds); do programs+=("$("$here/footprint.sh" "$kind")"); done
else
    programs+=("$(linked "$1")")
fi

found=
for program in "${programs[@]}"; do
    symbols=$(panics "$program")
    if [[ -n $symbols ]]; then
        found=yes
        echo "$program:"
        # shellcheck disable=SC2001 # indents every line
        sed 's/^/    /' <<<"$symbols"
    fi
done
if [[ -n $found ]]; then exit 1; fi
echo "no panic machinery in ${programs[*]}"
