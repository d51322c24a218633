#!/usr/bin/env bash
# Runs bare-metal firmware on an emulated board; its exit code is the firmware's.
#
#   tools/emulate.sh m4f|m7|m33|a53 ELF [ARGUMENTS...]
#
# The firmware reads its arguments, and reads and writes files of this machine, by semihosting. One instruction is one
# nanosecond of emulated time (-icount shift=0), so that a timer on the board counts instructions, the same every run.
# FLICR_SERIAL: what QEMU connects the board's UARTs with, words as for its -serial, one for each UART, apart by spaces
# (default: nothing).
# FLICR_EMULATE_TIMEOUT: seconds after which a run that hangs is ended (default 300).
set -euo pipefail

(($# >= 2)) || { echo "usage: tools/emulate.sh m4f|m7|m33|a53 ELF [ARGUMENTS...]" >&2; exit 2; }
board=$1
shift

case $board in
    m4f) machine=(qemu-system-arm -M mps2-an386) ;;
    m7) machine=(qemu-system-arm -M mps2-an500) ;;
    m33) machine=(qemu-system-arm -M mps2-an505) ;;
    a53) machine=(qemu-system-aarch64 -M virt -cpu cortex-a53 -m 64 -nic none) ;;
    *) echo "emulate.sh: no such board: $board" >&2; exit 2 ;;
esac

semihosting=enable=on,target=native
# The firmware's own name first, without its folder: a space in that would make two arguments of it.
for argument in "${1##*/}" "${@:2}"; do
    semihosting+=",arg=${argument//,/,,}" # a comma that is no separator is written twice
done

serial=()
for device in ${FLICR_SERIAL:-none}; do serial+=(-serial "$device"); done

exec timeout --foreground "${FLICR_EMULATE_TIMEOUT:-300}" "${machine[@]}" -nographic -monitor none "${serial[@]}" \
    -icount shift=0 -semihosting-config "$semihosting" -kernel "$1" </dev/null
