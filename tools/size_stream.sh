#!/usr/bin/env bash
# Prints what a stream takes on each target, and fails where that is more than promised, or where it has grown:
#   flash         the smallest firmware that streams (examples/footprint) less the same without the codec
#   RAM           from bytes to datagrams: deframer, reader of packets, encoder with its datagram; not the UART's queue
#   stack         by painting, of all that examples/live_* do
#   instructions  of columns and of turns, packets to datagrams, without interrupts: medians and worst. QEMU counts
#                 instructions, not cycles: a Cortex-M7 does more than one a cycle where memory keeps up, an M4F less
#   worst frame   of one datagram on the line; a column fills no more than one
# And that nothing of Rust's panic machinery is in the streams' firmware.
#
# 16 beams are the simulated VLP-16's packets, lossless (2 mm); 64 are packets like an HDL-64E's, in steps of 2 cm.
set -euo pipefail
shopt -s inherit_errexit

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "$here/.."
scratch=${CARGO_TARGET_DIR:-target}/size
packets=${CARGO_TARGET_DIR:-target}/tmp
mkdir -p "$scratch"

# Target, its size and nm, the firmware's name, and the boards that run it.
targets=(
    "thumbv7em-none-eabihf arm-none-eabi live_cortex_m m7 m4f"
    "thumbv8m.main-none-eabihf arm-none-eabi live_cortex_m m33"
    "aarch64-unknown-none aarch64-linux-gnu live_aarch64 a53"
)
# Sensor, step in counts, kind of footprint, most bytes of flash, RAM and stack.
streams=(
    "vlp16 1 stream:vlp16 52500 8192 2048"
    "hdl64e 10 stream:hdl64e 26000 8192 2048"
    "hdl64e-aligned 10 stream:aligned 32000 16384 2048"
)
# Most instructions of a turn, the worst of all: what is not met yet is kept from growing. Promised on Thumb-2 are fewer.
declare -A turn_max=([vlp16]=11500000 [hdl64e]=37800000 [hdl64e-aligned]=41600000)
declare -A promised=([vlp16]=11200000 [hdl64e]=32000000 [hdl64e-aligned]=32000000)

# A 64-bit core's words are twice as long: its stack may be half as large again.
stack_max() { if [[ $1 == aarch64* ]]; then echo $((3 * $2 / 2)); else echo "$2"; fi; }

flash_bytes() { "$1-size" "$2" | awk 'NR == 2 { print $1 + $2 }'; }

# field LINES NAME: a number out of what the firmware printed.
field() { grep -o "\b$2=[0-9]*" <<<"$1" | head -n 1 | cut -d= -f2; }

failed=
# within NAME VALUE LIMIT
within() {
    (($2 <= $3)) && return
    echo "size_stream.sh: $1 is $2, allowed are at most $3" >&2
    failed=yes
}

# The tests' packets, which any run of theirs writes.
cargo test --quiet --features std,cli,capi --test live -- --list >/dev/null

row='%-5s %-15s %7s %7s %7s %10s %10s %12s %12s %6s\n'
# shellcheck disable=SC2059 # the format is a constant
printf "$row" board sensor flash RAM stack "column med" worst "turn med" worst frame
for line in "${targets[@]}"; do
    read -r target tools example boards <<<"$line"
    "$here/cross.sh" build --quiet --profile firmware --example "$example" --target "$target"
    firmware=$("$here/cross.sh" --target-dir "$target")/$target/firmware/examples/$example
    empty=$(flash_bytes "$tools" "$("$here/footprint.sh" none "$target")")
    for stream in "${streams[@]}"; do
        read -r sensor step kind flash_max ram_max stack_max <<<"$stream"
        footprint=$("$here/footprint.sh" "$kind" "$target")
        "$here/no_panic.sh" --program "$tools" "$footprint" >/dev/null || failed=yes
        flash=$(($(flash_bytes "$tools" "$footprint") - empty))
        within "flash of $sensor on $target" "$flash" "$flash_max"
        for board in $boards; do
            told=$("$here/emulate.sh" "$board" "$firmware" "$sensor:$step" "$packets/live-${sensor%%-*}.packets" "$scratch/stream")
            ram=$(field "$told" path_bytes)
            stack=$(field "$told" stack_bytes)
            turn=$(field "$told" turn_worst)
            # shellcheck disable=SC2059
            printf "$row" "$board" "$sensor" "$flash" "$ram" "$stack" "$(field "$told" column_median)" \
                "$(field "$told" column_worst)" "$(field "$told" turn_median)" "$turn" "$(field "$told" frame_max)"
            within "RAM of $sensor on $board" "$ram" "$ram_max"
            within "stack of $sensor on $board" "$stack" "$(stack_max "$target" "$stack_max")"
            within "instructions of a turn of $sensor on $board" "$turn" "${turn_max[$sensor]}"
        done
    done
done
# shellcheck disable=SC2059
for stream in "${streams[@]}"; do
    read -r sensor _ _ _ ram_max stack_max <<<"$stream"
    printf "$row" must "$sensor" "" "$ram_max" "$stack_max" "" "" "" "${promised[$sensor]}" ""
done
[[ -z $failed ]]
