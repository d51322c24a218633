#!/usr/bin/env bash
# cargo for a target that is not this machine:
#
#   tools/cross.sh build --release --target thumbv7em-none-eabihf
#   tools/cross.sh --way thumbv7em-none-eabihf          prints which of the two ways below is used, or fails
#   tools/cross.sh --target-dir thumbv7em-none-eabihf   prints where that target's builds lie
#
# Two ways to a core library for a target (tools/setup.sh sees to it that there is one):
#   rustup  the toolchain in use has the target's library installed;
#   debian  the distribution's compiler and its sources, from which cargo builds the library first.
# FLICR_CROSS=rustup or FLICR_CROSS=debian allows only that one.
#
# Nothing else in the project knows which way it is: Makefile, tests and CI all come through here.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
host_arch=$(uname -m)
# Where Debian puts its compiler; named so that rustup's proxies, earlier on PATH, cannot step in.
distro=/usr/bin

fail() {
    echo "cross.sh: $*" >&2
    exit 3
}

target_of() {
    local previous=
    for argument in "$@"; do
        [[ $argument == -- ]] && break
        [[ $previous == --target ]] && { echo "$argument"; return; }
        [[ $argument == --target=* ]] && { echo "${argument#--target=}"; return; }
        previous=$argument
    done
    fail "no --target among: $*"
}

has_library() {
    local libraries
    libraries=$(cd "$root" && rustc --print target-libdir --target "$1" 2>/dev/null) || return 1
    compgen -G "$libraries/libcore-*.rlib" >/dev/null
}

has_library_source() {
    [[ -x $distro/cargo && -x $distro/rustc ]] || return 1
    [[ -f $("$distro/rustc" --print sysroot)/lib/rustlib/src/rust/library/core/src/lib.rs ]]
}

way_of() {
    local allowed=${FLICR_CROSS:-any}
    if [[ $allowed != debian ]] && has_library "$1"; then
        echo rustup
    elif [[ $allowed != rustup ]] && has_library_source; then
        echo debian
    else
        fail "no core library for $1 (FLICR_CROSS=$allowed): run tools/setup.sh"
    fi
}

target_dir_of() {
    # Apart from the host's, and from the other way's: two compilers in one folder trip over each other.
    echo "${CARGO_TARGET_DIR:-$root/target}/cross-$1"
}

# What linking and running takes, besides .cargo/config.toml. Linux on AArch64 is here and not there because there it
# would also hold for a machine that is AArch64 itself, which needs neither.
export_linux() {
    [[ $1 == aarch64-unknown-linux-gnu && $host_arch != aarch64 ]] || return 0
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu"
    # Tests that emulate or take long can tell by this that they run emulated.
    export FLICR_EMULATED=1
}

# Debian's compiler comes without rust-lld, which is what rustc would link bare metal with.
export_debian_linkers() {
    export CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER=arm-none-eabi-ld
    export CARGO_TARGET_THUMBV8M_MAIN_NONE_EABIHF_LINKER=arm-none-eabi-ld
    export CARGO_TARGET_AARCH64_UNKNOWN_NONE_LINKER=aarch64-linux-gnu-ld
}

run_rustup() {
    cd "$root"
    exec cargo "$@"
}

run_debian() {
    local target=$1 crates=core
    shift
    [[ $target == *-linux-* ]] && crates=std,panic_unwind,test,proc_macro
    export_debian_linkers
    # rustup's proxies and an outer cargo leave these behind; each would lead back to the other toolchain.
    unset RUSTUP_TOOLCHAIN CARGO RUSTC RUSTDOC RUSTC_WRAPPER
    export PATH="$distro:$PATH"
    # Cargo's -Z build-std, in a form that reaches cargo clippy too; allowed on a stable compiler by the first of them.
    # The project's own code uses nothing unstable.
    export RUSTC_BOOTSTRAP=1 CARGO_UNSTABLE_BUILD_STD=$crates
    cd "$root"
    exec "$distro/cargo" "$@"
}

case ${1:-} in
    --way) way_of "${2:?--way TARGET}" ;;
    --target-dir) target_dir_of "$(way_of "${2:?--target-dir TARGET}")" ;;
    "") fail "usage: tools/cross.sh CARGO-ARGUMENTS... --target TARGET" ;;
    *)
        target=$(target_of "$@")
        way=$(way_of "$target")
        CARGO_TARGET_DIR=$(target_dir_of "$way")
        export CARGO_TARGET_DIR
        # These would replace .cargo/config.toml's flags, and firmware would be linked without its memory map.
        unset RUSTFLAGS CARGO_ENCODED_RUSTFLAGS
        export_linux "$target"
        case $way in
            rustup) run_rustup "$@" ;;
            debian) run_debian "$target" "$@" ;;
        esac
        ;;
esac
