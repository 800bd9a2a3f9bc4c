#!/bin/sh
# The ROS 2 node of a gripper as other implementations see it, without ROS: the Python packages rosbags (messages, hashes of types), xxhash
# (names of publishers) and eclipse-zenoh (a router, and a subscriber beside a real gripd on its simulator). Makes a virtual environment
# under the target folder; where the packages are not to be had, says so and checks nothing. PYTHON names another interpreter than python3;
# MESSAGES (the example ros_messages of grip-fleet) and GRIPD (with the feature fleet) built programs.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
mkdir -p "$target/ros-check"
target=$(cd "$target" && pwd)
python=$target/ros-check/environment/bin/python

if [ -z "${MESSAGES:-}" ]; then
    (cd "$root" && CARGO_TARGET_DIR="$target" cargo build --locked -p grip-fleet --features zenoh --example ros_messages)
    MESSAGES=$target/debug/examples/ros_messages
fi
if [ -z "${GRIPD:-}" ]; then
    (cd "$root" && CARGO_TARGET_DIR="$target" cargo build --locked -p gripd --features fleet)
    GRIPD=$target/debug/gripd
fi
[ -x "$python" ] || "${PYTHON:-python3}" -m venv --clear "$target/ros-check/environment"
if ! "$python" -c 'import rosbags, xxhash, zenoh' 2>/dev/null; then
    if ! "$python" -m pip install --quiet --disable-pip-version-check rosbags xxhash eclipse-zenoh; then
        echo "ros-check: rosbags, xxhash and eclipse-zenoh cannot be installed for $("$python" --version): left out" >&2
        exit 0
    fi
fi
"$python" "$root/scripts/peers/ros_check.py" "$MESSAGES" "$root/ros/grip_msgs/msg" "$GRIPD"
