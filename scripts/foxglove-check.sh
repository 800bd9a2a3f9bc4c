#!/bin/sh
# The live view as an app would see it, by independent programs: gripd on the simulator and `gripctl foxglove`, the Python package
# websockets as the app, mcap-ros2-support for the messages, and the recording of the same run to compare with. GRIPD and GRIPCTL name
# built programs, the latter with the feature foxglove.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target/foxglove-check"
target=$(cd "$target" && pwd)
work=$target/foxglove-check
. "$root/scripts/missing.sh"
python=$("$root/scripts/python.sh") || { missing pip "the packages of scripts/python.sh"; exit 0; }

if [ -z "${GRIPD:-}" ] || [ -z "${GRIPCTL:-}" ]; then
    (cd "$root" && CARGO_TARGET_DIR="$target" cargo build --locked -p gripd -p gripctl --features gripctl/foxglove)
    GRIPD=${GRIPD:-$target/debug/gripd}
    GRIPCTL=${GRIPCTL:-$target/debug/gripctl}
fi
rm -rf "$work/files"
mkdir -p "$work/files"
"$python" "$root/scripts/peers/foxglove_check.py" "$GRIPD" "$GRIPCTL" "$work/files"
