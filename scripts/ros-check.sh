#!/bin/sh
# The ROS 2 node of a gripper as other implementations see it, without ROS: the Python packages rosbags (messages, hashes of types), xxhash
# (names of publishers) and eclipse-zenoh (a router, and a subscriber beside a real gripd on its simulator).
# Every block of docs/ros2.md is run. MESSAGES (the example ros_messages of grip-fleet), GRIPD, GRIPFLEET and GRIPCTL (with its feature fleet)
# name built programs.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target"
target=$(cd "$target" && pwd)
. "$root/scripts/missing.sh"
python=$("$root/scripts/python.sh") || { missing pip "the packages of scripts/python.sh"; exit 0; }

if [ -z "${MESSAGES:-}" ]; then
    (cd "$root" && CARGO_TARGET_DIR="$target" cargo build --locked -p grip-fleet --features zenoh --example ros_messages)
    MESSAGES=$target/debug/examples/ros_messages
fi
if [ -z "${GRIPD:-}" ]; then
    (cd "$root" && CARGO_TARGET_DIR="$target" cargo build --locked -p gripd -p gripfleet -p gripctl --features gripctl/fleet)
    GRIPD=$target/debug/gripd GRIPFLEET=$target/debug/gripfleet GRIPCTL=$target/debug/gripctl
fi
"$python" "$root/scripts/peers/ros_check.py" "$MESSAGES" "$root/ros/grip_msgs/msg" "$GRIPD" "$GRIPFLEET"

# The page calls programs by their names, and a python3 that has the packages.
mkdir -p "$target/ros-check"
{
    echo "trap 'kill \$(jobs -p)' EXIT"
    "$python" "$root/scripts/doc-blocks.py" "$root/docs/ros2.md"
} >"$target/ros-check/page.sh"
folders=$(dirname "$GRIPD"):$(dirname "$GRIPFLEET"):$(dirname "$GRIPCTL"):$(dirname "$python")
cd "$root"
WORK=$target/ros-check PATH=$folders:$PATH bash "$target/ros-check/page.sh"
