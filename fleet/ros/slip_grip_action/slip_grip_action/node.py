"""``gripper_cmd``, a ParallelGripperCommand, on the socket of gripd: goals become GRASP, AT_LEAST and RELEASE, its states feedback and result.

    ros2 run slip_grip_action gripper_action --ros-args -p gripd:=socket://127.0.0.1:7747 -p joint:=finger

gripd decides with what force is held; a goal says whether to close, and the least force. It needs ``allow_commands`` of gripd and the package
grip_link (protocol/python). Not a safety function.
"""

import threading
import time

import rclpy
from control_msgs.action import ParallelGripperCommand
from grip_link import Daemon
from grip_link.messages.daemon import Command, GripStage, Operation, Scene, State, Subscribe, Topics
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState

from .goals import commands

FEEDBACK_S, LOST_S = 0.05, 0.5
"""Time between two looks at the states, and without one after which gripd is lost."""


class GripperAction(Node):
    """An action server, and a client of gripd that comes back."""

    def __init__(self):
        super().__init__("gripper_action")
        self.url = self.declare_parameter("gripd", "socket://127.0.0.1:7747").value
        self.joint = self.declare_parameter("joint", "finger").value
        # A position above this opens, any other one closes (m or rad).
        self.open_above = self.declare_parameter("open_above", 0.02).value
        self.patience_s = self.declare_parameter("patience_s", 5.0).value
        self.daemon, self.state, self.seen_s = None, None, 0.0
        self.lock, self.ended, self.newest = threading.Lock(), threading.Event(), None
        self.listener = threading.Thread(target=self.listen, daemon=True)
        self.listener.start()
        self.server = ActionServer(
            self, ParallelGripperCommand, "gripper_cmd", self.execute, goal_callback=self.asked, cancel_callback=lambda _: CancelResponse.ACCEPT
        )

    def listen(self):
        while not self.ended.is_set():
            try:
                with Daemon.open(self.url, Subscribe(topics=Topics.STATE, state_ms=20)) as daemon:
                    self.get_logger().info(f"gripd at {self.url}")
                    while not self.ended.is_set():
                        for message in daemon.messages(0.1):
                            if isinstance(message, State):
                                self.state, self.seen_s = message, time.monotonic()
            except OSError as error:
                self.state = None
                self.get_logger().warning(f"no gripd at {self.url}: {error}", throttle_duration_sec=5.0)
                self.ended.wait(0.5)

    def fresh(self):
        return self.state is not None and time.monotonic() - self.seen_s < LOST_S

    def asked(self, goal):
        """Only one joint and numbers that mean something, and only while gripd sends states."""
        named = not goal.command.name or list(goal.command.name) == [self.joint]
        try:
            commands(goal.command.position, goal.command.effort, self.open_above)
        except ValueError as error:
            self.get_logger().error(f"refused: {error}")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT if named and self.fresh() else GoalResponse.REJECT

    def order(self, orders):
        """Commands on a connection of their own; raises OSError, also where gripd refuses them."""
        with Daemon.open(self.url, Subscribe(topics=Topics(0))) as daemon:
            for operation, force_mn in orders:
                token = daemon.welcome.token if operation is Operation.RELEASE else 0
                daemon.command(Command(operation, force_mn=force_mn, token=token))

    def execute(self, handle):
        """A newer goal takes the place of this one; a cancel and a lost gripd end the wait, and the force stays."""
        command, result = handle.request.command, ParallelGripperCommand.Result()
        self.newest = handle
        try:
            orders = commands(command.position, command.effort, self.open_above)
            opens, force_mn = (Operation.RELEASE, 0) in orders, max(force_mn for _, force_mn in orders)
            with self.lock:
                self.order(orders)
        except (OSError, ValueError) as error:
            self.get_logger().error(f"refused: {error}")
            handle.abort()
            return result
        end = time.monotonic() + self.patience_s
        # What was seen up to now is from before the command.
        after_s = time.monotonic()
        while time.monotonic() < end and self.newest is handle and not handle.is_cancel_requested:
            time.sleep(FEEDBACK_S)
            state = self.state
            if state is None or not self.fresh():
                self.get_logger().error("gripd was lost")
                break
            if self.seen_s <= after_s:
                continue
            handle.publish_feedback(ParallelGripperCommand.Feedback(state=self.joint_state(state)))
            if opens and state.grip is GripStage.RELEASED:
                result.reached_goal = True
                break
            if not opens and state.grip is GripStage.HOLDING and state.scene is Scene.HOLDING and 1000 * state.command >= force_mn:
                result.stalled = True
                break
        if self.state is not None:
            result.state = self.joint_state(self.state)
        if result.reached_goal or result.stalled:
            handle.succeed()
        elif handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        return result

    def joint_state(self, state):
        """The commanded force; gripd does not know where the fingers are."""
        made = JointState(name=[self.joint], effort=[float(state.command)])
        made.header.stamp = self.get_clock().now().to_msg()
        return made


def main():
    rclpy.init()
    node = GripperAction()
    try:
        rclpy.spin(node, MultiThreadedExecutor(4))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.ended.set()


if __name__ == "__main__":
    main()
