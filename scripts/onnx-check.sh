#!/bin/sh
# Exports models of every shape with gripctl and compares them, run by onnxruntime, with the same networks computed in double
# precision by numpy from the model files. GRIPCTL names a built gripctl.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/scripts/missing.sh"
python_work onnx-check
release_gripctl
rm -rf "$work/models"
mkdir -p "$work/models"
"$python" "$root/scripts/peers/onnx_check.py" "$GRIPCTL" "$work/models" "$root/crates/grip-session/models/default.json"
