"""A simulated SO-101 whose gripper holds an object: six servos on a pseudo-terminal, an accelerometer on the finger.

    python -m slip_servo.virtual GRIPD                 one object: slip, force, held
    python -m slip_servo.virtual --objects 100     random ones in simulated time, with the package slipgrip in place of gripd; with GRIPD in real time
    python -m slip_servo.virtual GRIPD --faults        each fault of the lines while an object is held
    python -m slip_servo.virtual --serve FOLDER        FOLDER/so101, the bus, and FOLDER/board, the accelerometer, until Ctrl-C

Packets and registers are those of Feetech's STS3215. The world is a weight under Coulomb friction. The gear keeps some of its force when the
limit falls, and the load is a coarse reading of it. All of it is made up: no arm was measured.
"""

from __future__ import annotations

import argparse
import collections
import json
import math
import os
import pty
import random
import select
import socket
import subprocess
import sys
import tempfile
import threading
import time
import tty
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, Deque, Dict, List, Optional, Tuple

from . import feetech
from .bridge import Bridge, Scale, urgent

RATE_HZ = 800
FULL_N = 19.0
"""Force of the whole stall torque, 1.9 N m, at a finger 0.1 m from the axis (N)."""
MOST = 500
"""LeRobot's own limit of the gripper's torque, against burnt windings (0.1 %)."""
TRIAL_N = 1.5
GRIP = {"f_max_n": FULL_N * MOST / 1000, "trial_force_n": TRIAL_N}
SETTINGS = '[realtime]\nmode = "warn"\n[grip]\n' + "".join(f"{name} = {value}\n" for name, value in GRIP.items())
OPEN, CLOSED, OBJECT = 3000, 1000, 1800
"""Places of the jaw: open, closed, and where the object is (steps of the servo)."""


