"""Both ways with a client of ROS: gripd on its simulator and the node of this package are started; try.py GRIPD

Needs rclpy and control_msgs in its environment; scripts of fleet/ros/check.sh make one from packages of the Python index.
"""

import os
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import rclpy
from control_msgs.action import ParallelGripperCommand
from grip_link import Daemon
from grip_link.messages.daemon import GripStage, State
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState


def goal(node, client, position, effort=()):
    """Accepted or not, feedback, result."""
    states = []
    command = JointState(name=["finger"], position=[position], effort=list(effort))
    sent = client.send_goal_async(ParallelGripperCommand.Goal(command=command), lambda message: states.append(message.feedback.state))
    rclpy.spin_until_future_complete(node, sent, timeout_sec=10)
    if not sent.result().accepted:
        return False, states, None
    ended = sent.result().get_result_async()
    rclpy.spin_until_future_complete(node, ended, timeout_sec=15)
    return True, states, ended.result().result


def main():
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    folder = tempfile.TemporaryDirectory()
    Path(folder.name, "gripd.toml").write_text("allow_commands = true\n")
    gripd = [os.path.abspath(sys.argv[1]), "--port", "sim", "--config", "gripd.toml", "--listen", f"tcp:127.0.0.1:{port}"]
    running = subprocess.Popen(gripd, cwd=folder.name, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    action = subprocess.Popen(
        [sys.executable, "-m", "slip_grip_action.node", "--ros-args", "-p", f"gripd:=socket://127.0.0.1:{port}", "-p", "patience_s:=20.0"]
    )
    rclpy.init()
    node = rclpy.create_node("tries")
    client = ActionClient(node, ParallelGripperCommand, "gripper_cmd")
    try:
        assert client.wait_for_server(timeout_sec=30), "no server"
        begin = time.monotonic()
        result = None
        # Until gripd listens, and knows the sensor's noise: refused, or aborted.
        while not (result and result.stalled) and time.monotonic() < begin + 30:
            accepted, states, result = goal(node, client, 0.0)
        assert accepted and result.stalled and states and result.state.effort[0] > 0, (accepted, result)
        print(f"closed: holds with {result.state.effort[0]:.2f} N, {len(states)} states meanwhile")
        accepted, states, result = goal(node, client, 0.0, [12.0])
        assert accepted and result.stalled and result.state.effort[0] >= 12.0, (accepted, result)
        print(f"closed with at least 12 N: holds with {result.state.effort[0]:.2f} N")
        accepted, states, result = goal(node, client, 0.08)
        assert accepted and result.reached_goal, (accepted, result)
        print("opened: released")
        for position, effort in ((float("nan"), []), (0.0, [float("inf")]), (0.0, [float("nan")]), (0.0, [-1.0])):
            assert not goal(node, client, position, effort)[0], (position, effort)
        # Accepted, because only gripd knows its largest force; then it refuses, and the fingers stay open.
        accepted, _, result = goal(node, client, 0.0, [1e5])
        assert accepted and not result.stalled
        with Daemon.open(f"socket://127.0.0.1:{port}") as daemon:
            stages = [message.grip for message in daemon.messages(0.5) if isinstance(message, State)]
        assert set(stages) == {GripStage.RELEASED}, stages
        print("no number, or too large: refused, still open")
        states = []
        command = JointState(name=["finger"], position=[0.0], effort=[15.0])
        sent = client.send_goal_async(ParallelGripperCommand.Goal(command=command), states.append)
        rclpy.spin_until_future_complete(node, sent, timeout_sec=10)
        while not states and time.monotonic() < begin + 60:
            rclpy.spin_once(node, timeout_sec=0.1)
        running.kill()
        running.wait()
        begin, ended = time.monotonic(), sent.result().get_result_async()
        rclpy.spin_until_future_complete(node, ended, timeout_sec=5)
        assert ended.done() and not ended.result().result.stalled, "a wait for a lost gripd"
        print(f"gripd lost: the wait ends after {time.monotonic() - begin:.1f} s")
        time.sleep(1.5)
        accepted, _, result = goal(node, client, 0.0)
        assert not accepted, "a goal without gripd"
        print("gripd gone: refused")
    finally:
        for process in (running, action):
            process.kill()
            process.wait()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
