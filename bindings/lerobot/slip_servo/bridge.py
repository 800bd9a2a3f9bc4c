"""Between gripd and a gripper of one servo: readings of an accelerometer and the load go there as rows, forces come back as torque limits.

Needs neither LeRobot nor a package of it.
"""

from __future__ import annotations

import json
import logging
import math
import os
import socket
import threading
import time
from typing import Any, Callable, List, Optional, Protocol, Tuple

logger = logging.getLogger(__name__)

LOAD_S, REPEAT_S, RETRY_S = 0.02, 0.2, 0.5
"""Time between two readings of the load, two writes of the same limit, two tries to connect."""
LOOKS = 5
"""Readings of the load before the first limit is written."""


def urgent(priority: int) -> None:
    """Real-time priority for this thread, where that is allowed: on a busy computer it is late without."""
    try:
        os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
    except (AttributeError, OSError):
        pass


class Servo(Protocol):
    """What a gripper's servo can do; each raises OSError where the bus fails. In 0.1 % of the stall torque."""

    def limit(self, thousandths: int) -> None: ...
    def limited(self) -> int: ...
    def load(self) -> int: ...
    def powered(self) -> bool: ...


class Scale:
    """Newtons of a finger to thousandths of the servo's torque, and back."""

    def __init__(self, full_n: float, most: int, idle: int = 40) -> None:
        """``full_n``: the force at the whole stall torque (N); ``most``: the largest limit that is ever written, 1 to 1000;
        ``idle``: a load up to this is none."""
        if not (math.isfinite(full_n) and full_n > 0 and 1 <= most <= 1000):
            raise ValueError(f"full_n = {full_n}, most = {most}: a force above 0 and a limit of 1 to 1000 are needed")
        self.full_n, self.most, self.idle = full_n, most, idle

    def thousandths(self, force_n: float) -> int:
        """Rounded up: what is asked for is pressed at least."""
        return max(0, min(self.most, math.ceil(1000 * force_n / self.full_n - 1e-6)))

    def newtons(self, load: int) -> float:
        return load * self.full_n / 1000 if load > self.idle else 0.0


