#!/usr/bin/env python3
"""A virtual 2F-85 on Modbus RTU and a virtual TSF-85 on pseudo-terminals, with one object between them; gripd holds it, through faults.

    scripts/robotiq-devices.py GRIPD              every scene, checked
    scripts/robotiq-devices.py --serve FOLDER     only the devices, FOLDER/gripper and FOLDER/tsf85, until Ctrl-C
    scripts/robotiq-devices.py --objects GRIPD N [SEED]  N objects of random weight, friction and lift

With --forwarder before these the gripper is behind a robot arm: RS-485 over TCP on 127.0.0.1 (port 54321 with --serve), each way
1 to 6 ms late, in pieces, and together where more is due.

Python alone, and nothing of gripd's own protocol code. The world is a weight under Coulomb friction, stepped each millisecond; the
force follows its register with a dead time of 5 ms and a lag of 15 ms. All of it is made up: no gripper was measured.
"""

import collections
import json
import math
import os
import pty
import random
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import tty
from pathlib import Path

UNIT = 9
COMMAND, STATUS = 0x03E8, 0x07D0


def crc16(data):
    """The checksum of Modbus RTU."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    return struct.pack("<H", crc)


class Line:
    """One end of a pseudo-terminal whose other end stands at a path, until it is unplugged."""

    def __init__(self, path):
        self.path, self.name, self.fd = path, str(path), None
        self.plug()

    def plug(self):
        ours, theirs = pty.openpty()
        tty.setraw(theirs)
        os.set_blocking(ours, False)
        if self.path.is_symlink():
            self.path.unlink()
        self.path.symlink_to(os.ttyname(theirs))
        self.theirs, self.fd = theirs, ours

    def unplug(self):
        ours, theirs, self.fd = self.fd, self.theirs, None
        self.path.unlink()
        os.close(theirs)
        os.close(ours)

    def read(self):
        try:
            return os.read(self.fd, 4096) if self.fd is not None else b""
        except (BlockingIOError, OSError):
            return b""

    def write(self, data):
        try:
            if self.fd is not None:
                os.write(self.fd, data)
        except (BlockingIOError, OSError):
            pass


class Forwarder:
    """The same over TCP, as an arm forwards RS-485: late, in pieces and together, but in order."""

    def __init__(self, port=0):
        self.random, self.port = random.Random(3), port
        self.plug()

    def plug(self):
        self.server = socket.create_server(("127.0.0.1", self.port))
        self.server.setblocking(False)
        self.port = self.server.getsockname()[1]
        self.name, self.fd = f"tcp:127.0.0.1:{self.port}", self.server.fileno()
        self.lose()

    def lose(self):
        self.line, self.there, self.back = None, collections.deque(), collections.deque()

    def unplug(self):
        if self.line:
            # Closed with a reset, as by a robot that starts again.
            self.line.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            self.line.close()
        self.server.close()
        self.server = self.fd = None
        self.lose()

    def late(self, way, data):
        while data:
            size = self.random.choice((len(data), len(data), 1 + self.random.randrange(len(data))))
            due = time.monotonic() + self.random.uniform(0.001, 0.006)
            way.append((max(due, way[-1][0] if way else 0.0), data[:size]))
            data = data[size:]

    def due(self, way):
        out = b""
        while way and way[0][0] <= time.monotonic():
            out += way.popleft()[1]
        return out

    def read(self):
        try:
            if self.server and not self.line:
                self.line = self.server.accept()[0]
                self.line.setblocking(False)
                self.line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            if self.line:
                self.line.send(self.due(self.back))
                came = self.line.recv(4096)
                if not came:
                    self.lose()
                self.late(self.there, came)
        except BlockingIOError:
            pass
        except OSError:
            self.lose()
        return self.due(self.there)

    def write(self, data):
        self.late(self.back, data)


class World:
    """Fingers and a weight."""

    def __init__(self, mass_kg=1.5, friction=0.25, lift_s=1.2):
        self.mass_kg, self.friction, self.lift_s = mass_kg, friction, lift_s
        self.force_n = self.travel_m = self.speed_m_s = self.closed = 0.0
        self.held_s = None
        self.orders = collections.deque([(0.0, 0.0)])
        self.peak_n = 0.0
        self.least_held_n = math.inf

    @property
    def touches(self):
        return self.closed >= 1.0

    @property
    def needed_n(self):
        return self.mass_kg * 9.81 / (2 * self.friction)

    @property
    def dropped(self):
        return self.travel_m > 0.03

    def step(self, now_s, asked_n, dt=1e-3):
        """asked_n: what the register asks for (N), None to open."""
        if asked_n is None:
            self.closed = max(0.0, self.closed - dt / 0.3)
            self.force_n = 0.0
        else:
            self.orders.append((now_s + 0.005, asked_n))
            while len(self.orders) > 1 and self.orders[1][0] <= now_s:
                self.orders.popleft()
            target = self.orders[0][1] if self.orders[0][0] <= now_s else 0.0
            if target > 0.0:
                self.closed = min(1.0, self.closed + dt / 0.3)
            if self.touches and not self.dropped:
                self.held_s = self.held_s if self.held_s is not None else now_s
                self.force_n += (target - self.force_n) * dt / (dt + 0.015)
        self.peak_n = max(self.peak_n, self.force_n)
        load = 0.0
        if self.held_s is not None:
            load = self.mass_kg * 9.81 * min(1.0, max(0.0, (now_s - self.held_s - self.lift_s) / 0.3))
        grip = 2 * self.friction * self.force_n
        if self.speed_m_s > 0.0 or load > 1.05 * grip:
            self.speed_m_s = max(0.0, self.speed_m_s + (load - grip) / self.mass_kg * dt)
            self.travel_m += self.speed_m_s * dt


class Gripper:
    """The registers of a 2F-85."""

    def __init__(self, line, world, activated=True, holds_n=None):
        self.line, self.world = line, world
        self.registers = [0x0900, 0x0000, 0x2000] if activated else [0, 0, 0]
        if holds_n is not None:
            self.registers = [0x0900, 0x00FF, 0x2000 | round((holds_n - 20) * 255 / 215)]
            world.closed, world.force_n, world.held_s = 1.0, holds_n, -10.0
        self.activated, self.activating_s = activated, None
        self.fault, self.mute, self.garble = 0, False, 0.0
        self.writes = []
        self.input = b""
        self.due = []
        self.random = random.Random(1)

    def asked_n(self):
        action, position, strength = self.registers
        if not action & 0x0800 or position & 0xFF == 0:
            return None
        return 20.0 + (strength & 0xFF) * 215.0 / 255.0

    def status(self):
        action, position, _ = self.registers
        follows = action & 0x0800 and self.activated
        closes = position & 0xFF
        moving = follows and (0.0 < self.world.closed < 1.0 if not closes else not self.world.touches)
        object_ = 0 if moving else 2 if closes and self.world.touches and not self.world.dropped else 3
        state = 3 if self.activated else 1 if self.activating_s else 0
        byte = (object_ << 6) | (state << 4) | (8 if follows else 0) | (1 if action & 0x0100 else 0)
        place = int(3 + self.world.closed * (100 if self.world.held_s is not None else 227))
        return [byte << 8, (self.fault << 8) | closes, (place << 8) | 12]

    def answer(self, request):
        """The answer to a request, both without unit and checksum."""
        function, address, count = struct.unpack(">BHH", request[:5])
        if function == 0x10:
            if (address, count, len(request)) != (COMMAND, 3, 12):
                return bytes([0x90, 2])
            self.write(list(struct.unpack(">3H", request[6:])))
            return request[:5]
        if address != STATUS or not 1 <= count <= 3:
            return bytes([0x84, 2])
        return struct.pack(f">BB{count}H", 4, 2 * count, *self.status()[:count])

    def request(self):
        """The next whole request, without unit and checksum; bytes that are none are left out."""
        while len(self.input) >= 8:
            length = 9 + self.input[6] if self.input[1] == 0x10 else 8
            if self.input[0] == UNIT and self.input[1] in (4, 0x10):
                frame = self.input[:length]
                if len(frame) < length:
                    return None
                if crc16(frame[:-2]) == frame[-2:]:
                    self.input = self.input[length:]
                    return frame[1:-2]
            self.input = self.input[1:]
        return None

    def write(self, registers):
        self.writes.append((time.monotonic(), registers))
        if registers[0] & 0x0100 and not self.activated and not self.registers[0] & 0x0100:
            self.activating_s = time.monotonic() + 0.5
        if not registers[0] & 0x0100:
            self.activated = False
        self.registers = registers

    def turn(self, now):
        if self.activating_s and now >= self.activating_s:
            self.activated, self.activating_s = True, None
        self.input += self.line.read()
        while request := self.request():
            if self.mute:
                continue
            frame = bytes([UNIT]) + self.answer(request)
            frame = bytearray(frame + crc16(frame))
            if self.random.random() < self.garble:
                frame[self.random.randrange(len(frame))] ^= 1 << self.random.randrange(8)
            # 115200 bits per second, both ways, and a millisecond to think.
            self.due.append((now + 0.001 + (8 + len(frame)) * 10 / 115200, bytes(frame)))
        while self.due and self.due[0][0] <= now:
            self.line.write(self.due.pop(0)[1])


class Tsf85:
    """The stream of a TSF-85: two fingers, 160 bytes a millisecond, with a CRC-8 (polynomial 0x07)."""

    def __init__(self, line, world):
        self.line, self.world, self.streams = line, world, False
        self.random, self.garble, self.ring = random.Random(2), 0.0, 0.0

    def packet(self, records):
        body = bytes([0x58, len(records)]) + records
        crc = 0
        for byte in body:
            crc ^= byte
            for _ in range(8):
                crc = ((crc << 1) ^ 0x07 if crc & 0x80 else crc << 1) & 0xFF
        return bytes([0x9A, crc]) + body

    def record(self, kind, finger, values):
        data = b"".join((int(value) & 0xFFFF).to_bytes(2, "big") for value in values)
        return bytes([(kind << 4) | (finger << 2)]) + data

    def turn(self):
        if self.line.fd is None:
            self.streams = False
            return
        if b"\x9a" in self.line.read():
            self.streams = True
        if not self.streams:
            return
        # Irregularities ring the finger: louder with the speed.
        self.ring = 0.6 * self.ring + self.random.gauss(0, 1) * min(4000.0, 6e4 * self.world.speed_m_s)
        out = b""
        for finger in (0, 1):
            blob = [8 * self.world.force_n * math.exp(-((i % 4 - 1.5) ** 2 + (i // 4 - 3) ** 2) / 3) for i in range(28)]
            out += self.packet(self.record(1, finger, [200 + value for value in blob]))
        rest = b""
        for finger in (0, 1):
            dynamic = max(-32768, min(32767, self.random.gauss(0, 4) + self.ring))
            rest += self.record(2, finger, [dynamic])
            rest += self.record(3, finger, [0, 16384 + self.random.gauss(0, 20), 0])
            rest += self.record(4, finger, [0, 0, 0])
        data = bytearray(out + self.packet(rest))
        if self.random.random() < self.garble:
            data[self.random.randrange(len(data))] ^= 1 << self.random.randrange(8)
        self.line.write(bytes(data))


class Cell(threading.Thread):
    """Both devices and the world, in real time."""

    forwarded = False

    def __init__(self, folder, world=None, port=0, **gripper):
        super().__init__(daemon=True)
        self.world = world or World()
        line = Forwarder(port) if self.forwarded else Line(folder / "gripper")
        self.gripper = Gripper(line, self.world, **gripper)
        self.sensor = Tsf85(Line(folder / "tsf85"), self.world)
        self.asks, self.stopped = collections.deque(), False
        self.start()

    def do(self, what):
        """Runs `what` between two steps of the world."""
        done = threading.Event()
        self.asks.append((what, done))
        assert done.wait(5)

    def run(self):
        begin = due = time.monotonic()
        while not self.stopped:
            now = time.monotonic()
            # A device has a processor of its own: where this computer is later than 20 ms the world stands still meanwhile.
            late = max(0.0, now - due - 0.02)
            begin, due = begin + late, due + late
            while due <= now:
                self.world.step(due - begin, self.gripper.asked_n())
                self.sensor.turn()
                due += 1e-3
            self.gripper.turn(now)
            while self.asks:
                what, done = self.asks.popleft()
                what()
                done.set()
            fds = [line.fd for line in (self.gripper.line,) if line.fd is not None]
            select.select(fds, [], [], 0.0005)


class Scene:
    """gripd on a cell."""

    def __init__(self, gripd, options="", args=(), **cell):
        self.folder = tempfile.TemporaryDirectory()
        folder = Path(self.folder.name)
        self.cell = Cell(folder, **cell)
        command = [gripd, "--sensor", f"tsf85:{folder}/tsf85", "--gripper", f"robotiq:2f-85:{self.cell.gripper.line.name}{options}"]
        self.socket = f"unix:{folder}/gripd.sock"
        (folder / "gripd.toml").write_text(f'listen = "{self.socket}"\nallow_commands = true\n')
        command += ["--config", "gripd.toml", "--json", *args]
        env = {key: value for key, value in os.environ.items() if not key.startswith("GRIPD_")}
        self.err = open(folder / "err", "w+")
        self.out = open(folder / "out", "w+")
        self.gripd = subprocess.Popen(command, cwd=folder, env=env, stdin=subprocess.DEVNULL, stdout=self.out, stderr=self.err)

    def wait(self, seconds):
        """Waits, and gives the least force register asked for meanwhile."""
        end, least = time.monotonic() + seconds, math.inf
        while time.monotonic() < end:
            least = min(least, self.cell.gripper.asked_n() or 0.0)
            time.sleep(0.005)
        return least

    def end(self, sign=signal.SIGINT):
        if self.gripd.poll() is None:
            self.gripd.send_signal(sign)
        code = self.gripd.wait(20)
        time.sleep(0.2)
        self.cell.stopped = True
        self.cell.join()
        self.err.seek(0)
        self.out.seek(0)
        self.events = [json.loads(line) for line in self.out.read().splitlines()]
        self.text = self.err.read()
        return code


def opens(gripper):
    """Whether a write opens the fingers."""
    return [registers for _, registers in gripper.writes if registers[1] & 0xFF == 0 or not registers[0] & 0x0100]


def expect(what, scene, *details):
    if not what:
        print(scene.text, *details, [event for event in scene.events if event["type"] != "command"][-12:], file=sys.stderr)
        raise AssertionError("see above")


def held(gripd):
    """A slip at the lift is answered and the object held; the end of gripd changes nothing."""
    scene = Scene(gripd)
    scene.wait(5)
    code = scene.end()
    world, gripper = scene.cell.world, scene.cell.gripper
    slips = [event for event in scene.events if event["type"] == "slip"]
    expect(not world.dropped and slips and world.force_n > world.needed_n, scene, world.travel_m, world.force_n)
    expect(not opens(gripper), scene, opens(gripper))
    expect(gripper.asked_n() > world.needed_n, scene, "gripd has ended, and the force with it")
    expect(code == 0 and scene.events[-1]["type"] == "summary" and scene.events[-1]["rows"]["bad"] == 0, scene, code)
    return f"held: {world.force_n:.1f} N of {world.needed_n:.1f} N needed, {1e3 * world.travel_m:.1f} mm, {len(slips)} slip events"


def faults(gripd):
    """Each fault in turn while the object is held: the force stays, the fault is reported and what was lost is found again."""
    scene = Scene(gripd)
    scene.wait(5)
    cell, gripper, sensor = scene.cell, scene.cell.gripper, scene.cell.sensor
    before = gripper.asked_n()
    lines = []

    def during(name, begin, end, seconds=1.5):
        cell.do(begin)
        during_n = scene.wait(seconds)
        cell.do(end)
        after_n = scene.wait(2.5)
        lines.append((name, during_n, after_n))

    def setting(of, name, value):
        return lambda: setattr(of, name, value)

    during("Modbus time-outs", setting(gripper, "mute", True), setting(gripper, "mute", False))
    during("CRC errors on Modbus", setting(gripper, "garble", 0.2), setting(gripper, "garble", 0.0))
    during("fault 0x0E", setting(gripper, "fault", 0x0E), setting(gripper, "fault", 0))
    during("gripper unplugged", gripper.line.unplug, gripper.line.plug)
    during("fingertips unplugged", sensor.line.unplug, sensor.line.plug)
    during("broken packets of the fingertips", setting(sensor, "garble", 0.1), setting(sensor, "garble", 0.0))
    code = scene.end()
    world = cell.world
    for name, during_n, after_n in lines:
        expect(min(during_n, after_n) >= before - 0.5, scene, name, before, during_n, after_n)
    expect(not world.dropped and not opens(gripper), scene, world.travel_m, opens(gripper))
    for words in ("no answer over Modbus RTU", "motor current too high", "2F-85 on", "TSF-85 on", "found again"):
        expect(words in scene.text, scene, words)
    expect(scene.text.count("2F-85 on") >= 6 and code == 3, scene, code)
    return f"faults: {before:.1f} N before, at least {min(min(a, b) for _, a, b in lines):.1f} N in and after {len(lines)} of them"


def reset(gripd):
    """A gripper that was reset and activated by hand has let go: nothing closes it before a client clears the fault and asks for a grasp."""
    scene = Scene(gripd)
    scene.wait(4)
    cell, gripper = scene.cell, scene.cell.gripper

    def power(on):
        gripper.activated, gripper.registers = on, [0x0100 if on else 0, 0, 0]

    def client(*words):
        command = [os.path.join(os.path.dirname(gripd), "gripctl"), "command", *words, "--address", scene.socket]
        return subprocess.run(command, capture_output=True, text=True, timeout=20)

    held_n = gripper.asked_n()
    cell.do(lambda: power(False))
    scene.wait(1.5)
    cell.do(lambda: power(True))
    written = len(gripper.writes)
    scene.wait(2.5)
    answers = [client("grasp")]
    scene.wait(1)
    stands = gripper.writes[written:]
    answers += [client("clear-fault", "0201"), client("grasp")]
    scene.wait(1)
    closes = gripper.writes[written:]
    scene.end()
    codes = [answer.returncode for answer in answers]
    expect(held_n and not stands and "not activated" in scene.text, scene, held_n, stands)
    expect(codes[0] != 0 and codes[1:] == [0, 0], scene, answers)
    expect(closes and closes[-1][1][1] == 0xFF and not opens(gripper), scene, closes)
    return "reset: nothing moves before clear-fault and grasp of a client"


def killed(gripd):
    """gripd is killed: the registers stay."""
    scene = Scene(gripd)
    scene.wait(4)
    before = scene.cell.gripper.asked_n()
    scene.end(signal.SIGKILL)
    expect(scene.cell.gripper.asked_n() == before and not opens(scene.cell.gripper), scene)
    return "killed: the registers stay"


def starts(gripd):
    """What is not activated, or holds something, is left alone unless it was asked for."""
    scene = Scene(gripd, activated=False)
    scene.gripd.wait(20)
    expect(scene.end() == 1 and "not activated" in scene.text and not scene.cell.gripper.writes, scene)
    scene = Scene(gripd, options=",activate", activated=False)
    scene.wait(5)
    scene.end()
    expect(len(opens(scene.cell.gripper)) == 2 and scene.cell.world.force_n > 0, scene, opens(scene.cell.gripper))
    scene = Scene(gripd, holds_n=45)
    scene.gripd.wait(20)
    expect(scene.end() == 1 and "unknown force" in scene.text and not scene.cell.gripper.writes, scene)
    scene = Scene(gripd, options=",holds=45", holds_n=45)
    least = scene.wait(4)
    scene.end()
    expect(least > 44 and not opens(scene.cell.gripper), scene, least)
    return "starts: nothing is activated or taken over unasked"


def oracle(known):
    """The same object, held from touch on with 1.2 times the force that it is known to need, in steps of the register."""
    world = World(known.mass_kg, known.friction, known.lift_s)
    register = max(0, math.ceil((1.2 * world.needed_n - 20) * 255 / 215))
    for ms in range(5000):
        world.step(1e-3 * ms, 20 + register * 215 / 255)
    return world


def objects(gripd, count, seed):
    """Objects that need 10 to 45 N: what least force and f_max_n (20 and 60 N) leave room for. Crushed is 2.5 times the need."""
    chance = random.Random(seed)
    ratios, slips_mm, ends, bound = [], [], collections.Counter(), collections.Counter()
    verdict = lambda world: "dropped" if world.dropped else "crushed" if world.peak_n > max(2.5 * world.needed_n, 20.9) else "held"
    for _ in range(count):
        needed_n, friction = chance.uniform(10, 45), chance.uniform(0.2, 0.8)
        world = World(mass_kg=2 * friction * needed_n / 9.81, friction=friction, lift_s=chance.uniform(0.8, 1.6))
        scene = Scene(gripd, world=world)
        scene.wait(5)
        scene.end()
        ends[verdict(world)] += 1
        bound[verdict(oracle(world))] += 1
        ratios.append(world.force_n / needed_n)
        slips_mm.append(1e3 * world.travel_m)
        expect(not opens(scene.cell.gripper), scene)
        if verdict(world) != "held":
            states = [event for event in scene.events if event["type"] == "summary"]
            print(f"{verdict(world)}: needs {needed_n:.1f} N, friction {friction:.2f}, peak {world.peak_n:.1f} N", states, file=sys.stderr)
    middle = lambda values, share: sorted(values)[min(count - 1, int(share * count))]
    return (
        f"{count} objects, seed {seed}: {dict(ends)}, the oracle {dict(bound)}; force over needed {middle(ratios, 0.5):.2f} / {middle(ratios, 0.95):.2f}, "
        f"slip {middle(slips_mm, 0.5):.2f} / {middle(slips_mm, 0.95):.2f} mm (median / 95 %)"
    )


def main():
    if sys.argv[1] == "--forwarder":
        Cell.forwarded = True
        del sys.argv[1]
    if sys.argv[1] == "--objects":
        print(objects(os.path.abspath(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]) if len(sys.argv) > 4 else 1))
        return
    if sys.argv[1] == "--serve":
        cell = Cell(Path(sys.argv[2]), port=54321)
        signal.sigwait({signal.SIGINT, signal.SIGTERM})
        cell.stopped = True
        cell.join()
        return
    for scene in (held, faults, reset, killed, starts):
        print(scene(os.path.abspath(sys.argv[1])), flush=True)


if __name__ == "__main__":
    main()
