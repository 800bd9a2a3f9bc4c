#!/bin/sh
# Makes the pictures of gripmon in docs/images from the real window of the release binary, on a display of its own.
# GRIP_BIN names a folder that holds gripmon and gripd already; without it a release build is made.
# GRIP_FLEET_BIN names a folder with gripd, gripfleet and gripmon-fleet: then the table of many is made too.
# Needs: apt-get install -y --no-install-recommends xvfb
# Live pictures differ from run to run in what the simulator was just doing; what is looked at stands in docs/views.
set -eu
cd "$(dirname "$0")/.."
command -v xvfb-run >/dev/null || { echo "Xvfb is not installed: apt-get install -y --no-install-recommends xvfb" >&2; exit 1; }
[ -n "${GRIP_OWN_DISPLAY:-}" ] ||
    exec env GRIP_OWN_DISPLAY=1 xvfb-run --auto-servernum --server-args='-screen 0 1440x900x24 -noreset' scripts/screenshots.sh

binaries=${GRIP_BIN:-}
if [ -z "$binaries" ]; then
    cargo build --release -p gripmon -p gripd
    binaries="${CARGO_TARGET_DIR:-target}/release"
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

picture() {
    echo "docs/images/$1.png"
    "$binaries/gripmon" "$2" --view "${3:-docs/views/$1.toml}" --picture "docs/images/$1.png"
    size=$(wc -c <"docs/images/$1.png")
    [ "$size" -lt 300000 ] || { echo "docs/images/$1.png has $size bytes: more than 300,000" >&2; exit 1; }
}

mkdir -p docs/images
picture live demo
picture light demo
picture event demo
picture cursors demo
picture spectrogram demo
picture explain demo
for hint in 1 2 3; do
    sed "s/^tour = .*/tour = $hint/" docs/views/tour.toml >"$work/tour.toml"
    picture "tour-$hint" demo "$work/tour.toml"
done

# A grasp whose stylus sends the same reading from 1.2 s on.
# A busy machine loses samples (exit code 3) or even the object: then again.
tries=0
until rm -f "$work/whole.csv" && "$binaries/gripd" --port sim --seed 3 --duration 2.5 --record "$work/whole.csv" >"$work/gripd.log" 2>&1; do
    tries=$((tries + 1))
    [ "$tries" -lt 10 ] || { echo "no recording without loss:" >&2; cat "$work/gripd.log" >&2; exit 1; }
done
awk -F, -v OFS=, 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == "stylus") column = i; print; next }
    $1 < 1.2 { held = $column } { $column = held; print }' "$work/whole.csv" >"$work/frozen.csv"
picture fault "$work/frozen.csv"

# Seven grippers on a router of their own for two and a half minutes; one ends before, one slips all the time.
[ -n "${GRIP_FLEET_BIN:-}" ] || exit 0
binaries=$GRIP_FLEET_BIN
router=tcp/127.0.0.1:17447
"$binaries/gripfleet" router --listen "$router" >"$work/router.log" 2>&1 &
fleet=$!
trap 'kill $fleet 2>/dev/null; rm -rf "$work"' EXIT
sleep 2
seed=0
for scene in default shaken tug light_rough moving_arm glass_bottle_full oily_steel; do
    seed=$((seed + 1))
    site=hall-$((1 + seed / 5))
    seconds=300
    [ "$seed" -ne 6 ] || seconds=100
    printf 'listen = "unix:%s"\n[link]\nsample_rate_hz = 1000\n[fleet]\nsite = "%s"\nrouter = "%s"\n' \
        "$work/$seed.sock" "$site" "$router" >"$work/$seed.toml"
    "$binaries/gripd" --port "sim:$scene" --seed "$seed" --config "$work/$seed.toml" --duration "$seconds" >"$work/$seed.log" 2>&1 &
    fleet="$fleet $!"
    "$binaries/gripfleet" --config "$work/$seed.toml" >>"$work/$seed.log" 2>&1 &
    fleet="$fleet $!"
done
"$binaries/gripmon-fleet" "$router" --view fleet/docs/fleet.toml --picture fleet/docs/fleet.png
