#!/usr/bin/env bash
# Everything that looks at the source without running it; any warning fails.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "$here/.."

features() {
    sed -n '/^\[features\]/,/^\[[^f]/s/^\([a-z][a-z0-9_-]*\) *=.*/\1/p' Cargo.toml | grep -vx default
}

# Features of code that runs without an operating system.
device_features() {
    features | grep -vxE 'std|rayon|cli'
}

joined() { paste -sd,; }

clippy_host() { cargo clippy --quiet "$@" -- -D warnings; }

clippy_host_features() {
    clippy_host --lib
    for feature in $(features); do
        clippy_host --lib --bins --features "$feature"
    done
    clippy_host --all-targets --features "$(features | joined)"
}

clippy_device() {
    local target=$1 looked_at=(--lib)
    for example in "${@:2}"; do looked_at+=(--example "$example"); done
    "$here/cross.sh" clippy --quiet "${looked_at[@]}" --target "$target" -- -D warnings
    for feature in $(device_features); do
        "$here/cross.sh" clippy --quiet "${looked_at[@]}" --features "$feature" --target "$target" -- -D warnings
    done
}

step() { "$here/step.sh" "$@"; }

case ${1:-all} in
    host) clippy_host_features ;;
    device) clippy_device "${@:2}" ;;
    docs) RUSTDOCFLAGS="-D warnings" cargo doc --quiet --no-deps --features "$(features | joined)" ;;
    all)
        step "format" cargo fmt --check
        # A crate of its own, which is built by `make paper` alone.
        step "format of other codecs' driver" rustfmt --check --edition 2024 evaluation/rivals/src/main.rs
        step "clippy, every feature alone and all together" "$0" host
        step "clippy, Cortex-M" "$0" device thumbv7em-none-eabihf cortex_m live_cortex_m footprint
        step "clippy, AArch64 bare metal" "$0" device aarch64-unknown-none aarch64 live_aarch64 footprint
        step "rustdoc" "$0" docs
        ;;
    *) echo "usage: tools/lint.sh [all|host|device TARGET EXAMPLE...|docs]" >&2; exit 2 ;;
esac
