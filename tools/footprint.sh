#!/usr/bin/env bash
# Builds the smallest firmware that encodes (examples/footprint) and prints its path.
#
#   tools/footprint.sh KIND [TARGET]   COLUMNS:CODER, an encoder of frames; stream:SENSOR, one of a stream
#   tools/footprint.sh none [TARGET]   the same firmware without the codec
#   tools/footprint.sh --kinds         lists the kinds there are
set -euo pipefail
shopt -s inherit_errexit

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "$here/.."

target=${2:-thumbv7em-none-eabihf}
scratch=${CARGO_TARGET_DIR:-target}/footprint/$target

build() {
    local kind=$1 flags=() built
    [[ $kind == none ]] || flags=(--cfg footprint --cfg "footprint=\"$kind\"")
    "$here/cross.sh" rustc --quiet --profile firmware --example footprint --target $target -- "${flags[@]}"
    built=$("$here/cross.sh" --target-dir $target)
    mkdir -p "$scratch"
    cp "$built/$target/firmware/examples/footprint" "$scratch/$kind"
    echo "$scratch/$kind"
}

case ${1:?KIND, none or --kinds} in
    --kinds) sed -n 's/.*#\[cfg(footprint = "\(.*\)")\].*/\1/p' examples/footprint/main.rs ;;
    *) build "$1" ;;
esac
