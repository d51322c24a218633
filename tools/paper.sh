#!/usr/bin/env bash
# Re-does the paper, beside other systems: sets up what that needs, builds, measures, and writes target/paper/index.html.
# Results are kept by all that they depend on: what ended early goes on where it was.
#
#   tools/paper.sh [--quick] [OPTIONS OF python -m evaluation...]
#   tools/paper.sh --test     its unit tests, and a run on one simulated scan with the tests' build of flicr; seconds
#   tools/paper.sh --venv     only makes the virtual environment, and prints its Python
#
# FLICR_DATA=folder   real scans: what shared data looks like (kitti/drive/*.bin), or any folder of KITTI's .bin files
# FLICR_TMC3=program, FLICR_RTST=program   G-PCC's and RT-ST's programs, which no registry has
set -euo pipefail
shopt -s inherit_errexit

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "$here/.."
out=${CARGO_TARGET_DIR:-target}/paper
python=$out/venv/bin/python

step() { "$here/step.sh" "$@"; }

# Made anew only where the locked requirements are others.
venv() {
    local stamp=$out/venv/requirements.txt
    cmp -s evaluation/requirements.txt "$stamp" && return
    python3 -m venv --clear "$out/venv"
    "$python" -m pip install --quiet --disable-pip-version-check --require-hashes --only-binary :all: \
        -r evaluation/requirements.txt
    cp evaluation/requirements.txt "$stamp"
}

rivals=$out/rivals
firmware=$out/firmware

# Newer than its source: not built again.
is_built() { [[ -x $1 && ! evaluation/rivals/cpp/${1##*/}.cpp -nt $1 && ! evaluation/rivals/cpp/cost.hpp -nt $1 ]]; }

# cpp NAME FLAGS...: a driver in C++, where its library is there.
cpp() {
    local name=$1
    shift
    is_built "$rivals/$name" && return
    mkdir -p "$rivals"
    g++ -std=c++17 -O2 -DNDEBUG -o "$rivals/$name" "evaluation/rivals/cpp/$name.cpp" "$@"
}

draco() { cpp draco -ldraco; }

# PCL's headers are not free of warnings. What pkg-config lists as its libraries is far more than is used.
pcl() {
    # shellcheck disable=SC2046 # one flag a word
    cpp pcl -w $(pkg-config --cflags-only-I pcl_io pcl_features pcl_surface) \
        -lpcl_surface -lpcl_features -lpcl_kdtree -lpcl_search -lpcl_octree -lpcl_common -lflann_cpp -llz4 -lboost_system
}

# Not --locked: what flicr itself needs changes without this lock file, which cargo then completes.
rust() { (cd evaluation/rivals && cargo build --quiet --release "$@"); }

rust_all() { rust --target-dir "$(realpath -m "$rivals")"; }

# The same without vector instructions, where the compiler would find them.
scalar() {
    RUSTFLAGS="-C no-vectorize-loops -C no-vectorize-slp" rust --no-default-features --target-dir "$(realpath -m "$rivals")/scalar"
}

# What boards run: see tools/emulate.sh.
board() {
    local name=$1 example=$2 target=$3
    "$here/cross.sh" build --quiet --profile firmware --example "$example" --target "$target"
    mkdir -p "$firmware"
    cp -u "$("$here/cross.sh" --target-dir "$target")/$target/firmware/examples/$example" "$firmware/$name.elf"
}

boards() {
    "$here/setup.sh"
    board thumb cortex_m thumbv7em-none-eabihf
    board a53 aarch64 aarch64-unknown-none
}

build() { cargo build --quiet --release --features cli; }

case ${1:-} in
    --inner-*) "${1#--inner-}"; exit ;;
    --test)
        step "Python packages" "$0" --inner-venv
        step "unit tests of the evaluation" "$python" -m unittest discover --quiet -s evaluation/tests -t .
        step "evaluation of a simulated scan" env -u FLICR_DATA "$python" -m evaluation --quick --scans 1 \
            --out "$out/test" --flicr "${CARGO_TARGET_DIR:-target}/debug/flicr"
        exit
        ;;
    --venv) step "Python packages" "$0" --inner-venv; echo "$python"; exit ;;
esac

# optional LABEL STEP: what cannot be had here is left out, and the report says so.
optional() {
    step "$1" "$0" "--inner-$2" || echo "paper.sh: going on without: $1" >&2
}

step "other codecs, from Debian's packages (PCL's are large)" "$here/setup.sh" --paper ||
    echo "paper.sh: going on without those that are missing" >&2
step "Python packages" "$0" --inner-venv
step "build" "$0" --inner-build
optional "build of other codecs' drivers" rust_all
optional "build without vectors" scalar
optional "build of Draco's driver" draco
optional "build of PCL's driver" pcl
optional "firmware" boards
"$python" -m evaluation --out "$out" --flicr "${CARGO_TARGET_DIR:-target}/release/flicr" "$@"
