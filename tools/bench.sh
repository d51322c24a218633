#!/usr/bin/env bash
# What flicr promises beside the codecs that a user would pick instead, in one run on real scans: Draco (Debian's `draco`) and
# cloudini. Fails where a promise is broken; where there are no scans, says so in one line.
#
# FLICR_DATA=folder   that has kitti/drive/*.bin (default ../shared/data)
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "$here/.."
drive=${FLICR_DATA:-../shared/data}/kitti/drive
# As `make paper` takes them.
scans=("$drive"/0000{00,06,12,18}.bin)
for scan in "${scans[@]}"; do
    [[ -f $scan ]] || { echo "bench: no $scan (FLICR_DATA): shares of Draco's and cloudini's bytes and times are not measured"; exit 0; }
done
"$here/setup.sh" --bench || echo "bench: going on without Draco" >&2
out=${CARGO_TARGET_DIR:-target}/paper/rivals
cargo build --quiet --release --manifest-path evaluation/rivals/Cargo.toml --target-dir "$out"
# The last line is for programs.
"$out/release/flicr-rivals" promises "${scans[@]}" | grep -v '^\['
