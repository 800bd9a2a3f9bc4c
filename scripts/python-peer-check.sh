#!/bin/sh
# The Python peer of the link: mypy, its tests, and these against the Rust virtual gripper on a pseudo-terminal.
# Makes a virtual environment under the target folder. PYTHON names another interpreter than python3.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target/python-peer"
target=$(cd "$target" && pwd)
work=$target/python-peer
package=$root/protocol/python
export PYTHONPYCACHEPREFIX="$work/byte-code"

CARGO_TARGET_DIR="$target" "$root/scripts/release-build.sh"

if ! cmp -s "$package/pyproject.toml" "$work/pyproject.toml" || [ ! -x "$work/environment/bin/python" ]; then
    "${PYTHON:-python3}" -m venv --clear "$work/environment"
    "$work/environment/bin/python" -m pip install --quiet --disable-pip-version-check --editable "$package[dev]"
    cp "$package/pyproject.toml" "$work/pyproject.toml"
fi

cd "$package"
"$work/environment/bin/python" -m mypy --cache-dir "$work/mypy"
GRIPCTL=$target/release/gripctl "$work/environment/bin/python" -m pytest -p no:cacheprovider "$@"
