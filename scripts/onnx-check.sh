#!/bin/sh
# Exports models of every shape with gripctl and compares them, run by onnxruntime, with the same networks computed in double
# precision by numpy from the model files. Makes a virtual environment under the target folder; where onnxruntime is not to be
# had for this Python, says so and checks nothing. PYTHON names another interpreter than python3, GRIPCTL a built gripctl.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target/onnx-check"
target=$(cd "$target" && pwd)
work=$target/onnx-check
python=$work/environment/bin/python

if [ -z "${GRIPCTL:-}" ]; then
    CARGO_TARGET_DIR="$target" "$root/scripts/release-build.sh"
    GRIPCTL=$target/release/gripctl
fi
[ -x "$python" ] || "${PYTHON:-python3}" -m venv --clear "$work/environment"
if ! "$python" -c 'import numpy, onnx, onnxruntime' 2>/dev/null; then
    if ! "$python" -m pip install --quiet --disable-pip-version-check numpy onnx onnxruntime; then
        echo "onnx-check: onnxruntime cannot be installed for $("$python" --version): left out" >&2
        exit 0
    fi
fi
rm -rf "$work/models"
mkdir -p "$work/models"
"$python" "$root/scripts/peers/onnx_check.py" "$GRIPCTL" "$work/models" "$root/crates/grip-host/models/default.json"
