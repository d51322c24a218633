#!/usr/bin/env bash
# Fuzzes what reads untrusted bytes, one target after the other: libFuzzer, by the stable compiler. Fails at the first input
# that breaks a promise, and leaves it in target/fuzz/TARGET/.
#
#   tools/fuzz.sh [SECONDS [TARGET...]]    600 seconds each of all targets unless told otherwise
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
seconds=${1:-600}
shift || true
targets=("$@")
((${#targets[@]})) || targets=(payload decode stream framing packets packet_frames files calibrate)
out=${CARGO_TARGET_DIR:-target}/fuzz
mkdir -p "$out"
out=$(realpath "$out")
triple=$(rustc -vV | sed -n 's/^host: //p')

# What cargo-fuzz passes, without the address sanitizer, which needs a nightly compiler: the decoders have no unsafe code.
# The target's name keeps the flags from build scripts.
coverage=(-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-trace-compares
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table
    -Cllvm-args=-simplifycfg-branch-fold-threshold=0 -Ccodegen-units=1)
build() { cargo build --quiet --release --manifest-path fuzz/Cargo.toml --target-dir "$out/build" --target "$triple" "$@"; }

cargo run --quiet --release --manifest-path fuzz/Cargo.toml --target-dir "$out/build" --bin seeds -- "$out/seeds"
for target in "${targets[@]}"; do
    RUSTFLAGS="${coverage[*]}" build --bin "$target"
    mkdir -p "$out/$target"
    log=$out/$target.log
    # One that takes a minute is a failure too: any input's time is bounded. By the clock: a busy machine makes seconds of ms.
    if (cd "$out/$target" && "$out/build/$triple/release/$target" -max_total_time="$seconds" -max_len=4096 -timeout=60 \
        -rss_limit_mb=1024 -print_final_stats=1 -artifact_prefix="$out/$target/failed-" "$out/$target" "$out/seeds/$target") \
        >"$log" 2>&1; then
        executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
        coverage_of=$(grep -Eo 'cov: [0-9]+' "$log" | tail -n 1)
        echo "$target: $executions executions, ${coverage_of#cov: } edges covered, nothing found in $seconds s"
    else
        tail -n 30 "$log" >&2
        echo "fuzz: $target failed; see $log" >&2
        exit 1
    fi
done
