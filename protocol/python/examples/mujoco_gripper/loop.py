"""An object and the path of gripd in, a grasp in real time over a pseudo-terminal out."""

from __future__ import annotations

import gc
import json
import os
import signal
import socket
import subprocess
import tempfile
import threading
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from grip_link import ChannelKind, Daemon, DaemonError, Drive, DriveKind, Ident, Pty, VirtualMcu
from grip_link.device import Command
from grip_link.messages import Channel, Limits, ResetReason
from grip_link.messages.daemon import Command as ClientCommand
from grip_link.messages.daemon import Operation, Subscribe, Topics

from .items import Item
from .surface import STYLUS_STEP_M, Sensors
from .taxels import FRAME_S, STEP_PA, TAXELS, Array
from .world import LIFT_AFTER_S, OPENING_N, STEP_S, World

FORCE_MAX_N = 60.0
SENSOR_SETS = {
    "stylus": (),
    "travel": (ChannelKind.TRAVEL,),
    "tangential": (ChannelKind.TANGENTIAL_FORCE,),
    "taxels": (ChannelKind.PRESSURE_ARRAY,),
}
"""What a gripper has beside stylus and grip force."""
_NO_CAUSE = 0xFFFFFFFF
_SCALES = {
    ChannelKind.STYLUS: STYLUS_STEP_M, ChannelKind.NORMAL_FORCE: 2e-3, ChannelKind.TRAVEL: 1e-6, ChannelKind.TANGENTIAL_FORCE: 2e-3,
    ChannelKind.PRESSURE_ARRAY: STEP_PA,
}  # fmt: skip


@dataclass
class Grasp:
    """What came of a grasp. Forces in N, ways in m."""

    dropped: bool = False
    slip_m: float = 0.0
    peak_n: float = 0.0
    final_n: float = 0.0
    most_commanded_n: float = 0.0
    released: bool = False
    late_ms: float = 0.0
    """The longest time for which the gripper stood still, or the age of the oldest sample that a command followed, if that was more."""
    repeats: int = 0
    error: str = ""
    slips: int = 0
    trace: list[tuple[float, ...]] = field(default_factory=list)
    """Every 2 ms: seconds from the lift, set point, force, slip, way under the stylus."""
    events: list[dict[str, Any]] = field(default_factory=list)
    """What gripd printed, by the gripper's clock, by which the lift began at ``lift_s``."""
    lift_s: float = 0.0
    poses: list[tuple[float, Any]] = field(default_factory=list)
    """Every 40 ms: seconds from the lift, positions of all joints."""


def ident(kinds: tuple[ChannelKind, ...]) -> Ident:
    """The gripper with stylus, grip force and these channels."""
    single = (Channel.single(kind, _SCALES[kind]) for kind in (ChannelKind.STYLUS, ChannelKind.NORMAL_FORCE, *kinds))
    channels = tuple(replace(channel, count=TAXELS) if channel.kind is ChannelKind.PRESSURE_ARRAY else channel for channel in single)
    most = round(FORCE_MAX_N * 1000)
    return Ident(
        uid=b"mujoco-gripper\0\0", boot_id=int.from_bytes(os.urandom(4), "little"), tick_hz=1_000_000,
        limits=Limits(20_000, most, 2_000_000, most, 0, 50_000), channels=channels, firmware=(0, 1, 0), reset=ResetReason.POWER_ON,
    )  # fmt: skip


class Gripper:
    """World and sensors as the sensor and the actuator of a virtual microcontroller."""

    def __init__(self, item: Item, sensors: str, sink_m_n: float) -> None:
        self.kinds = SENSOR_SETS[sensors]
        self.array = Array() if ChannelKind.PRESSURE_ARRAY in self.kinds else None
        self.world = World(item, self.array)
        self.sensors = Sensors(item.seed, item.roughness_um * 1e-6, sink_m_n)
        self.rows = 0
        self.command_n = 0.0
        self.most_commanded_n = 0.0
        self.late_s = 0.0
        self.released_at_s: float | None = None
        self.trace: list[tuple[float, ...]] = []
        self.poses: list[tuple[float, Any]] = []
        self.began_s = self._row_s = self._period_s = 0.0
        self._before = (0.0, 0.0)
        self._turned_s: float | None = None
        self._frame: list[float] = []
        self._next_frame_s = 0.0

    def sense(self, t_s: float) -> list[float]:
        """A row: the world goes on to its time, its steps are interpolated."""
        world = self.world
        if not self.rows:
            self.began_s = self._row_s = t_s
        self.rows += 1
        self._period_s, self._row_s = t_s - self._row_s, t_s
        now = t_s - self.began_s
        while world.time_s < now - 1e-9:
            self._before = (world.down_m, world.aside_m)
            world.step(self.command_n)
            if world.steps % 10 == 0:
                self.trace.append((world.since_lift_s, self.command_n, world.force_n, world.slip_m, world.down_m))
                if world.steps % 200 == 0 and world.touched_s is not None:
                    self.poses.append((world.since_lift_s, world.data.qpos.copy()))
        rest = (world.time_s - now) / STEP_S
        down = world.down_m - (world.down_m - self._before[0]) * rest
        aside = world.aside_m - (world.aside_m - self._before[1]) * rest
        force = self.sensors.force(world.force_n)
        row = [self.sensors.stylus(self._period_s, down, aside, world.force_n), force]
        for kind in self.kinds:
            if kind is ChannelKind.TRAVEL:
                row.append(self.sensors.travel(down))
            elif kind is ChannelKind.TANGENTIAL_FORCE:
                row.append(self.sensors.force(world.shear_n))
        return row if self.array is None else row + self._frame_at(now, self.array)

    def _frame_at(self, now_s: float, array: Array) -> list[float]:
        """The newest frame of the array; one that repeats itself is none to gripd."""
        if now_s >= self._next_frame_s:
            self._next_frame_s = now_s + FRAME_S - 1e-9
            self._frame = self.sensors.taxels(array.pressures_pa.tolist())
        return self._frame

    def drive(self, _t_s: float, drive: Drive) -> None:
        """Takes the set point, and notes for how long the last one stood."""
        now = time.monotonic()
        if self._turned_s is not None and self.rows:
            self.late_s = max(self.late_s, now - self._turned_s)
        self._turned_s = now
        if drive.kind is DriveKind.OPEN and self.command_n > 0.0:
            self.released_at_s, self.world.released = self.world.time_s, True
        self.command_n = OPENING_N if drive.kind is DriveKind.OPEN else drive.force_n
        self.most_commanded_n = max(self.most_commanded_n, self.command_n)

    def follow(self, command: Command) -> None:
        """Notes how old the sample is that a command follows."""
        cause = command.grip.cause_sample
        if cause != _NO_CAUSE and command.grip.force_mn and cause < self.rows:
            self.late_s = max(self.late_s, (self.rows - 1 - cause) * self._period_s)

    @property
    def is_over(self) -> bool:
        """Whether nothing more is to be seen."""
        released = self.released_at_s is not None and self.world.time_s > self.released_at_s + 0.3
        return self.world.is_over or released or self.world.time_s > 12.0


