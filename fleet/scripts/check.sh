#!/bin/sh
# The fleet's tests; then a subscriber in Python, the node of ROS 2 and the live view of Foxglove held against programs of others; and that
# the root workspace knows nothing of a network. Builds gripd in the root workspace.
set -eu
cd "$(dirname "$0")/../.."
root=$(pwd)
. scripts/missing.sh
mkdir -p "${CARGO_TARGET_DIR:-target}"
CARGO_TARGET_DIR=$(cd "${CARGO_TARGET_DIR:-target}" && pwd)
export CARGO_TARGET_DIR

if grep -E '^name = "(zenoh|foxglove|quinn|grip-fleet)"' Cargo.lock; then
    echo "the root workspace contains the fleet" >&2
    exit 1
fi
cargo build --locked -p gripd
cd fleet
cargo test --locked --workspace
RUSTDOCFLAGS="-D warnings" cargo doc --locked --workspace --no-deps
cargo build --locked --workspace --bins
cargo build --locked -p grip-fleet --example ros_messages
built=$CARGO_TARGET_DIR/debug
MESSAGES=$built/examples/ros_messages GRIPD=$built/gripd GRIPFLEET=$built/gripfleet scripts/ros-check.sh
GRIPD=$built/gripd GRIPFLEET=$built/gripfleet scripts/foxglove-check.sh
ros/check.sh "$built/gripd"
../scripts/doc-commands.py "$built"
python_work fleet-check
rm -rf "$work"
mkdir -p "$work"
"$python" scripts/peers/fleet_check.py docs/subscriber.py "$built/gripd" "$built/gripfleet" "$work"