class World:
    """A jaw with an object, in steps of a row."""

    def __init__(self, needed_n: float = 5.0, friction: float = 0.5, lift_s: float = 1.5, seed: int = 1) -> None:
        self.needed_n, self.friction, self.lift_s = needed_n, friction, lift_s
        self.mass_kg = 2 * friction * needed_n / 9.81
        self.force_n = self.peak_n = self.travel_m = self.speed_m_s = self.time_s = self._ring = 0.0
        self.jaw: float = OPEN
        self.held_s: Optional[float] = None
        self.late = "in simulated time"
        self.orders: Deque[float] = collections.deque([0.0] * (RATE_HZ // 200))  # a dead time of 5 ms
        self.random = random.Random(seed)

    @property
    def dropped(self) -> bool:
        return self.travel_m > 0.03

    def step(self, limit: int, goal: int) -> float:
        """One row: torque limit of a servo that is on, else 0, and its goal in; the accelerometer (m/s2) out."""
        dt = 1 / RATE_HZ
        self.time_s += dt
        self.orders.append(FULL_N * limit / 1000)
        target = self.orders.popleft()
        there = not self.dropped and self.jaw <= OBJECT
        if target > 0.3 and not (there and goal < OBJECT):
            self.jaw += max(-4000 * dt, min(4000 * dt, goal - self.jaw))
        if there and goal < OBJECT:
            self.held_s = self.time_s if self.held_s is None else self.held_s
            # The gear does not give back the last 15 % of what it was pressed with.
            wanted = max(target, min(self.force_n, 1.15 * target))
            self.force_n += (wanted - self.force_n) * dt / (dt + 0.02)
        else:
            self.force_n, self.held_s = 0.0, None
        self.peak_n = max(self.peak_n, self.force_n)
        load_n, grip_n = 0.0, 2 * self.friction * self.force_n
        if self.held_s is not None:
            load_n = self.mass_kg * 9.81 * min(1.0, max(0.0, (self.time_s - self.held_s - self.lift_s) / 0.3))
        if self.speed_m_s > 0.0 or load_n > 1.05 * grip_n:
            self.speed_m_s = max(0.0, self.speed_m_s + (load_n - grip_n) / self.mass_kg * dt)
            self.travel_m += self.speed_m_s * dt
        self._ring = 0.6 * self._ring + self.random.gauss(0, 1) * min(8.0, 60 * self.speed_m_s)
        # Steps of an ADXL345.
        return 0.0383 * round((self.random.gauss(0, 0.06) + self._ring) / 0.0383)

    def load(self) -> int:
        """In 0.1 %: steps of eight, and twelve of noise."""
        return max(0, min(1000, 8 * round((1000 * self.force_n / FULL_N + self.random.gauss(0, 12)) / 8)))


class Servo:
    """Registers of an STS3215."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.memory = bytearray(128)
        for place, value in ((0, 3), (1, 10), (3, 777), (11, 4095), (16, 1000), (42, 2048), (56, 2048), (62, 74), (63, 30)):
            self.set(place, value)
        self.memory[5] = number
        self.power_on()

    def power_on(self) -> None:
        """What a reset leaves: the torque is off, the limit that of the EEPROM."""
        self.memory[40] = 0
        self.memory[48:50] = self.memory[16:18]

    def get(self, place: int) -> int:
        return int.from_bytes(self.memory[place : place + 2], "little")

    def set(self, place: int, value: int) -> None:
        self.memory[place : place + 2] = value.to_bytes(2, "little")


class Arm(threading.Thread):
    """Six servos on a pseudo-terminal at ``path``, and the world that the sixth one grips in, in real time."""

    def __init__(self, path: Path, world: World) -> None:
        super().__init__(daemon=True)
        self.path, self.world = path, world
        self.servos = {number: Servo(number) for number in range(1, 7)}
        self.gripper = self.servos[feetech.GRIPPER]
        for place, value in ((9, CLOSED), (11, OPEN), (42, OPEN), (56, OPEN)):
            self.gripper.set(place, value)
        self.damaged, self.delay_s, self.mute = 0.0, 0.0, False
        """Faults of the bus: share of damaged answers, delay of each, silence."""
        self.chunk_s, self.stopped = 0.005, False
        """Readings of the accelerometer come in chunks of this length."""
        self.late = 0
        self._readings: List[Tuple[float, float]] = []
        self._last = 0.0
        self._lock, self._due = threading.Lock(), 0.0
        self._waiting: List[Tuple[float, bytes]] = []
        self._input = bytearray()
        self._fd, theirs = pty.openpty()
        tty.setraw(theirs)
        os.set_blocking(self._fd, False)
        path.unlink(missing_ok=True)
        path.symlink_to(os.ttyname(theirs))
        self.start()

    def readings(self) -> List[Tuple[float, float]]:
        """What the accelerometer has measured since the last call, in whole chunks, with its times."""
        time.sleep(max(0.0, self._due - time.monotonic()))
        self._due = time.monotonic() + self.chunk_s
        with self._lock:
            taken, self._readings = self._readings, []
        return taken

    def reading(self) -> float:
        """The next one; the last one again where none has come."""
        with self._lock:
            if self._readings:
                # What nobody asked for in time is gone, as in a sensor without a queue.
                _, self._last = self._readings.pop(0)
                del self._readings[:-8]
        return self._last

    def run(self) -> None:
        urgent(2)  # a device has a processor of its own
        due = time.monotonic()
        while not self.stopped:
            now = time.monotonic()
            self.late += now - due > 0.02
            # Where this computer is later than that all the same, the world stands still meanwhile.
            due = max(due, now - 0.02)
            while due <= now:
                on = self.gripper.memory[40]
                value = self.world.step(self.gripper.get(48) if on else 0, self.gripper.get(42))
                with self._lock:
                    self._readings.append((due, value))
                due += 1 / RATE_HZ
            self.gripper.set(56, round(self.world.jaw))
            self.gripper.set(60, self.world.load())
            self._bus(now)
            select.select([self._fd], [], [], 0.001)

    def _bus(self, now: float) -> None:
        try:
            self._input += os.read(self._fd, 4096)
        except OSError:
            pass
        asked = list(feetech.packets(self._input))
        for at, (number, kind, data) in enumerate(asked, 1):
            answers = self._answers(number, kind, data)
            # One who asks again has given up waiting: this computer was late, which no servo is.
            for answer in answers if at == len(asked) else []:
                if self.world.random.random() < self.damaged:
                    answer = answer[:-1] + bytes([answer[-1] ^ 0x10])
                if not self.mute:
                    self._waiting.append((now + self.delay_s, answer))
        while self._waiting and self._waiting[0][0] <= now:
            os.write(self._fd, self._waiting.pop(0)[1])

    def _answers(self, number: int, kind: int, data: bytes) -> List[bytes]:
        asked = [servo for servo in self.servos.values() if number in (servo.number, feetech.EVERYBODY)]
        if kind == feetech.PING:
            return [feetech.packet(servo.number, 0) for servo in asked]
        if kind == feetech.READ and asked:
            return [feetech.packet(number, 0, bytes(asked[0].memory[data[0] : data[0] + data[1]]))]
        if kind == feetech.WRITE and asked:
            asked[0].memory[data[0] : data[0] + len(data) - 1] = data[1:]
            self._moved(asked[0])
            return [feetech.packet(number, 0)]
        if kind == feetech.SYNC_READ:
            known = [self.servos[one] for one in data[2:] if one in self.servos]
            return [feetech.packet(one.number, 0, bytes(one.memory[data[0] : data[0] + data[1]])) for one in known]
        if kind == feetech.SYNC_WRITE:
            width = data[1] + 1
            for at in range(2, len(data), width):
                servo = self.servos.get(data[at])
                if servo is not None:
                    servo.memory[data[0] : data[0] + data[1]] = data[at + 1 : at + width]
                    self._moved(servo)
        return []

    def _moved(self, servo: Servo) -> None:
        """The joints of the arm are where they shall be at once; the jaw takes its time."""
        if servo is not self.gripper and servo.memory[40]:
            servo.memory[56:58] = servo.memory[42:44]

    def close(self) -> None:
        self.stopped = True
        self.join()
        os.close(self._fd)
        self.path.unlink(missing_ok=True)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as free:
        return int(free.getsockname()[1])


class Scene:
    """gripd, the arm and the bridge between them; the jaw closes at once."""

    def __init__(self, gripd: str, world: World, listen: str = "off") -> None:
        self.folder = tempfile.TemporaryDirectory()
        folder = Path(self.folder.name)
        (folder / "gripd.toml").write_text(SETTINGS)
        self.address, self.listen = f"127.0.0.1:{free_port()}", listen
        self.command = [gripd, "--port", f"rows:tcp:{self.address}", "--listen", listen, "--config", "gripd.toml", "--json"]
        self.out = open(folder / "out", "w+", encoding="utf-8")
        self.err = open(folder / "err", "w+", encoding="utf-8")
        self.gripd = self.started()
        self.world, self.arm = world, Arm(folder / "so101", world)
        self.servo = feetech.Gripper(str(folder / "so101"), patience_s=0.05)
        for register, data in ((feetech.TORQUE_LIMIT, bytes(2)), (42, CLOSED.to_bytes(2, "little")), (feetech.TORQUE_ENABLE, b"\1")):
            self.surely(register, data)
        self.bridge = Bridge((self.address, RATE_HZ), self.arm.readings, self.servo, Scale(FULL_N, MOST), TRIAL_N)

    def surely(self, register: int, data: bytes) -> None:
        """Writes until the servo has answered: this computer may be busy."""
        for _ in range(50):
            try:
                return self.servo.write(register, data)
            except OSError as error:
                last = error
        raise last

    def started(self) -> "subprocess.Popen[bytes]":
        env = {key: value for key, value in os.environ.items() if not key.startswith("GRIPD_")}
        return subprocess.Popen(
            self.command, cwd=self.folder.name, env=env, stdin=subprocess.DEVNULL, stdout=self.out, stderr=self.err
        )

    def end(self) -> List[Dict[str, Any]]:
        """The events of gripd."""
        self.bridge.close()
        try:
            self.gripd.wait(10)
        except subprocess.TimeoutExpired:
            self.gripd.kill()
        self.arm.close()
        self.servo.close()
        self.out.seek(0)
        return [json.loads(line) for line in self.out]

    def log(self) -> str:
        self.err.seek(0)
        return self.err.read()


def one(gripd: str) -> bool:
    """Shows a grasp as it goes."""
    begin = time.monotonic()
    scene = Scene(gripd, World())
    shown = 0
    while time.monotonic() - begin < 5.0:
        time.sleep(0.05)
        lines = (Path(scene.folder.name) / "out").read_text().splitlines()
        for event in [json.loads(line) for line in lines[shown:] if line.endswith("}")]:
            shown += 1
            if event["type"] in ("slip", "slip_end"):
                print(f"{time.monotonic() - begin:.2f} s  {event['type']} {event.get('phase', '')}, limit {scene.bridge.command_n:.2f} N")
    scene.end()
    world = scene.world
    print(f"{'dropped' if world.dropped else 'held'} with {world.force_n:.2f} N of {world.needed_n:.2f} N needed, slipped {1e3 * world.travel_m:.2f} mm")
    return not world.dropped


def chosen(chance: random.Random, number: int) -> World:
    return World(chance.uniform(0.5, 7.0), chance.uniform(0.2, 0.8), chance.uniform(1.0, 2.0), number)


def timed(world: World, gripd: str) -> World:
    """One object in real time; whether and why it was late."""
    scene = Scene(gripd, world)
    time.sleep(6.0)
    scene.end()
    world.late = f"the device was late {scene.arm.late} times, the bus failed {scene.bridge.failures} times"
    return world


def grasp(world: World, chunk: int, delay: int) -> World:
    """One object in simulated time, with the code of gripd in this process: readings in chunks of so many rows, limits so many rows late."""
    import numpy
    from slipgrip import Pipeline

    pipeline = Pipeline(RATE_HZ, ["vibration", "force_n"], config={"grip": GRIP})
    scale = Scale(FULL_N, MOST)
    limits = collections.deque([scale.thousandths(TRIAL_N)] * (delay + 1))
    rows: List[List[float]] = []
    for n in range(8 * RATE_HZ):
        rows.append([world.step(limits[0], CLOSED), scale.newtons(world.load()) if n % (RATE_HZ // 50) == 0 else math.nan])
        command_n = 0.0
        if len(rows) == chunk:
            command_n, _ = pipeline.step(numpy.array(rows, numpy.float32))
            rows = []
        limits.append(scale.thousandths(command_n) if command_n > 0 else limits[-1])
        limits.popleft()
    return world


def objects(count: int, seed: int, chunk_ms: float, delay_ms: float, gripd: Optional[str]) -> bool:
    """Random ones that need 0.5 to 7 N, with 9.5 N at most."""
    chance = random.Random(seed)
    chunk, delay = max(1, round(chunk_ms * RATE_HZ / 1000)), round(delay_ms * RATE_HZ / 1000)
    chosen_ = [chosen(chance, number) for number in range(count)]
    worlds = [timed(world, gripd) if gripd else grasp(world, chunk, delay) for world in chosen_]
    held = [world for world in worlds if not world.dropped]

    def middle(values: List[float]) -> str:
        ordered = sorted(values)
        return " / ".join(f"{ordered[min(len(ordered) - 1, int(share * len(ordered)))]:.2f}" for share in (0.5, 0.95))

    way = f"in real time, load {os.getloadavg()[1]:.0f}" if gripd else f"chunks of {chunk_ms:g} ms, limits {delay_ms:g} ms late"
    print(f"{len(held)} of {count} held, seed {seed}, {way}", end="")
    if held:
        slips, ratios = [1e3 * world.travel_m for world in held], [world.force_n / world.needed_n for world in held]
        print(f"; slip {middle(slips)} mm, force over needed {middle(ratios)} (median / 95 %)", end="")
    print()
    for world in worlds:
        if world.dropped:
            print(f"dropped: needs {world.needed_n:.2f} N, friction {world.friction:.2f}, peak {world.peak_n:.2f} N; {world.late}")
    return len(held) == count


def faults(gripd: str) -> bool:
    """Each fault in turn while an object is held, and what the force was at least."""
    scene = Scene(gripd, World(4.0))
    arm, world, good = scene.arm, scene.world, True
    time.sleep(5.0)
    before = world.force_n

    def restart() -> None:
        scene.gripd.kill()
        scene.gripd.wait()
        scene.gripd = scene.started()

    def setting(name: str, value: object) -> Callable[[], None]:
        return lambda: setattr(arm, name, value)

    for name, begin, end in (
        ("rows in chunks of 40 ms", setting("chunk_s", 0.04), setting("chunk_s", 0.005)),
        ("no rows for 1.5 s", setting("chunk_s", 1.5), setting("chunk_s", 0.005)),
        ("answers of the bus 15 ms late", setting("delay_s", 0.015), setting("delay_s", 0.0)),
        ("half of the answers damaged", setting("damaged", 0.5), setting("damaged", 0.0)),
        ("no answer of the bus", setting("mute", True), setting("mute", False)),
        ("gripd killed and started again", restart, lambda: None),
    ):
        begin()
        least = math.inf
        for at in range(300):
            if at == 150:
                end()
            time.sleep(0.01)
            least = min(least, world.force_n)
        fine = not world.dropped and least >= world.needed_n
        good &= fine
        print(f"{name}: at least {least:.2f} N, {'held' if fine else 'LOST'}, bus failed {scene.bridge.failures} times")
    arm.gripper.power_on()
    time.sleep(1.0)
    # Nothing may switch the torque on again: what it held is gone, and a hand may be there.
    fine = scene.bridge.reset and not arm.gripper.memory[feetech.TORQUE_ENABLE]
    print(f"servo reset: {'reported, and left without torque' if fine else 'NOT REPORTED'}")
    scene.end()
    print(f"{before:.2f} N before, {world.needed_n:.2f} N needed")
    return good and fine


def serve(folder: Path) -> None:
    """The bus, a board on the grip link, and the calibration that LeRobot looks for."""
    from grip_link import Pty, VirtualMcu
    from grip_link.mcu import default_ident
    from grip_link.messages import Channel, ChannelKind, Unit

    names = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper")
    (folder / "calibration").mkdir(parents=True, exist_ok=True)
    urgent(2)
    arm = Arm(folder / "so101", World())
    ranges = {name: (number, arm.servos[number].get(9), arm.servos[number].get(11)) for number, name in enumerate(names, 1)}
    made = {
        name: {"id": number, "drive_mode": 0, "homing_offset": 0, "range_min": low, "range_max": high}
        for name, (number, low, high) in ranges.items()
    }
    (folder / "calibration" / "virtual.json").write_text(json.dumps(made))
    channel = Channel(ChannelKind.STYLUS, Unit.METRE_PER_SECOND2, 3, 1, 0.0383)
    (folder / "board").unlink(missing_ok=True)
    with Pty(str(folder / "board")) as pty_:
        VirtualMcu(pty_.stream, lambda _: (arm.reading(),), ident=replace(default_ident(), channels=(channel,))).run()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("gripd", nargs="?")
    parser.add_argument("--objects", type=int, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--chunk-ms", type=float, default=5.0, help="of --objects: readings come in chunks of this length")
    parser.add_argument("--delay-ms", type=float, default=5.0, help="of --objects: from a command to the register")
    parser.add_argument("--faults", action="store_true")
    parser.add_argument("--serve", type=Path, metavar="FOLDER")
    given = parser.parse_args()
    if given.serve:
        serve(given.serve)
    gripd = os.path.abspath(given.gripd) if given.gripd else None
    if given.objects:
        return 0 if objects(given.objects, given.seed, given.chunk_ms, given.delay_ms, gripd) else 1
    if not gripd:
        parser.error("the program gripd is needed")
    return 0 if (faults(gripd) if given.faults else one(gripd)) else 1


if __name__ == "__main__":
    sys.exit(main())
