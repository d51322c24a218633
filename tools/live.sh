#!/usr/bin/env bash
# A sensor's packets go into firmware on an emulated board by one UART and come out as datagrams by another, as the sensor
# turns; `flicr receive` shows them as they come. What the firmware logged by defmt is printed at the end.
#
# FLICR_SENSOR=hdl64e         vlp16, hdl64e or hdl64e-aligned, simulated
# FLICR_PACKETS=turns.pcap    a VLP-16's capture in their place
# FLICR_TURNS=10              simulated turns
# FLICR_STEP=10               in range counts (vlp16: 1)
# FLICR_BUDGET=               bytes a second that the link carries, by the sensor's clock
# FLICR_BOARD=m7              m7, m4f, m33 or a53
#
# The emulated UART takes byte by byte, far slower than the sensor sends: the rates shown are the emulator's.
set -euo pipefail
shopt -s inherit_errexit

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
source=${FLICR_PACKETS:+$(realpath -m "$FLICR_PACKETS")}
cd "$here/.."
if [[ -n $source && ! -f $source ]]; then
    echo "live.sh: FLICR_PACKETS: no such file: $FLICR_PACKETS" >&2
    exit 2
fi
sensor=${FLICR_SENSOR:-hdl64e}
[[ -z $source ]] || sensor=vlp16
step=${FLICR_STEP:-$([[ $sensor == vlp16 ]] && echo 1 || echo 10)}
board=${FLICR_BOARD:-m7}
job=$sensor:$step${FLICR_BUDGET:+:$FLICR_BUDGET}
build_dir=$(realpath -m "${CARGO_TARGET_DIR:-target}")
out=$build_dir/live
mkdir -p "$out/turns"
rm -f "$out"/turns/* "$out"/{packets,datagrams}.{in,out} "$out"/log*

step() { "$here/step.sh" "$@"; }

built() {
    "$here/cross.sh" build --quiet --profile firmware --example "$1" --target "$2"
    echo "$("$here/cross.sh" --target-dir "$2")/$2/firmware/examples/$1"
}

step "build for this machine" cargo build --quiet --release --features cli --bin flicr --example live_packets
case $board in
    m7 | m4f) firmware=$(step "build for Cortex-M" "$here/defmt.sh" build thumbv7em-none-eabihf) ;;
    m33) firmware=$(step "build for Cortex-M33" "$here/defmt.sh" build thumbv8m.main-none-eabihf) ;;
    a53) firmware=$(built live_aarch64 aarch64-unknown-none) ;;
    *) echo "live.sh: FLICR_BOARD: $board: expected m7, m4f, m33 or a53" >&2; exit 2 ;;
esac

# Pipes by their names: QEMU reads NAME.in and writes NAME.out. A PL011 is one line both ways.
line=datagrams
serial="pipe:$out/datagrams"
if [[ $board != a53 ]]; then
    line=packets
    serial+=" pipe:$out/packets file:$out/log.defmt"
fi
mkfifo "$out"/{packets,datagrams}.{in,out}
started=()
trap 'kill "${started[@]}" 2>/dev/null || true' EXIT

packets=("${sensor%%-*}" "${FLICR_TURNS:-10}")
[[ -z $source ]] || packets=("$source")
"$build_dir/release/examples/live_packets" "${packets[@]}" >"$out/$line.in" &
started+=($!)
FLICR_SERIAL=$serial FLICR_EMULATE_TIMEOUT=3600 "$here/emulate.sh" "$board" "$firmware" "$job" uart >"$out/board.txt" &
started+=($!)
"$build_dir/release/flicr" receive "$out/datagrams.out" --idle 0 -o "$out/turns"
wait "${started[1]}"
cat "$out/board.txt"
if [[ -s $out/log.defmt ]]; then
    echo "what the firmware logged, decoded:"
    "$here/defmt.sh" print "$firmware" <"$out/log.defmt"
fi
echo "$(find "$out/turns" -type f | wc -l) turns in $out/turns"