class Bridge:
    """Two threads: rows to ``gripd --port rows:tcp:HOST:PORT`` as they come, and its commands to the servo.

    A lost gripd, a lost bus and the end of this program leave the limit as it is; after them it only rises, until a client
    of gripd asks to open. So a servo that presses with more than the trial force when this begins keeps its limit; one that
    does not, or is off, holds nothing that the trial force would drop. A servo that was reset has let go: it is reported, and its torque is left off.
    """

    def __init__(
        self, sink: Tuple[str, float], readings: Callable[[], List[Tuple[float, float]]], servo: Servo, scale: Scale, trial_n: float
    ) -> None:
        """``sink``: HOST:PORT of gripd, and rows a second. ``readings`` gives what the sensor has measured since the last
        call, or an empty list after a while: time (s) and value. What it lost is a gap in the times, and nothing that follows is late for it. ``trial_n``: with what the jaw closes and presses at least,
        ``grip.trial_force_n`` of gripd (N)."""
        host, _, port = sink[0].rpartition(":")
        self.address, self.rate_hz = (host, int(port)), sink[1]
        self.readings, self.servo, self.scale = readings, servo, scale
        self.command_n = trial_n
        """The limit as it is written (N)."""
        self.opened, self.reset, self.failures = False, False, 0
        self._found = False
        self._looks: List[int] = []
        self._trial_n = self._least_n = trial_n
        self._load_n, self._told = math.nan, False
        self._line: Optional[socket.socket] = None
        self._ended = threading.Event()
        self._threads = [threading.Thread(target=of, name=of.__name__, daemon=True) for of in (self._rows, self._commands)]
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """Ends both threads; the servo keeps its limit."""
        self._ended.set()
        line, self._line = self._line, None
        if line is not None:
            line.close()
        for thread in self._threads:
            thread.join(2.0)

    def _rows(self) -> None:
        urgent(1)
        while not self._ended.is_set():
            try:
                line = socket.create_connection(self.address, timeout=2.0)
                line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                line.sendall(f"t_s,vibration,force_n,rate={self.rate_hz:g}\n".encode())
                self.readings()  # what was measured before the connection is old
                self._line = line
                while not self._ended.is_set():
                    rows = [f"{at:.6f},{value:g},\n" for at, value in self.readings()]
                    if rows and not math.isnan(self._load_n):
                        rows[-1] = f"{rows[-1][:-1]}{self._load_n:g}\n"
                        self._load_n = math.nan
                    line.sendall("".join(rows).encode())
            except OSError as error:
                self._lost(error)

    def _lost(self, error: Exception) -> None:
        if self._ended.is_set():
            return
        if self._line is not None or not self._told:
            self._told = True
            logger.warning("no gripd at %s:%s: %s; the limit stays", *self.address, error)
        line, self._line = self._line, None
        if line is not None:
            line.close()
        # Another gripd begins with its trial force: that must not let go of what is held.
        self._least_n = self._trial_n if self.opened else self.command_n
        self._ended.wait(RETRY_S)

    def _commands(self) -> None:
        urgent(1)
        text, next_load, next_write = b"", 0.0, 0.0
        while not self._ended.is_set():
            line, wanted = self._line, False
            if line is None:
                text = b""
                self._ended.wait(LOAD_S)
            else:
                try:
                    line.settimeout(LOAD_S)
                    more = line.recv(65536)
                    text += more
                    if not more:  # gripd has gone; with a sensor that is silent the thread that sends finds it later
                        self._ended.wait(LOAD_S)
                except OSError:
                    pass  # a time-out; what is worse meets the thread that sends
                *lines, text = text.split(b"\n")
                wanted = any([self._heard(one) for one in lines])
            now = time.monotonic()
            try:
                if not self._found:
                    self._find()
                if wanted or now >= next_write:
                    self.servo.limit(self.scale.most if self.opened else self.scale.thousandths(self.command_n))
                    next_write = now + REPEAT_S
                    if self.servo.powered() == self.reset:
                        self.reset = not self.reset
                        logger.warning("the servo %s", "was reset and holds nothing" if self.reset else "holds again")
                if now >= next_load:
                    self._load_n, next_load = self.scale.newtons(self.servo.load()), now + LOAD_S
            except Exception as error:  # whatever it is: without this thread no limit would be written any more
                self.failures += 1
                next_write = now
                if self.failures & (self.failures - 1) == 0:
                    logger.warning("the servo's bus failed %d times: %s", self.failures, error)

    def _find(self) -> None:
        """With what the servo holds as this begins: that is the least, unless gripd has asked to open."""
        held_n = self._trial_n
        if not self.opened and self.servo.powered():
            limit = self.servo.limited()
            while len(self._looks) < LOOKS:
                self._looks.append(self.servo.load())
                self._ended.wait(LOAD_S)
            if max(self._looks) > self.scale.thousandths(self._trial_n):
                held_n = max(held_n, limit * self.scale.full_n / 1000)
                logger.warning("the servo presses already: its limit of %.2f N stays until gripd opens", held_n)
        self._least_n = max(self._least_n, held_n)
        self.command_n = max(self.command_n, held_n)
        self._found = True

    def _heard(self, line: bytes) -> bool:
        """Takes a line of gripd; whether it changes the limit."""
        try:
            event: Any = json.loads(line)
        except ValueError:
            return False
        if not isinstance(event, dict) or event.get("type") != "command":
            return False
        force_n, before = event.get("force_n"), (self.command_n, self.opened)
        if event.get("mode") == "open":
            self.opened, self._least_n = True, self._trial_n
        elif event.get("mode") == "force" and isinstance(force_n, (int, float)) and math.isfinite(force_n):
            self.opened = False
            self.command_n = max(self._least_n, float(force_n))
        return before != (self.command_n, self.opened)
