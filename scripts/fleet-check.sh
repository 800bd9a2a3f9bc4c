#!/bin/sh
# What no default build contains: the fleet with a real router, gripd, gripctl and gripmon beside one, the node of ROS 2 and the live view
# of Foxglove held against programs of others; and that the default programs know nothing of it. Some 220 more crates are compiled, once:
# every call names the same packages and features, and what `cargo test --workspace` has built is used again.
set -eu
cd "$(dirname "$0")/.."

tree=$(cargo tree --locked -p gripd -p gripctl -p gripmon -e normal --prefix none)
if echo "$tree" | grep -E "^(zenoh|foxglove|grip-fleet|tokio) "; then
    echo "a default gripd, gripctl or gripmon contains the fleet" >&2
    exit 1
fi
opted() {
    command=$1
    shift
    cargo "$command" --locked --workspace \
        --features grip-fleet/zenoh,grip-fleet/foxglove,grip-scope/zenoh,gripd/fleet,gripctl/fleet,gripctl/foxglove,gripmon/fleet "$@"
}
opted test --lib -- fleet live ros net recordings follower spool bridge deploy rollout
opted test --test router --test tls --test deploy --test ros --test ros_types
# Also models (fleet_models) and copies of recordings (fleet_collect).
opted test --test daemon --test cli --test window -- fleet foxglove
opted build --bins --example ros_messages
built=${CARGO_TARGET_DIR:-target}/debug
MESSAGES=$built/examples/ros_messages GRIPD=$built/gripd scripts/ros-check.sh
GRIPD=$built/gripd GRIPCTL=$built/gripctl scripts/foxglove-check.sh
