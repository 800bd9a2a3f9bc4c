#!/bin/sh
# The ROS 2 node of a gripper as other implementations see it, without ROS: the Python packages rosbags (messages, hashes of types), xxhash
# (names of publishers) and eclipse-zenoh (a router, and a subscriber beside a real gripd on its simulator).
# Every block of docs/ros2.md is run. MESSAGES (the example ros_messages of grip-fleet), GRIPD and GRIPFLEET name built programs.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
. "$root/scripts/missing.sh"
python_work ros-check
cd "$root/fleet"
"$python" scripts/peers/ros_check.py "${MESSAGES:?}" ros/grip_msgs/msg "${GRIPD:?}" "${GRIPFLEET:?}"

# The page calls programs by their names, and a python3 that has the packages.
mkdir -p "$work"
{
    echo "trap 'kill \$(jobs -p)' EXIT"
    "$python" "$root/scripts/doc-blocks.py" docs/ros2.md
} >"$work/page.sh"
folders=$(dirname "$GRIPD"):$(dirname "$GRIPFLEET"):$(dirname "$python")
WORK=$work PATH=$folders:$PATH bash "$work/page.sh"
