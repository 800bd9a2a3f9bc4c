#!/bin/sh
# Datasets and live frames of slipgrip.lerobot as the package lerobot takes them. Not in .ci/run: lerobot brings PyTorch (8 GB on disk), and needs
# Python 3.10 or newer and ten minutes to install. PYTHON names another interpreter than python3, GRIPCTL a built gripctl beside gripd.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
work=$target/lerobot
mkdir -p "$work"
work=$(cd "$work" && pwd)
export PYTHONPYCACHEPREFIX="$work/byte-code" HF_HOME="$work/hub" HF_HUB_OFFLINE=1

if [ -z "${GRIPCTL:-}" ]; then
    CARGO_TARGET_DIR="$target" "$root/scripts/release-build.sh"
    GRIPCTL=$target/release/gripctl
fi
export GRIPCTL

[ -x "$work/venv/bin/python" ] || "${PYTHON:-python3}" -m venv "$work/venv"
python=$work/venv/bin/python
"$python" -m pip install --quiet --disable-pip-version-check lerobot==0.4.4 maturin pytest "$root/protocol/python"
rm -rf "$work/wheel"
(cd "$root/bindings/python" && CARGO_TARGET_DIR="$target" "$python" -m maturin build --profile dev --locked --quiet --out "$work/wheel")
"$python" -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps "$work"/wheel/*.whl

cd "$root/bindings/python"
"$python" -m pytest -q -p no:cacheprovider -W ignore tests/lerobot_package.py
