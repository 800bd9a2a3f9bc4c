"""Programs at the other end of the line: the real gripd as a process, and the Python peer for what gripd never does."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Optional

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python" / "src"))

from board import DROPPED, LIFTED, Board, CheckFailed, Truth, must  # noqa: E402
from grip_link import Config, GripLink, LinkClosed  # noqa: E402
from grip_link.stream import FdStream  # noqa: E402


class Gripd:
    """A running gripd at the board's port."""

    def __init__(self, program: str, board: Board, *args: str) -> None:
        command = [program, "--port", board.port, "--json", *args]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def signal(self, number: signal.Signals) -> None:
        """To this process alone."""
        self.process.send_signal(number)

    def done(self, timeout_s: float = 60.0) -> tuple[int, list[dict[str, Any]], str]:
        """Exit code, JSON lines, standard error."""
        try:
            out, err = self.process.communicate(timeout=timeout_s)
        except subprocess.TimeoutExpired:
            self.end()
            raise
        return self.process.returncode, [json.loads(line) for line in out.splitlines()], err

    def end(self) -> str:
        """Kills it if it still runs; what it said on standard error."""
        if self.process.poll() is None:
            self.process.kill()
        return self.process.communicate()[1]


def until_holding(board: Board, program: Gripd, timeout_s: float = 30.0) -> Truth:
    """Waits until the object hangs between the fingers with a force that no longer changes."""
    last = {"count": 0, "force": 0}

    def steady(now: Truth) -> bool:
        same = now["object"] == LIFTED and now["target_mn"] == last["force"] and now["state"] == 4
        must(program.process.poll() is None, f"gripd ended: {now}")
        must(now["object"] != DROPPED, f"the object fell: {now}")
        last.update(count=last["count"] + 1 if same else 0, force=now["target_mn"])
        return last["count"] >= 15

    return board.wait("the object held with a steady force", steady, timeout_s)


class Spare:
    """Tries that a busy computer may cost. It shows in the firmware's clock and on each processor (`Board.lost_s`): the
    emulator had less time than it needs, or gripd, which shares the computer, while the object fell. A drop at any other
    time is gripd's own."""

    TRIES = 2
    BEHIND_S = 0.02
    """Samples that are later than this raise no force, and the object takes about 0.1 s to fall through the fingers."""
    LOST_S = 0.1
    """A computer that is further behind says nothing of gripd: the try is not counted, but for so many of them."""
    LOST_TRIES = 20
    PAUSE_S = 5.0

    def __init__(self) -> None:
        self.left = self.TRIES
        self.lost = 0

    def take(self, said: str, behind_s: float) -> None:
        """Uses one up; raises CheckFailed where there is none or the emulation kept up."""
        if behind_s >= self.LOST_S:
            self.lost += 1
            must(self.lost <= self.LOST_TRIES, f"{said}; the computer fell {1000 * self.LOST_S:.0f} ms behind in {self.lost} tries")
            time.sleep(self.PAUSE_S)
            return
        must(behind_s >= self.BEHIND_S, f"{said}; the computer was only {1000 * behind_s:.0f} ms behind")
        must(self.left > 0, f"{said}; {self.TRIES} spare tries are used up")
        self.left -= 1


def gripd_with_object(gripd: str, board: Board) -> tuple[Gripd, Truth]:
    """A gripd that holds the object, and the truth then."""
    spare = Spare()
    while True:
        board.fresh()
        start = board.truth
        program = Gripd(gripd, board)
        try:
            return program, until_holding(board, program)
        except CheckFailed as error:
            said, behind_s = program.end(), board.lost_s(start)
            print(f"     computer {1000 * behind_s:.0f} ms behind: {error}; gripd said {said.splitlines()[:3]}", flush=True)
            spare.take(str(error), behind_s)
        except BaseException:
            program.end()
            raise


class Host:
    """The Python peer, driven by hand: nothing goes out but what is asked for. After a reset it connects again."""

    def __init__(self, board: Board, **settings: Any) -> None:
        wanted = {"sample_rate_hz": 1000, "force_max_mn": 20_000, "hold_cap_mn": 20_000, "slew_mn_s": 500_000, **settings}
        self._config = Config(**wanted)
        self._stream = FdStream(os.open(board.port, os.O_RDWR | os.O_NOCTTY))
        self.boots: list[int] = []
        self._connect()

    def _connect(self) -> None:
        self.link = GripLink(self._stream, self._config, silence_s=10.0)
        self.link.connect(10.0)
        self.boots.append(self.link.ident.boot_id)

    def write(self, wire: bytes) -> None:
        """Bytes as they are."""
        until = time.monotonic() + 2.0
        while wire:
            wire = wire[self._stream.write(wire) :]
            must(time.monotonic() < until, "the port takes no bytes")

    def run(self, seconds: float, force_mn: Optional[int] = None) -> None:
        """Reads for a while; with a force, sends a GRIP every 10 ms."""
        until, due = time.monotonic() + seconds, 0.0
        while time.monotonic() < until:
            try:
                self.link.poll(0.001)
                if force_mn is not None and time.monotonic() >= due:
                    due = time.monotonic() + 0.01
                    self.link.grip(force_mn / 1000)
            except LinkClosed as closed:
                must(closed.code == "rebooted", str(closed))
                self._connect()

    def close(self) -> None:
        """Falls silent."""
        self._stream.close()
