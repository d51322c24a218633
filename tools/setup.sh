#!/usr/bin/env bash
# Installs what the tests and the emulated targets need, and says what. Does nothing, quickly, where all is there.
#
#   tools/setup.sh            everything
#   tools/setup.sh --check    installs nothing; names what is missing and fails if anything is
#   tools/setup.sh --bench    the codec that `make bench` compares with
#   tools/setup.sh --paper    other codecs, for `make paper` alone (PCL's packages are large)
#
# A core library for each target comes from rustup where it can download, else from Debian's compiler and sources:
# see tools/cross.sh. FLICR_CROSS=rustup or debian allows only that one way.
# FLICR_RUSTUP_TIMEOUT is how many seconds rustup may take for one target (default 120).
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
targets=(thumbv7em-none-eabihf thumbv8m.main-none-eabihf aarch64-unknown-none aarch64-unknown-linux-gnu)

say() { echo "setup: $*"; }

fail() {
    echo "setup: $*" >&2
    exit 1
}

have() { command -v "$1" >/dev/null 2>&1; }

# Prints "Debian package: what of it is missing", one a line.
missing_tools() {
    have cc || echo "gcc: cc"
    have qemu-system-arm && have qemu-system-aarch64 || echo "qemu-system-arm: qemu-system-arm, qemu-system-aarch64"
    have arm-none-eabi-gcc && have arm-none-eabi-size || echo "gcc-arm-none-eabi: arm-none-eabi-gcc, -size, -nm"
    have aarch64-linux-gnu-objdump || echo "binutils-aarch64-linux-gnu: aarch64-linux-gnu-ld, -objdump"
    have valgrind || echo "valgrind: valgrind"
    have zstd || echo "zstd: zstd"
    have python3 || echo "python3: python3"
    python3 -c 'import ensurepip, venv' 2>/dev/null || echo "python3-venv: Python's venv"
    have cmake || echo "cmake: cmake"
    have pkg-config || echo "pkg-config: pkg-config"
    [[ $(uname -m) == aarch64 ]] && return
    have qemu-aarch64 || echo "qemu-user: qemu-aarch64"
    have aarch64-linux-gnu-gcc || echo "gcc-aarch64-linux-gnu: aarch64-linux-gnu-gcc"
    [[ -f /usr/aarch64-linux-gnu/lib/libc.so.6 ]] || echo "libc6-dev-arm64-cross: /usr/aarch64-linux-gnu/lib"
}

missing_targets() {
    for target in "${targets[@]}"; do
        "$here/cross.sh" --way "$target" >/dev/null 2>&1 || echo "$target"
    done
}

# What only `make bench` needs, likewise.
missing_bench_tools() { have draco_encoder && have draco_decoder || echo "draco: draco_encoder, draco_decoder"; }

# What only `make paper` needs, likewise.
missing_paper_tools() {
    have g++ || echo "g++: g++"
    have ffmpeg || echo "ffmpeg: ffmpeg"
    [[ -d /usr/include/draco ]] || echo "libdraco-dev: Draco's headers"
    compgen -G '/usr/include/pcl-*' >/dev/null || echo "libpcl-dev: PCL's headers"
}

# The apt lists are fetched once, and only if something has to be installed.
updated=
apt_install() {
    have apt-get || fail "no apt-get here; please install by hand what these Debian packages hold: $*"
    local as_root=()
    if [[ $(id -u) != 0 ]]; then
        have sudo || fail "neither root nor sudo; please install these packages: $*"
        as_root=(sudo)
    fi
    say "installing by apt-get: $*"
    local log
    log=$(mktemp)
    if [[ -z $updated ]]; then
        "${as_root[@]}" apt-get update >"$log" 2>&1 || { tail -n 5 "$log" >&2; say "apt-get update failed; trying on"; }
        updated=yes
    fi
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@" \
        >"$log" 2>&1 </dev/null || { tail -n 20 "$log" >&2; fail "apt-get install failed: $*"; }
    rm -f "$log"
}

# install_tools MISSING: what a command lists as missing.
install_tools() {
    local missing
    missing=$("$1")
    [[ -z $missing ]] && return
    have apt-get || fail "no apt-get here, and these are missing (Debian's package name: what of it):"$'\n'"$missing"
    # shellcheck disable=SC2046 # one package a line, none with spaces
    apt_install $(cut -d: -f1 <<<"$missing")
}

# Gives up at the first target that cannot be had: where one download fails, all do.
add_rustup_targets() {
    have rustup && [[ ${FLICR_CROSS:-any} != debian ]] || return 1
    for target in "$@"; do
        say "rustup target add $target"
        timeout "${FLICR_RUSTUP_TIMEOUT:-120}" rustup target add "$target" </dev/null >/dev/null 2>&1 || return 1
    done
}

install_debian_rust() {
    [[ ${FLICR_CROSS:-any} != rustup ]] || fail "rustup cannot add $*, and FLICR_CROSS=rustup forbids Debian's compiler"
    say "rustup cannot add $*: using Debian's compiler and its sources"
    have apt-get || fail "no apt-get here: install the targets' libraries by other means: $*"
    apt_install rustc-web cargo-web rust-web-src rust-web-clippy binutils-arm-none-eabi binutils-aarch64-linux-gnu
}

missing_lint_tools() {
    cargo fmt --version >/dev/null 2>&1 || echo rustfmt
    cargo clippy --version >/dev/null 2>&1 || echo clippy
}

install_lint_tools() {
    local missing
    mapfile -t missing < <(missing_lint_tools)
    [[ ${#missing[@]} == 0 ]] && return
    if have rustup; then
        say "rustup component add ${missing[*]}"
        timeout "${FLICR_RUSTUP_TIMEOUT:-120}" rustup component add "${missing[@]}" </dev/null >/dev/null 2>&1 ||
            fail "rustup cannot add ${missing[*]}"
    else
        apt_install rustfmt-web rust-web-clippy
    fi
}

install_targets() {
    local missing
    mapfile -t missing < <(missing_targets)
    [[ ${#missing[@]} == 0 ]] && return
    add_rustup_targets "${missing[@]}" || install_debian_rust "${missing[@]}"
    mapfile -t missing < <(missing_targets)
    [[ ${#missing[@]} == 0 ]] || fail "still no core library for: ${missing[*]}"
}

# What makes text of what firmware logs.
install_defmt_print() {
    command -v defmt-print >/dev/null && return
    say "cargo install defmt-print"
    "$here/defmt.sh" install || fail "cargo cannot install defmt-print"
}

check() {
    local missing
    missing=$(missing_tools; missing_targets | sed 's/^/rust target: /'; missing_lint_tools; have defmt-print || echo defmt-print)
    [[ -z $missing ]] || fail "missing (run tools/setup.sh):"$'\n'"$missing"
}

[[ ${1:-} == --check ]] && { check; exit; }
[[ ${1:-} == --bench ]] && { install_tools missing_bench_tools; exit; }
[[ ${1:-} == --paper ]] && { install_tools missing_paper_tools; exit; }
have cargo || have apt-get || fail "no cargo: install Rust from https://rustup.rs"
install_tools missing_tools
install_targets
have cargo || fail "Debian's compiler is installed, but no cargo is on PATH"
install_lint_tools
install_defmt_print
say "all there"
