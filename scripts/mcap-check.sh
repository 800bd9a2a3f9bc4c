#!/bin/sh
# Recordings read by an independent reader, the Python packages mcap and mcap-ros2-support: whole ones, and ones cut off at random
# places and recovered. GRIPCTL and RECORDING name built programs.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target/mcap-check"
target=$(cd "$target" && pwd)
work=$target/mcap-check
. "$root/scripts/missing.sh"
python=$("$root/scripts/python.sh") || { missing pip "the packages of scripts/python.sh"; exit 0; }

if [ -z "${GRIPCTL:-}" ]; then
    CARGO_TARGET_DIR="$target" "$root/scripts/release-build.sh"
    GRIPCTL=$target/release/gripctl
fi
if [ -z "${RECORDING:-}" ]; then
    CARGO_TARGET_DIR="$target" "$root/scripts/release-build.sh"
    RECORDING=$target/release/examples/recording
fi
rm -rf "$work/files"
mkdir -p "$work/files"
"$RECORDING" default 3 "$work/files/whole.mcap"
"$RECORDING" moving 2 "$work/files/moving.mcap"
"$python" "$root/scripts/peers/mcap_check.py" "$GRIPCTL" "$work/files" "${CUTS:-40}"
