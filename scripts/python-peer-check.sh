#!/bin/sh
# The Python peer of the link: mypy, its tests, and these against the Rust virtual gripper on a pseudo-terminal.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
package=$root/protocol/python
. "$root/scripts/missing.sh"
python_work python-peer

CARGO_TARGET_DIR="$target" "$root/scripts/release-build.sh"

cd "$package"
"$python" -m mypy --cache-dir "$work/mypy"
GRIPCTL=$target/release/gripctl "$python" -m pytest -p no:cacheprovider "$@"
