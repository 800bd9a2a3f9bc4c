#!/bin/sh
# Recordings read by an independent reader, the Python packages mcap and mcap-ros2-support: whole ones, and ones cut off at random
# places and recovered. Makes a virtual environment under the target folder; where the packages are not to be had, says so and checks
# nothing. PYTHON names another interpreter than python3; GRIPCTL and RECORDING built programs.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target/mcap-check"
target=$(cd "$target" && pwd)
work=$target/mcap-check
python=$work/environment/bin/python

if [ -z "${GRIPCTL:-}" ]; then
    CARGO_TARGET_DIR="$target" "$root/scripts/release-build.sh"
    GRIPCTL=$target/release/gripctl
fi
if [ -z "${RECORDING:-}" ]; then
    CARGO_TARGET_DIR="$target" "$root/scripts/release-build.sh"
    RECORDING=$target/release/examples/recording
fi
[ -x "$python" ] || "${PYTHON:-python3}" -m venv --clear "$work/environment"
if ! "$python" -c 'import mcap, mcap_ros2' 2>/dev/null; then
    if ! "$python" -m pip install --quiet --disable-pip-version-check mcap mcap-ros2-support; then
        echo "mcap-check: mcap-ros2-support cannot be installed for $("$python" --version): left out" >&2
        exit 0
    fi
fi
rm -rf "$work/files"
mkdir -p "$work/files"
"$RECORDING" default 3 "$work/files/whole.mcap"
"$RECORDING" moving 2 "$work/files/moving.mcap"
"$python" "$root/scripts/peers/mcap_check.py" "$GRIPCTL" "$work/files" "${CUTS:-40}"
