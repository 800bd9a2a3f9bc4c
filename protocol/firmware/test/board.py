"""The firmware in QEMU: its UART0 as a pseudo-terminal, the truth from its test bench on UART1, resets by QMP."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import re
import socket
import subprocess
import tempfile
import termios
import threading
import time
import tty
from typing import Callable

from computer import Computer

OPEN, SUPPORTED, LIFTED, DROPPED = range(4)
POWER_ON, PIN, WATCHDOG, SOFTWARE = 1, 2, 3, 4

Truth = dict[str, int]


class CheckFailed(Exception):
    """What was measured is not what must be."""


def must(condition: bool, text: str) -> None:
    """Raises CheckFailed with the measured numbers in ``text``."""
    if not condition:
        raise CheckFailed(text)


class Board:
    """A running QEMU. Virtual time follows the clock of this computer: no -icount."""

    def __init__(self, elf: str, qemu: str = "qemu-system-arm") -> None:
        self._folder = tempfile.TemporaryDirectory()
        at = {name: os.path.join(self._folder.name, name) for name in ("bench", "qmp")}
        self._qemu = subprocess.Popen(
            [qemu, "-M", "mps2-an386", "-display", "none", "-monitor", "none", "-nodefaults", "-serial", "pty",
             "-serial", f"unix:{at['bench']},server=on,wait=off", "-qmp", f"unix:{at['qmp']},server=on,wait=off",
             "-kernel", elf],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )  # fmt: skip
        try:
            self.port = self._named_port()
            # Kept open, so that QEMU always sees somebody at the other end and the port's modes stay.
            self._spare = os.open(self.port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            tty.setraw(self._spare)
            self._qmp = self._connected(at["qmp"]).makefile("rw")
            self._qmp.readline()
            self._command("qmp_capabilities")
            self._bench = self._connected(at["bench"])
            self._computer = Computer()
        except BaseException:
            self._qemu.kill()
            raise
        self.lines: list[tuple[float, Truth]] = []
        self._changed = threading.Condition()
        threading.Thread(target=self._read_bench, daemon=True).start()
        self.wait("the first line of the bench", lambda now: now["state"] == 1, 10.0)

    def _named_port(self) -> str:
        assert self._qemu.stdout is not None
        for line in self._qemu.stdout:
            found = re.search(r"redirected to (\S+)", line)
            if found:
                threading.Thread(target=self._qemu.stdout.read, daemon=True).start()
                return found[1]
        raise CheckFailed(f"QEMU ended with {self._qemu.wait()} and named no pseudo-terminal")

    def _connected(self, path: str) -> socket.socket:
        until = time.monotonic() + 10.0
        while True:
            stream = socket.socket(socket.AF_UNIX)
            try:
                stream.connect(path)
                return stream
            except OSError:
                stream.close()
                if time.monotonic() > until or self._qemu.poll() is not None:
                    raise
                time.sleep(0.02)

    def _command(self, name: str) -> None:
        self._qmp.write(json.dumps({"execute": name}) + "\n")
        self._qmp.flush()
        while True:
            answer = json.loads(self._qmp.readline())
            if "return" in answer:
                return
            must("error" not in answer, f"QMP {name}: {answer}")

    def _read_bench(self) -> None:
        rest = b""
        while True:
            try:
                data = self._bench.recv(65536)
            except OSError:
                return
            if not data:
                return
            *lines, rest = (rest + data).split(b"\n")
            with self._changed:
                for line in lines:
                    pairs = dict(re.findall(r"(\w+)=(\d+)", line.decode("ascii", "replace")))
                    if "garbage" in pairs and "t_us" in pairs:
                        self.lines.append((time.monotonic(), {key: int(value) for key, value in pairs.items()}))
                self._changed.notify_all()

    @property
    def truth(self) -> Truth:
        """The newest line."""
        return self.lines[-1][1]

    def next_truth(self, timeout_s: float = 2.0) -> Truth:
        """A line that was begun after this call: two are awaited."""
        with self._changed:
            wanted = len(self.lines) + 2
            must(self._changed.wait_for(lambda: len(self.lines) >= wanted, timeout_s), "the bench has fallen silent")
            return self.truth

    def wait(self, what: str, condition: Callable[[Truth], bool], timeout_s: float) -> Truth:
        """The first line from now on that fulfils the condition."""
        until = time.monotonic() + timeout_s
        with self._changed:
            at = max(len(self.lines) - 1, 0)
            while True:
                for _, now in self.lines[at:]:
                    if condition(now):
                        return now
                at = len(self.lines)
                left = until - time.monotonic()
                if left <= 0 or not self._changed.wait(left):
                    last = self.lines[-1][1] if self.lines else None
                    raise CheckFailed(f"{what}: not within {timeout_s} s; last: {last}")

    def since(self, t_us: int) -> list[Truth]:
        """All lines of the present start from device time ``t_us`` on."""
        with self._changed:
            boot = self.truth["boot"]
            return [now for _, now in self.lines if now["boot"] == boot and now["t_us"] >= t_us]

    def order(self, letter: str) -> None:
        """An order of bench.h."""
        self._bench.sendall(letter.encode())

    def reset(self) -> Truth:
        """Pulls the reset pin; the first line afterwards."""
        boot = self.truth["boot"]
        self._command("system_reset")
        return self.wait("the start after a reset", lambda now: now["boot"] == boot + 1 and now["state"] == 1, 10.0)

    def fresh(self) -> None:
        """A new start with open fingers over a new object."""
        termios.tcflush(self._spare, termios.TCIOFLUSH)
        self.reset()
        self._drain()
        self.order("n")
        self.wait("a new object", lambda now: now["object"] == OPEN and now["peak_mn"] == 0, 5.0)
        termios.tcflush(self._spare, termios.TCIOFLUSH)
        # A program that was killed leaves its lock on the port.
        fcntl.ioctl(self._spare, termios.TIOCNXCL)

    def _drain(self) -> None:
        """What a program left in the line arrives and is counted: waits until nothing more comes."""
        names, until = ("stale", "garbage", "crc", "echo"), time.monotonic() + 10.0
        before = None
        while time.monotonic() < until:
            counts = [self.truth[name] for name in names]
            if counts == before:
                return
            before = counts
            for _ in range(3):
                self.next_truth()

    def lost_s(self, since: Truth) -> float:
        """How far the firmware's clock fell behind this computer's since a line of the present start (s), or for how long a
        processor of this computer stood still meanwhile, whichever is longer. Interrupts that a busy computer gives the
        emulator no time for are lost; lines only come late, so the least of the last ones counts.
        """
        with self._changed:
            lines = [(at, now) for at, now in self.lines if now["boot"] == since["boot"] and now["t_us"] >= since["t_us"]]
        behind = [at - now["t_us"] / 1e6 for at, now in lines]
        return max(min(behind[-5:]) - min(behind[:5]), self._computer.stood_s(lines[0][0]))

    def pace(self) -> float:
        """Seconds of the firmware in a second of this computer, over all its starts."""
        with self._changed:
            lines = list(self.lines)
        pairs = [(a, b) for a, b in zip(lines, lines[1:]) if a[1]["boot"] == b[1]["boot"]]
        return sum(b[1]["t_us"] - a[1]["t_us"] for a, b in pairs) / 1e6 / sum(b[0] - a[0] for a, b in pairs)

    def close(self) -> None:
        """Ends QEMU."""
        self._computer.close()
        self._qemu.kill()
        self._qemu.wait()
        with contextlib.suppress(OSError):
            self._bench.close()
            os.close(self._spare)
        self._folder.cleanup()
