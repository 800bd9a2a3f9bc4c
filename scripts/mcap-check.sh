#!/bin/sh
# Recordings read by an independent reader, the Python packages mcap and mcap-ros2-support: whole ones, and ones cut off at random
# places and recovered. GRIPCTL names a built program, beside which examples/recording lies.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/scripts/missing.sh"
python_work mcap-check
release_gripctl
recording=${GRIPCTL%gripctl}examples/recording
rm -rf "$work/files"
mkdir -p "$work/files"
"$recording" default 3 "$work/files/whole.mcap"
"$recording" moving 2 "$work/files/moving.mcap"
"$python" "$root/scripts/peers/mcap_check.py" "$GRIPCTL" "$work/files" "${CUTS:-40}"
