#!/bin/sh
# The Python package slipgrip: its wheel is built and installed into an empty environment; then mypy over stubs, tests and examples, the
# tests, the examples, and every block of docs/python.md. GRIPCTL names a built gripctl, beside gripd. FUZZ_CALLS: random calls, 100,000 unless given.
# PICTURES=1 writes the pictures of the examples to docs/images; LINTS=1 runs clippy, which checks every crate below anew.
#
#   scripts/python-package-check.sh [PROFILE]      PROFILE is release, or dev for a quicker build
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
package=$root/bindings/python
. "$root/scripts/missing.sh"
python_work python-package

release_gripctl
export GRIPCTL

cd "$package"
cargo fmt --check
rm -rf "$work/wheel" "$work/pictures" "$work/dataset"
mkdir -p "$work/pictures"
if [ -n "${LINTS:-}" ]; then
    CARGO_TARGET_DIR="$target" cargo clippy --all-targets --locked --quiet -- -D warnings
fi
CARGO_TARGET_DIR="$target" "$python" -m maturin build --profile "${1:-release}" --locked --quiet --out "$work/wheel"

# Ten lines in an environment that has the wheel and what that needs: the events of gripctl, to the sample.
"$python" -m venv --clear "$work/empty"
"$work/empty/bin/python" -m pip install --quiet --disable-pip-version-check "$work"/wheel/*.whl
recording=${GRIP_DATA:-$root/../shared/data}/biotac_slide/m02_03.csv
if [ -e "$recording" ]; then
    "$work/empty/bin/python" "$package/examples/ten_lines.py" "$recording" >"$work/events.jsonl"
    "$GRIPCTL" replay --observe --json "$recording" >"$work/replay.jsonl"
    "$python" - "$work/events.jsonl" "$work/replay.jsonl" <<'PY'
import json, sys
ours, theirs = ([json.loads(line) for line in open(name)] for name in sys.argv[1:])
for event in ours:
    del event["sample"]
assert ours == theirs[:-1] and len(ours) > 1, (ours, theirs)
print(f"ten lines in an empty environment: {len(ours)} events, those of gripctl")
PY
else
    missing data "$recording"
fi

# The same wheel beside mypy, pytest and what the examples draw with.
"$python" -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps "$work"/wheel/*.whl
"$python" -m mypy --cache-dir "$work/mypy"
"$python" -m pytest -q -p no:cacheprovider
# Of the robot for LeRobot what needs no LeRobot.
(cd "$root/bindings/lerobot" && "$python" -m pytest -q -p no:cacheprovider tests)
for example in detect calibrate esc_truth close_the_loop; do
    "$python" "examples/$example.py" "$work/pictures/python-$example.svg"
done
# The page listens to a gripd at its usual place.
"${GRIPCTL%ctl}d" --port sim --duration 120 >"$work/gripd.log" 2>&1 &
gripd=$!
trap 'kill "$gripd" 2>/dev/null || true' EXIT
"$python" "$root/scripts/doc-blocks.py" "$root/docs/python.md" python >"$work/page.py"
grep -q import "$work/page.py"
(cd "$work" && "$python" page.py)
if [ -n "${PICTURES:-}" ]; then
    cp "$work"/pictures/*.svg "$root/docs/images/"
fi
