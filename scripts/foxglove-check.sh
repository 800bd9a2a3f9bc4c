#!/bin/sh
# The live view as an app would see it, by independent programs: gripd on the simulator and `gripctl foxglove`, the Python package
# websockets as the app, mcap-ros2-support for the messages, and the recording of the same run to compare with. Makes a virtual
# environment under the target folder; where the packages are not to be had, says so and checks nothing. PYTHON names another
# interpreter than python3; GRIPD and GRIPCTL built programs, the latter with the feature foxglove.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target/foxglove-check"
target=$(cd "$target" && pwd)
work=$target/foxglove-check
python=$work/environment/bin/python

if [ -z "${GRIPD:-}" ] || [ -z "${GRIPCTL:-}" ]; then
    (cd "$root" && CARGO_TARGET_DIR="$target" cargo build --locked -p gripd -p gripctl --features gripctl/foxglove)
    GRIPD=${GRIPD:-$target/debug/gripd}
    GRIPCTL=${GRIPCTL:-$target/debug/gripctl}
fi
[ -x "$python" ] || "${PYTHON:-python3}" -m venv --clear "$work/environment"
if ! "$python" -c 'import mcap, mcap_ros2, websockets' 2>/dev/null; then
    if ! "$python" -m pip install --quiet --disable-pip-version-check mcap mcap-ros2-support websockets; then
        echo "foxglove-check: its packages cannot be installed for $("$python" --version): left out" >&2
        exit 0
    fi
fi
rm -rf "$work/files"
mkdir -p "$work/files"
"$python" "$root/scripts/peers/foxglove_check.py" "$GRIPD" "$GRIPCTL" "$work/files"
