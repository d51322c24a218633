#!/usr/bin/env bash
# Runs a long step of the Makefile with a line before it, and one after it that says how long it took.
#
#   tools/step.sh LABEL COMMAND [ARGUMENTS...]
set -uo pipefail

label=$1
shift
start=$(date +%s)
echo "==> $label"
"$@" </dev/null
code=$?
seconds=$(($(date +%s) - start))
if ((code == 0)); then
    echo "<== $label: $seconds s"
else
    echo "<== $label: FAILED with code $code after $seconds s" >&2
fi
exit $code
