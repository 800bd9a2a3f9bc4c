#!/bin/sh
# The live view as an app would see it, by independent programs: gripd on the simulator and `gripfleet foxglove`, the Python package
# websockets as the app, mcap-ros2-support for the messages, and the recording of the same run to compare with. GRIPD and GRIPFLEET name
# built programs.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/scripts/missing.sh"
python_work foxglove-check
rm -rf "$work/files"
mkdir -p "$work/files"
"$python" "$root/fleet/scripts/peers/foxglove_check.py" "${GRIPD:?}" "${GRIPFLEET:?}" "$work/files"
