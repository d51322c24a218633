#!/usr/bin/env bash
# A scan goes into firmware on an emulated Cortex-M7 and comes out as frames, at two sizes; the host encodes the same
# and must get the same bytes. Then the host decodes, measures, prints a table and draws a picture.
#
# FLICR_SCAN=path/to/kitti.bin   this scan in place of a simulated one
# FLICR_MAX_RANGE_M=120          range of the largest level, meters (default 80)
# FLICR_CODER=rle                this coder (default deflate)
set -euo pipefail
shopt -s inherit_errexit

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
scan=${FLICR_SCAN:+$(realpath -m "$FLICR_SCAN")}
cd "$here/.."
if [[ -n $scan && ! -f $scan ]]; then
    echo "demo.sh: FLICR_SCAN: no such file: $FLICR_SCAN" >&2
    exit 2
fi
if [[ -n $scan && $scan != *.bin ]]; then
    echo "demo.sh: FLICR_SCAN: $FLICR_SCAN: expected a KITTI file (.bin)" >&2
    exit 2
fi

target=thumbv7em-none-eabihf
coder=${FLICR_CODER:-deflate}
max_range_m=${FLICR_MAX_RANGE_M:-80}
sizes=(4500 256)
build_dir=$(realpath -m "${CARGO_TARGET_DIR:-target}")
out=$build_dir/demo
flicr=$build_dir/release/flicr
options=(--preset uniform --coder "$coder" --max-range "$max_range_m")
mkdir -p "$out"

step() { "$here/step.sh" "$@"; }

step "build for this machine" cargo build --quiet --release --features cli
step "build for Cortex-M7" "$here/cross.sh" build --quiet --profile firmware --example cortex_m --target $target
firmware=$(realpath "$("$here/cross.sh" --target-dir $target)/$target/firmware/examples/cortex_m")

if [[ -z $scan ]]; then
    scan=$out/simulated.bin
    step "simulate a scan" "$flicr" simulate -o "$scan"
fi

jobs=()
for columns in "${sizes[@]}"; do jobs+=("$columns:$coder:$max_range_m"); done
# The board gets its command line as one string of words: by these names no path of this machine's is among them.
ln -sf "$scan" "$out/on_board.bin"
(cd "$out" && step "encode on the emulated Cortex-M7" \
    "$here/emulate.sh" m7 "$firmware" on_board.bin board "${jobs[@]}") | tee "$out/board.txt"

for columns in "${sizes[@]}"; do
    step "encode $columns x 64 on this machine" \
        "$flicr" encode "$scan" -o "$out/host-$columns.flicr" --columns "$columns" "${options[@]}"
    cmp "$out/host-$columns.flicr" "$out/board-$columns-$coder.flicr"
    echo "    the same $(stat -c %s "$out/host-$columns.flicr") bytes on both"
done

measured=$(step "decode and measure" \
    "$flicr" eval "$scan" --json --columns "$(IFS=,; echo "${sizes[*]}")" "${options[@]}")
step "draw" "$flicr" view "$scan" -o "$out/demo.png" --columns "${sizes[0]}" "${options[@]}"

# json LINE NAME: a number out of a flat JSON object.
json() { sed -n "s/.*\"$2\":\([^,}]*\).*/\1/p" <<<"$1"; }
# cost COLUMNS NAME: a number out of the firmware's line on that size.
cost() { sed -n "s/^cost columns=$1 .* $2=\([0-9]*\).*/\1/p" "$out/board.txt"; }

row='%-9s %7s %7s %7s %6s %7s %7s %8s %7s %9s %9s %12s %12s %9s\n'
echo
# shellcheck disable=SC2059 # the format is a constant
{
    printf "$row" "" "" "12 B/pt" "16 B/pt" bits/ points PSNR CD ePSNR encode decode project code ""
    printf "$row" size bytes "ratio" "ratio" point "lost %" dB "m2" dB "ms" "ms" "instr." "instr." "RAM bytes"
    while read -r line; do
        columns=$(json "$line" columns)
        printf "$row" "${columns}x64" "$(json "$line" bytes)" \
            "$(printf %.1f "$(json "$line" ratio_xyz)")" "$(printf %.1f "$(json "$line" ratio_xyzi)")" \
            "$(printf %.2f "$(json "$line" bpp)")" "$(awk "BEGIN { printf \"%.2f\", 100 * $(json "$line" se) }")" \
            "$(printf %.2f "$(json "$line" psnr_db)")" "$(printf %.4f "$(json "$line" cd_m2)")" \
            "$(printf %.2f "$(json "$line" epsnr_db)")" \
            "$(awk "BEGIN { printf \"%.2f\", $(json "$line" encode_ns) / 1e6 }")" \
            "$(awk "BEGIN { printf \"%.2f\", $(json "$line" decode_ns) / 1e6 }")" \
            "$(cost "$columns" project)" "$(cost "$columns" code)" "$(cost "$columns" encoder_bytes)"
    done <<<"$measured"
}
echo
echo "Times are this machine's; instructions are the emulated Cortex-M7's (QEMU counts no cycles), RAM the encoder's."
echo "Picture: $out/demo.png"
