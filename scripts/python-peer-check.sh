#!/bin/sh
# The Python peer of the link: mypy, its tests, and these against the Rust virtual gripper on a pseudo-terminal.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target/python-peer"
target=$(cd "$target" && pwd)
work=$target/python-peer
package=$root/protocol/python
. "$root/scripts/missing.sh"
python=$("$root/scripts/python.sh") || { missing pip "the packages of scripts/python.sh"; exit 0; }
export PYTHONPYCACHEPREFIX="$work/byte-code"

CARGO_TARGET_DIR="$target" "$root/scripts/release-build.sh"

cd "$package"
"$python" -m mypy --cache-dir "$work/mypy"
GRIPCTL=$target/release/gripctl "$python" -m pytest -p no:cacheprovider "$@"
