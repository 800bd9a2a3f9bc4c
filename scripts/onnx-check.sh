#!/bin/sh
# Exports models of every shape with gripctl and compares them, run by onnxruntime, with the same networks computed in double
# precision by numpy from the model files. GRIPCTL names a built gripctl.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target/onnx-check"
target=$(cd "$target" && pwd)
work=$target/onnx-check
. "$root/scripts/missing.sh"
python=$("$root/scripts/python.sh") || { missing pip "the packages of scripts/python.sh"; exit 0; }

if [ -z "${GRIPCTL:-}" ]; then
    CARGO_TARGET_DIR="$target" "$root/scripts/release-build.sh"
    GRIPCTL=$target/release/gripctl
fi
rm -rf "$work/models"
mkdir -p "$work/models"
"$python" "$root/scripts/peers/onnx_check.py" "$GRIPCTL" "$work/models" "$root/crates/grip-session/models/default.json"
