#!/usr/bin/env bash
# The packages of this folder with what ROS 2 Kilted has in the Python index (rclpy, Fast DDS, rosidl, ament, colcon; 400 MB): grip_msgs is
# built by colcon, and a ROS client drives gripd over slip_grip_action, both ways. Neither rclcpp nor ros2_control is there: the controller is
# laid out and built with an imitation of them, and ci.sh is for a container of ROS. control_msgs, which is not there, is its one action.
#
#   fleet/ros/check.sh GRIPD [SLIP]      SLIP: folder of scripts/c-library.sh; without it the controller is left out
#
# Needs python3 3.11 to 3.13 with venv and its headers, a C++ compiler, and a package index. Some minutes.
set -euo pipefail
gripd=$(realpath "${1:?usage: check.sh GRIPD [SLIP]}")
slip=${2:+$(realpath "$2")}
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
mkdir -p "${CARGO_TARGET_DIR:-$root/target}/ros"
work=$(cd "${CARGO_TARGET_DIR:-$root/target}/ros" && pwd)
venv=$work/venv
. "$root/scripts/missing.sh"
if [ ! -e "$work/installed" ]; then
    "${PYTHON:-python3}" -m venv --clear "$venv"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check colcon-common-extensions cmake empy==3.3.4 "$root/protocol/python" \
        ros-{rclpy,rmw-fastrtps-cpp,sensor-msgs,rosidl-default-generators,rosidl-core-generators,ament-package,fastrtps-cmake-module} \
        ros-{ament-cmake,ament-cmake-ros,ament-cmake-ros-core,ament-cmake-include-directories,ament-cmake-gtest,ament-cmake-gmock,ament-cmake-pytest} \
        ros-python-cmake-module || { missing pip "ROS 2 of the Python index"; exit 0; }
    # Where the wheels were built Python stood elsewhere.
    include=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("include"))')
    packages=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
    grep -rlE '/opt/python/cp3' "$venv/share" | xargs sed -i -E \
        -e "s#/opt/python/cp3[0-9]+-cp3[0-9]+/include/python3\.[0-9]+#$include#g" \
        -e "s#/opt/python/cp3[0-9]+-cp3[0-9]+/lib/python3\.[0-9]+/site-packages#$packages#g"
    touch "$work/installed"
fi

space=$work/space
mkdir -p "$space/src/control_msgs/action"
printf '%s\n' 'sensor_msgs/JointState command' --- 'sensor_msgs/JointState state' 'bool stalled' 'bool reached_goal' --- \
    'sensor_msgs/JointState state' >"$space/src/control_msgs/action/ParallelGripperCommand.action"
sed -e 's/<name>.*</<name>control_msgs</' -e 's/std_msgs/sensor_msgs/' "$here/grip_msgs/package.xml" >"$space/src/control_msgs/package.xml"
sed -e 's/grip_msgs/control_msgs/' -e 's/std_msgs/sensor_msgs/' -e '/SlipEvent/d' -e 's#msg/GripState.msg#action/ParallelGripperCommand.action#' \
    "$here/grip_msgs/CMakeLists.txt" >"$space/src/control_msgs/CMakeLists.txt"
rm -rf "$space/src/grip_msgs" "$space/src/slip_grip_action" "$space/src/slip_grip_controller"
cp -R "$here/grip_msgs" "$here/slip_grip_action" "$space/src/"
packages=(control_msgs grip_msgs slip_grip_action)
prefix=$venv
if [ -n "$slip" ]; then
    cp -R "$here/slip_grip_controller" "$space/src/"
    packages+=(slip_grip_controller)
    for name in controller_interface pluginlib; do
        mkdir -p "$work/imitation/lib/cmake/$name"
        {
            echo "add_library($name::$name INTERFACE IMPORTED)"
            echo "target_include_directories($name::$name INTERFACE $here/slip_grip_controller/test/mock)"
            echo 'macro(pluginlib_export_plugin_description_file)'
            echo 'endmacro()'
        } >"$work/imitation/lib/cmake/$name/${name}Config.cmake"
    done
    prefix=$prefix:$slip:$work/imitation
fi
# shellcheck disable=SC1091 # made above
. "$venv/bin/activate"
export CMAKE_PREFIX_PATH=$prefix AMENT_PREFIX_PATH=$venv PYTHONDONTWRITEBYTECODE=1 ROS_LOG_DIR=$work/log ROS_DOMAIN_ID=77 ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST
cd "$space"
colcon build --executor sequential --packages-select "${packages[@]}" --event-handlers console_cohesion- \
    --cmake-args -DBUILD_TESTING=OFF "-DPython3_EXECUTABLE=$venv/bin/python" -Wno-dev
set +u
# shellcheck disable=SC1091 # made by colcon
. install/local_setup.bash
set -u
export LD_LIBRARY_PATH=$venv/lib:${LD_LIBRARY_PATH:-}
python "$here/slip_grip_action/test/test_goals.py"
timeout 200 python "$here/slip_grip_action/test/try.py" "$gripd"
echo "ros check: done"