class Client(threading.Thread):
    """A client of gripd that commands the release when it is asked to."""

    def __init__(self, port: int) -> None:
        super().__init__(daemon=True)
        self.wanted = threading.Event()
        self.error = ""
        self.port = port

    def run(self) -> None:
        """Connects, waits, commands."""
        try:
            with self._connected() as daemon:
                if self.wanted.wait(15.0):
                    daemon.command(ClientCommand(Operation.RELEASE, token=daemon.welcome.token))
        except (DaemonError, OSError) as error:
            self.error = str(error)

    def _connected(self) -> Daemon:
        end = time.monotonic() + 5.0
        while True:
            try:
                return Daemon.open(f"socket://127.0.0.1:{self.port}", Subscribe(topics=Topics(0)))
            except OSError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.1)


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


def _run(gripper: Gripper, mcu: VirtualMcu, client: Client | None, alive: Any) -> None:
    """Turns the microcontroller until the grasp is over."""
    release_s = gripper.world.item.release_s
    began = time.monotonic()
    while not gripper.is_over:
        for event in mcu.step(0.001):
            if isinstance(event, Command):
                gripper.follow(event)
        if client is not None and release_s is not None and gripper.world.since_lift_s >= release_s:
            client.wanted.set()
        if alive() is not None:
            raise RuntimeError(f"gripd ended with {alive()}")
        if not gripper.rows and time.monotonic() - began > 10.0:
            raise RuntimeError("gripd asked for no samples in 10 s")


def _gripd(path: Path, port: str, listen: str, folder: Path, realtime: bool) -> subprocess.Popen[bytes]:
    config = folder / "gripd.toml"
    config.write_text("allow_commands = true\n")
    words = [str(path), "--port", port, "--config", str(config), "--listen", listen, "--log-level", "warn", "--json"]
    # One that is left over by a program that was killed would take the next pseudo-terminal of that name.
    words += ["--realtime", "warn" if realtime else "off", "--duration", "30"]
    with (folder / "events").open("wb") as out, (folder / "log").open("wb") as log:
        return subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=out, stderr=log)


def _end(process: subprocess.Popen[bytes]) -> None:
    process.send_signal(signal.SIGINT)
    try:
        process.wait(5.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def grasp(item: Item, sensors: str, gripd: Path, sink_m_n: float = 0.0, realtime: bool = False) -> Grasp:
    """One grasp with gripd, whatever became of it."""
    gripper = Gripper(item, sensors, sink_m_n)
    done = Grasp()
    gc.disable()
    with tempfile.TemporaryDirectory(prefix="mujoco-gripper-") as place, Pty() as pty:
        folder = Path(place)
        client = None if item.release_s is None else Client(_free_port())
        listen = "off" if client is None else f"tcp:127.0.0.1:{client.port}"
        mcu = VirtualMcu(pty.stream, gripper.sense, gripper.drive, ident=ident(gripper.kinds))
        process = _gripd(gripd, pty.path, listen, folder, realtime)
        if client is not None:
            client.start()
        try:
            _run(gripper, mcu, client, process.poll)
        except (RuntimeError, ConnectionError) as error:
            done.error = f"{error}: {(folder / 'log').read_text(errors='replace').strip()}"
        finally:
            _end(process)
            gc.enable()
        if client is not None and client.error:
            done.error = done.error or f"client: {client.error}"
        done.events = [json.loads(line) for line in (folder / "events").read_text().splitlines() if line.startswith("{")]
    return _judged(done, gripper)


def _judged(done: Grasp, gripper: Gripper) -> Grasp:
    world = gripper.world
    if not done.error and world.touched_s is None:
        done.error = "the fingers never touched it"
    done.dropped, done.released = world.dropped, world.released
    done.slip_m, done.peak_n = world.peak_slip_m, world.peak_n
    held = [row[2] for row in gripper.trace if row[0] > 0.0 and row[1] > 0.0][-50:]
    done.final_n = sum(held) / len(held) if held else 0.0
    done.most_commanded_n, done.late_ms = gripper.most_commanded_n, gripper.late_s * 1e3
    done.slips = sum(event.get("type") == "slip" and event.get("phase") == "gross" for event in done.events)
    done.trace, done.poses = gripper.trace, gripper.poses
    done.lift_s = gripper.began_s + (world.touched_s or 0.0) + LIFT_AFTER_S
    return done
