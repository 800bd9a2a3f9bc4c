#!/usr/bin/env bash
# The packages of this folder in a container of ROS 2, ros:jazzy or ros:kilted, with the real ros2_control. Never run where this was made.
#
#   docker run --rm -v "$PWD:/grip" ros:jazzy /grip/fleet/ros/ci.sh
#
# Needs the network; cargo of rustup, because the library needs Rust 1.95.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
apt-get update -q
apt-get install -y -q --no-install-recommends curl gcc g++ "ros-$ROS_DISTRO"-{controller-interface,pluginlib,control-msgs,rclpy,rmw-fastrtps-cpp} python3-pip
curl -sSf https://sh.rustup.rs | sh -s -- -y --profile minimal --default-toolchain none
export PATH=$HOME/.cargo/bin:$PATH CARGO_TARGET_DIR=/tmp/target
"$root/scripts/c-library.sh" /opt/slip
(cd "$root" && cargo build --locked --release -p gripd)
python3 -m pip install --break-system-packages --quiet "$root/protocol/python"
mkdir -p /tmp/space/src
cp -R "$root"/fleet/ros/{grip_msgs,slip_grip_action,slip_grip_controller} /tmp/space/src/
cd /tmp/space
set +u
. "/opt/ros/$ROS_DISTRO/setup.bash"
CMAKE_PREFIX_PATH=/opt/slip:$CMAKE_PREFIX_PATH colcon build
. install/local_setup.bash
python3 src/slip_grip_action/test/test_goals.py
python3 src/slip_grip_action/test/try.py /tmp/target/release/gripd
