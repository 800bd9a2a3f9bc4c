#!/bin/sh
# slipgrip.lerobot and the robot of bindings/lerobot with the package lerobot: datasets, live frames, an SO-101 on simulated servos, faults of
# its lines. Not in .ci/run: lerobot brings PyTorch (8 GB on disk), and needs Python 3.12 or newer and ten minutes to install. PYTHON names
# another interpreter than python3, GRIPCTL a built gripctl beside gripd, LEROBOT_PYTHON an environment with lerobot, slipgrip and pytest.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
work=$target/lerobot
mkdir -p "$work"
work=$(cd "$work" && pwd)
export PYTHONPYCACHEPREFIX="$work/byte-code" HF_HOME="$work/hub" HF_HUB_OFFLINE=1

. "$root/scripts/missing.sh"
target=$(cd "$target" && pwd)
release_gripctl
export GRIPCTL GRIPD="${GRIPCTL%ctl}d"

python=${LEROBOT_PYTHON:-$work/venv/bin/python}
if [ -z "${LEROBOT_PYTHON:-}" ]; then
    [ -x "$python" ] || "${PYTHON:-python3}" -m venv "$work/venv"
    "$python" -m pip install --quiet --disable-pip-version-check 'lerobot[dataset,feetech]==0.6.1' maturin pytest "$root/protocol/python"
    rm -rf "$work/wheel"
    (cd "$root/bindings/python" && CARGO_TARGET_DIR="$target" "$python" -m maturin build --profile dev --locked --quiet --out "$work/wheel")
    "$python" -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps "$work"/wheel/*.whl
    "$python" -m pip install --quiet --disable-pip-version-check --no-deps "$root/bindings/lerobot"
fi

(cd "$root/bindings/python" && "$python" -m pytest -q -p no:cacheprovider -W ignore tests/lerobot_package.py)
cd "$root/bindings/lerobot"
# LeRobot gives a servo 50 ms; where processes of others take them, real-time priority keeps the simulated ones in time.
first=
! chrt -r 1 true 2>/dev/null || first="chrt -r 1"
"$python" -m pytest -q -p no:cacheprovider -W ignore tests/test_slip_servo.py
$first "$python" -m pytest -q -p no:cacheprovider -W ignore tests/lerobot_robot.py
"$python" -m slip_servo.virtual "$GRIPD"
"$python" -m slip_servo.virtual "$GRIPD" --faults
