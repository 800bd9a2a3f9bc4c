#!/bin/sh
# From a clone to the first slip of a simulated SO-101, by the commands of bindings/lerobot/README.md; with `first` that is all.
# Then slipgrip.lerobot and the robot of bindings/lerobot with the package lerobot: datasets, live frames, an SO-101 on simulated servos, faults
# of its lines. lerobot brings PyTorch (8 GB on disk), and needs Python 3.12 or newer and ten minutes to install. PYTHON names another
# interpreter than python3, GRIPCTL a built gripctl beside gripd, LEROBOT_PYTHON an environment with lerobot, slipgrip and pytest.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target/lerobot"
target=$(cd "$target" && pwd)
work=$target/lerobot
export PYTHONPYCACHEPREFIX="$work/byte-code" HF_HOME="$work/hub" HF_HUB_OFFLINE=1

begin=$(date +%s)
rm -rf "$work/so101"
sed -n '/^```sh$/,/^```$/p; /^## With/q' "$root/bindings/lerobot/README.md" | sed "/^\`\`\`/d; s|[./]*/target|$target|; s|/tmp/so101|$work/so101|g" >"$work/first.sh"
(cd "$root" && CARGO_TARGET_DIR="$target" sh -eux "$work/first.sh")
echo "from a clone to the first slip: $(($(date +%s) - begin)) s"
[ "${1:-}" != first ] || exit 0

. "$root/scripts/missing.sh"
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
"$python" -m slip_servo.virtual "$GRIPD" --faults
