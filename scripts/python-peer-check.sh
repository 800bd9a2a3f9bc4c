#!/bin/sh
# The Python peer of the link in a virtual environment of its own: its tests, also against the simulated gripper if that is built.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
environment=$target/python-peer
[ -x "$environment/bin/python" ] || python3 -m venv "$environment"
"$environment/bin/python" -m pip install --quiet --disable-pip-version-check pyserial pytest
gripctl=$target/release/gripctl
if [ -x "$gripctl" ]; then
    GRIPCTL=$gripctl
    export GRIPCTL
fi
cd "$root/protocol/python"
PYTHONPATH=src PYTHONDONTWRITEBYTECODE=1 "$environment/bin/python" -m pytest -q -p no:cacheprovider
