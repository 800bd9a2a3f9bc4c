#!/bin/sh
# The Python peer of the link: mypy, its tests, and these against the Rust virtual gripper on a pseudo-terminal.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/scripts/missing.sh"
python_work python-peer

release_gripctl

cd "$root/protocol/python"
"$python" -m mypy --cache-dir "$work/mypy"
GRIPCTL=$GRIPCTL "$python" -m pytest -p no:cacheprovider "$@"
