#!/bin/sh
# The fleet with a real router, gripfleet and gripctl beside one and together, the node of ROS 2 and the live view of Foxglove held against
# programs of others; what gripmon hears of a router; that gripd knows nothing of it, and neither do gripctl and gripmon without their
# features. Every call names the same packages and features, so that what they share is compiled once. The table in gripmon's window has scripts/fleet-window-check.sh.
set -eu
cd "$(dirname "$0")/.."

tree=$(cargo tree --locked -p gripd -p gripctl -p gripmon -e normal --prefix none)
if echo "$tree" | grep -E "^(zenoh|foxglove|grip-fleet|tokio) "; then
    echo "a default gripd, gripctl or gripmon contains the fleet" >&2
    exit 1
fi
# The story of a fleet builds its programs with the same choice.
STORIES_BUILD="-p grip-fleet -p grip-scope -p gripd -p gripctl -p gripfleet -p stories \
    --features grip-fleet/zenoh,grip-fleet/foxglove,grip-scope/zenoh,gripctl/fleet,gripctl/foxglove,stories/fleet"
export STORIES_BUILD
opted() {
    command=$1
    shift
    # Unquoted: these are words.
    cargo "$command" --locked $STORIES_BUILD "$@"
}
# Also copies of recordings (fleet_collect).
opted test --lib --test router --test quic --test deploy --test shadow --test ros --test ros_types
opted test --test cli --test scope -- fleet foxglove
opted test --test alone --test network --test fleet
opted build --bins --example ros_messages
built=$(cd "${CARGO_TARGET_DIR:-target}/debug" && pwd)
MESSAGES=$built/examples/ros_messages GRIPD=$built/gripd GRIPFLEET=$built/gripfleet GRIPCTL=$built/gripctl scripts/ros-check.sh
GRIPD=$built/gripd GRIPCTL=$built/gripctl scripts/foxglove-check.sh
# The subscriber of docs/fleet.md.
root=$(pwd)
. scripts/missing.sh
python_work fleet-check
rm -rf "$work"
mkdir -p "$work"
"$python" scripts/peers/fleet_check.py docs/fleet.md "$built/gripd" "$built/gripfleet" "$built/gripctl" "$work"
