#!/usr/bin/env bash
# The streaming firmware with its logging compiled in, and what it logs as text:
#
#   tools/defmt.sh build [TARGET]     builds examples/live_cortex_m with feature defmt and prints its path
#   tools/defmt.sh print ELF <FRAMES  makes text of what that firmware's third UART sent
#   tools/defmt.sh install            only installs what makes the text
#
# In a target folder of its own: the firmware without it has the same name.
# DEFMT_LOG: what is logged, from trace to error (default info).
set -euo pipefail
shopt -s inherit_errexit

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "$here/.."
build_dir=$(realpath -m "${CARGO_TARGET_DIR:-target}")

build() {
    local target=${1:-thumbv7em-none-eabihf} built
    export CARGO_TARGET_DIR=$build_dir/defmt DEFMT_LOG=${DEFMT_LOG:-info}
    "$here/cross.sh" rustc --quiet --profile firmware --features defmt --example live_cortex_m --target "$target" \
        -- -Clink-arg=-Tdefmt.x >&2
    built=$("$here/cross.sh" --target-dir "$target")
    echo "$built/$target/firmware/examples/live_cortex_m"
}

# Where cargo puts programs, so that it is compiled once (four minutes) and not for every folder.
install_print() {
    command -v defmt-print >/dev/null || cargo install --quiet --locked defmt-print@1.2.0 >&2
}

# On PATH, or not yet.
defmt_print() {
    install_print
    PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin defmt-print "$@"
}

case ${1:-} in
    build) build "${@:2}" ;;
    install) install_print ;;
    print) defmt_print -e "${2:?print ELF}" ;;
    *) echo "usage: tools/defmt.sh build [TARGET] | print ELF | install" >&2; exit 2 ;;
esac
