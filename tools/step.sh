#!/usr/bin/env bash
# Runs a long step of the Makefile with a line before it, and one after it that says how long it took; both go to
# standard error, so that standard output is the command's alone.
#
#   tools/step.sh LABEL COMMAND [ARGUMENTS...]
set -uo pipefail

label=$1
shift
start=$(date +%s)
echo "==> $label" >&2
"$@" </dev/null
code=$?
seconds=$(($(date +%s) - start))
if ((code == 0)); then
    echo "<== $label: $seconds s" >&2
else
    echo "<== $label: FAILED with code $code after $seconds s" >&2
fi
exit $code
