"""``--robot.type=slipgrip``: an SO-100 or SO-101 with slip in its observations, and gripd at the torque limit of its gripper."""

from __future__ import annotations

import threading
import time
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Dict, List, Optional, Tuple

from grip_link import Config, Daemon, GripLink, LinkClosed
from grip_link.messages import ChannelKind
from grip_link.messages.daemon import Command, Operation, Subscribe, Topics, WelcomeFlags
from lerobot.robots import RobotConfig
from lerobot.robots.so_follower import SOFollower, SOFollowerRobotConfig
from slip_servo.bridge import Bridge, Scale
from slipgrip.lerobot import LiveSlip

NAMES = ("active", "need_n", "estimate_n", "held", "command_n")
"""Of ``slipgrip.lerobot.FEATURES``; they stand as ``slip.active`` and so on among the names of ``observation.state``."""
MOTOR = "gripper"


# Not a field of its own type for the arm: draccus, which reads the command line, does not end where a configuration holds one of its own kind.
@RobotConfig.register_subclass("slipgrip")
@dataclass(kw_only=True)
class SlipGripConfig(SOFollowerRobotConfig):
    sensor: str
    """Port of the board with the accelerometer: its first channel is the vibration."""
    rate_hz: int = 800
    rows: str = "127.0.0.1:7750"
    """Where ``gripd --port rows:tcp:127.0.0.1:7750`` waits for rows."""
    gripd: str = "socket://127.0.0.1:7747"
    full_n: float = 19.0
    """Force of a finger at the whole stall torque (N): measure yours with a kitchen scale."""
    most: int = 500
    """Largest torque limit that is written (0.1 %)."""
    trial_n: float = 1.5
    """With what the jaw closes (N): ``grip.trial_force_n`` of gripd."""
    opens: float = 5.0
    """A goal so far above the present place opens the jaw (0 to 100)."""


class Motor:
    """The gripper's servo on the bus of the arm, which others use too.

    A short answer is an IndexError of the servos' own package (scservo_sdk 1.0), an answer with a status bit (overload,
    overheating) a RuntimeError of LeRobot; here both are a bus that failed.
    """

    def __init__(self, bus: Any, lock: threading.RLock) -> None:
        self.bus, self.lock = bus, lock

    def limit(self, thousandths: int) -> None:
        self._surely(self.bus.write, "Torque_Limit", MOTOR, thousandths)

    def limited(self) -> int:
        return int(self._surely(self.bus.read, "Torque_Limit", MOTOR))

    def load(self) -> int:
        return abs(int(self._surely(self.bus.read, "Present_Load", MOTOR)))

    def powered(self) -> bool:
        return bool(self._surely(self.bus.read, "Torque_Enable", MOTOR))

    def _surely(self, call: Any, *arguments: Any) -> Any:
        with self.lock:
            try:
                return call(*arguments, normalize=False, num_retry=1)
            except IndexError as error:
                raise ConnectionError("a short answer") from error
            except RuntimeError as error:
                raise ConnectionError(str(error)) from error


class Board:
    """Readings of a board on the grip link; one that was unplugged is looked for."""

    def __init__(self, port: str, rate_hz: int) -> None:
        """Raises OSError, or ConnectionError where no board answers."""
        self.port, self.config = port, Config(sample_rate_hz=rate_hz, force_max_mn=0, hold_cap_mn=0)
        self.link: Optional[GripLink] = GripLink.open(port, self.config)
        self._offset_s: Optional[float] = None

    def readings(self) -> List[Tuple[float, float]]:
        """By the clock of the board, which always goes on; it is set by this computer's once."""
        try:
            if self.link is None:
                self.link, self._offset_s = GripLink.open(self.port, self.config), None
            found = []
            for sample in self.link.samples(0.002):
                board_s = sample.tick / self.link.ident.tick_hz
                self._offset_s = sample.host_s - board_s if self._offset_s is None else self._offset_s
                found.append((self._offset_s + board_s, sample[ChannelKind.STYLUS]))
            return found
        except (LinkClosed, OSError):
            self.close()
            time.sleep(0.2)
            return []

    def close(self) -> None:
        link, self.link = self.link, None
        if link is not None:
            link.close()


class SlipGrip(SOFollower):
    """The arm's observations and actions, and beside them what gripd knows of slip."""

    config_class = SlipGripConfig
    name = "slipgrip"

    def __init__(self, config: SlipGripConfig) -> None:
        super().__init__(config)
        self._lock, self._open = threading.RLock(), False
        self._board: Optional[Board] = None
        self._bridge: Optional[Bridge] = None
        self._live: Any = None
        self._orders: Any = None

    @cached_property
    def observation_features(self) -> Dict[str, Any]:
        return {**self._motors_ft, **{f"slip.{name}": float for name in NAMES}, **self._cameras_ft}

    def connect(self, calibrate: bool = True) -> None:
        """The arm, the board, then gripd, which must run. Raises OSError where one of them is not there, or takes no
        commands; then all of it is disconnected again."""
        super().connect(calibrate)
        try:
            self._join(self.config)
        except BaseException as error:
            try:
                self.disconnect()
            finally:
                raise error

    def _join(self, config: SlipGripConfig) -> None:
        self._board = Board(config.sensor, config.rate_hz)
        servo, scale = Motor(self.bus, self._lock), Scale(config.full_n, config.most)
        self._bridge = Bridge((config.rows, config.rate_hz), self._board.readings, servo, scale, config.trial_n)
        self._live = LiveSlip(config.gripd, NAMES)
        self._orders = Daemon.open(config.gripd, Subscribe(topics=Topics(0)))
        if not self._orders.welcome.flags & WelcomeFlags.COMMANDS:
            raise PermissionError("gripd takes no commands, and the jaw could not be opened: allow_commands = true")

    def get_observation(self) -> Dict[str, Any]:
        with self._lock:
            seen = super().get_observation()
        slip = {name.removeprefix("observation."): float(value[0]) for name, value in self._live.frame().items()}
        return {**seen, **slip}

    def send_action(self, action: Dict[str, Any]) -> Dict[str, Any]:
        """An action that opens the jaw releases gripd, one that closes it again asks for the next grasp."""
        goal = action.get(f"{MOTOR}.pos")
        with self._lock:
            if goal is not None:
                here = self.bus.read("Present_Position", MOTOR, num_retry=self.config.num_read_retries)
                if not self._open and goal > here + self.config.opens:
                    self._ask(Operation.RELEASE, self._orders.welcome.token)
                elif self._open and goal < here - self.config.opens:
                    self._ask(Operation.GRASP, 0)
            return super().send_action(action)

    def _ask(self, operation: Operation, token: int) -> None:
        self._orders.command(Command(operation, token=token))
        self._open = operation is Operation.RELEASE

    def disconnect(self) -> None:
        """Ends all of it; the configuration of the arm says whether its torque stays on."""
        parts = (self._board, self._orders, self._live, self._bridge)
        self._board = self._orders = self._live = self._bridge = None
        # From the last of them; each ends, whatever the one before says.
        with ExitStack() as ends:
            ends.callback(super().disconnect)
            for part in parts:
                if part is not None:
                    ends.callback(part.close)
