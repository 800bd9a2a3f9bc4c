"""Packets, scale and bridge without LeRobot, against a gripd and a servo of a few lines; random objects in simulated time."""

from __future__ import annotations

import random
import socket
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, Callable, Iterator, List, Tuple

import pytest
from slip_servo.bridge import Bridge, Scale
from slip_servo.feetech import GRIPPER, READ, TORQUE_LIMIT, Gripper, packet, packets
from slip_servo.virtual import OPEN, RATE_HZ, Arm, World, chosen, grasp


def until(what: Callable[[], bool], seconds: float = 10.0) -> None:
    end = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < end, "too late"
        time.sleep(0.005)


def test_packets_are_found_in_any_chunks_and_behind_noise() -> None:
    chance = random.Random(1)
    assert packet(1, READ, b"\x38\x02") == bytes.fromhex("ff ff 01 04 02 38 02 be")  # the example of Feetech's manual
    for _ in range(200):
        sent = [(chance.randrange(254), chance.randrange(256), chance.randbytes(chance.randrange(20))) for _ in range(5)]
        line = b"".join(bytes(chance.randrange(255) for _ in range(chance.choice((0, 0, 3)))) + packet(*one) for one in sent)
        buffer, found = bytearray(), []
        while line:
            step = chance.randrange(1, 9)
            buffer += line[:step]
            line = line[step:]
            found += list(packets(buffer))
        assert found == sent and not buffer


def test_a_damaged_packet_is_none_and_the_next_one_is_found() -> None:
    for place in range(2, 8):
        damaged = bytearray(packet(6, 0, b"\x10\x02"))
        damaged[place] ^= 0x20 if place != 3 else 0x01
        found = list(packets(bytearray(bytes(damaged) + packet(6, 0, b"\x07") + packet(6, 0, b"\x08"))))
        assert (6, 0, b"\x10\x02") not in found and found[-1] == (6, 0, b"\x08"), place


def test_forces_are_rounded_up_and_limited() -> None:
    scale = Scale(20.0, 500)
    assert [scale.thousandths(force) for force in (0.0, 0.02, 0.021, 1.0, 9.99, 10.0, 11.0, 1e9)] == [0, 1, 2, 50, 500, 500, 500, 500]
    assert [scale.newtons(load) for load in (0, 40, 41, 500)] == [0.0, 0.0, 0.82, 10.0]
    assert all(scale.newtons(scale.thousandths(force)) >= force for force in (1.0, 3.3333, 9.9))
    for wrong in ((0.0, 500), (float("nan"), 500), (20.0, 0), (20.0, 1001)):
        with pytest.raises(ValueError, match="are needed"):
            Scale(*wrong)


class Servo:
    """A servo that may fail or have been reset."""

    def __init__(self) -> None:
        self.limits: List[int] = []
        self.fails, self.on, self.stood, self.pressed = False, True, 1000, [0]

    def limit(self, thousandths: int) -> None:
        if self.fails:
            raise OSError("no answer")
        self.limits.append(thousandths)

    def limited(self) -> int:
        if self.fails:
            raise OSError("no answer")
        return self.limits[-1] if self.limits else self.stood

    def load(self) -> int:
        # Before a limit was written, what it pressed with when it was found.
        if not self.limits and len(self.pressed) > 1:
            return self.pressed.pop(0)
        return 100 if self.limits else self.pressed[0]

    def powered(self) -> bool:
        return self.on


@contextmanager
def attached(servo: Servo, values: List[float]) -> Iterator[Tuple[Bridge, socket.socket]]:
    """A bridge that has begun, and the socket of gripd that it connects to."""

    def readings() -> List[Tuple[float, float]]:
        time.sleep(0.005)
        return [(time.monotonic(), value) for value in values]

    with socket.create_server(("127.0.0.1", 0)) as gripd:
        gripd.settimeout(10)
        bridge = Bridge((f"127.0.0.1:{gripd.getsockname()[1]}", 400), readings, servo, Scale(20.0, 500), 1.5)
        try:
            yield bridge, gripd
        finally:
            bridge.close()


@pytest.fixture
def bridged() -> Iterator[Tuple[Bridge, Servo, socket.socket]]:
    servo = Servo()
    with attached(servo, [0.25, -1.5]) as (bridge, gripd):
        yield bridge, servo, gripd


def command(force_n: float) -> bytes:
    return b'{"type":"command","t_s":1.0,"mode":"force","force_n":%g}\n' % force_n


def test_rows_go_to_gripd_and_commands_to_the_servo(bridged: Tuple[Bridge, Servo, socket.socket]) -> None:
    _, servo, gripd = bridged
    line, _ = gripd.accept()
    with line:
        text = b""
        while text.count(b"\n") < 40 or b",2\n" not in text:
            text += line.recv(4096)
        header, *rows = text.split(b"\n")[:-1]
        times, values = zip(*(row.split(b",", 1) for row in rows))
        assert header == b"t_s,vibration,force_n,rate=400" and set(values) == {b"0.25,", b"-1.5,", b"-1.5,2"}
        assert all(abs(float(at) - time.monotonic()) < 5 for at in times) and sorted(times) == list(times)
        assert servo.limits[0] == 75  # with what the jaw closes
        line.sendall(b'nonsense\n[1]\n{"type":"slip"}\n{"type":"command","mode":"force","force_n":null}\n' + command(4.0)[:20])
        line.sendall(command(4.0)[20:])
        until(lambda: servo.limits[-1:] == [200])
        line.sendall(command(3.0))
        until(lambda: servo.limits[-1:] == [150])
        line.sendall(command(100.0))
        until(lambda: servo.limits[-1:] == [500])
        assert set(servo.limits) <= {75, 200, 150, 500}


def test_what_is_held_stays_held_when_gripd_comes_back(bridged: Tuple[Bridge, Servo, socket.socket]) -> None:
    _, servo, gripd = bridged
    line, _ = gripd.accept()
    line.sendall(command(6.0))
    until(lambda: servo.limits[-1:] == [300])
    line.close()
    before = len(servo.limits)
    line, _ = gripd.accept()
    with line:
        line.sendall(command(1.5))
        until(lambda: len(servo.limits) > before + 3)
        assert set(servo.limits[before:]) == {300}
        line.sendall(command(7.0))
        until(lambda: servo.limits[-1:] == [350])
        # Asked to open, the jaw gets what it needs to move; the next grasp begins anew.
        line.sendall(b'{"type":"command","mode":"open"}\n')
        until(lambda: servo.limits[-1:] == [500])
        line.sendall(command(1.5))
        until(lambda: servo.limits[-1:] == [75])
        line.sendall(command(5.0) + b'{"type":"command","mode":"open"}\n')
        until(lambda: servo.limits[-1:] == [500])
    # What was opened is not held: another gripd may begin with its trial force.
    line, _ = gripd.accept()
    with line:
        line.sendall(command(1.5))
        until(lambda: servo.limits[-1:] == [75])


def test_a_gripd_that_has_gone_costs_no_processor_where_the_sensor_is_silent() -> None:
    with attached(Servo(), []) as (_, gripd):
        line, _ = gripd.accept()
        line.recv(4096)
        line.close()
        time.sleep(0.2)
        spent_s = time.process_time()
        time.sleep(1.0)
        assert time.process_time() - spent_s < 0.4


def test_a_bus_that_fails_is_tried_again_and_a_reset_is_reported(bridged: Tuple[Bridge, Servo, socket.socket]) -> None:
    bridge, servo, gripd = bridged
    line, _ = gripd.accept()
    with line:
        servo.fails = True
        line.sendall(command(5.0))
        until(lambda: bridge.failures > 2)
        assert 250 not in servo.limits
        servo.fails = False
        until(lambda: servo.limits[-1:] == [250])
        servo.on = False
        until(lambda: bridge.reset)
        servo.on = True
        until(lambda: not bridge.reset)


@pytest.mark.parametrize(
    ("stood", "pressed", "on", "first"),
    [
        (300, [299], True, 300),  # held: this program has crashed
        (300, [70, 70, 299], True, 300),
        (1000, [480], True, 500),  # held by another program: no more than the most
        (1000, [0], True, 75),  # the limit of a servo that was switched on
        (300, [60], True, 75),  # with less than the trial force: that does not let go
        (300, [299], False, 75),  # off: it holds nothing
        (40, [40], True, 75),
    ],
)
def test_what_is_held_stays_held_when_this_begins_again(stood: int, pressed: List[int], on: bool, first: int) -> None:
    servo = Servo()
    servo.stood, servo.pressed, servo.on = stood, pressed, on
    with attached(servo, [0.0]) as (_, gripd), gripd.accept()[0] as line:
        line.sendall(command(1.5))
        until(lambda: len(servo.limits) > 2)
        assert set(servo.limits) == {first}
        line.sendall(command(9.0))
        until(lambda: servo.limits[-1:] == [max(450, first)])
        line.sendall(b'{"type":"command","mode":"open"}\n')
        until(lambda: servo.limits[-1:] == [500])
        line.sendall(command(1.5))
        until(lambda: servo.limits[-1:] == [75])


def test_nothing_is_written_before_the_servo_says_with_what_it_holds() -> None:
    servo = Servo()
    servo.stood, servo.pressed, servo.fails = 300, [299], True
    with attached(servo, [0.0]) as (bridge, gripd), gripd.accept()[0] as line:
        line.sendall(command(1.5))
        until(lambda: bridge.failures > 2)
        servo.fails = False
        until(lambda: len(servo.limits) > 2)
        assert set(servo.limits) == {300}


@pytest.mark.parametrize("error", [RuntimeError("Overload error!"), IndexError("short"), TypeError("closed")], ids=repr)
def test_no_error_of_a_servo_ends_the_writing(bridged: Tuple[Bridge, Servo, socket.socket], error: Exception) -> None:
    """Once, and for as long as it lasts."""
    bridge, servo, gripd = bridged
    line, _ = gripd.accept()
    with line:
        until(lambda: servo.limits[-1:] == [75])
        real, raised = servo.limit, threading.Event()

        def once(thousandths: int) -> None:
            if not raised.is_set():
                raised.set()
                raise error
            real(thousandths)

        def always(thousandths: int) -> None:
            raise error

        servo.limit = once  # type: ignore[method-assign]
        line.sendall(command(4.0))
        until(lambda: servo.limits[-1:] == [200])
        assert raised.is_set() and bridge.failures == 1
        servo.limit = always  # type: ignore[method-assign]
        line.sendall(command(5.0))
        until(lambda: bridge.failures > 4)
        assert servo.limits[-1] == 200
        servo.limit = real  # type: ignore[method-assign]
        until(lambda: servo.limits[-1:] == [250])


@pytest.fixture
def robot(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The robot's module, with an imitation of what it takes of LeRobot."""
    pytest.importorskip("grip_link")
    pytest.importorskip("slipgrip.lerobot")

    class Config:
        @staticmethod
        def register_subclass(_: str) -> Callable[[Any], Any]:
            return lambda made: made

    class Arm:
        def __init__(self, config: Any) -> None:
            self.config, self.bus, self.connected = config, SimpleNamespace(), False

        def connect(self, calibrate: bool = True) -> None:
            self.connected = True

        def disconnect(self) -> None:
            assert self.connected
            self.connected = False

    robots, so_follower = ModuleType("lerobot.robots"), ModuleType("lerobot.robots.so_follower")
    robots.RobotConfig = Config  # type: ignore[attr-defined]
    so_follower.SOFollower, so_follower.SOFollowerRobotConfig = Arm, object  # type: ignore[attr-defined]
    for name, module in (("lerobot", ModuleType("lerobot")), ("lerobot.robots", robots), ("lerobot.robots.so_follower", so_follower)):
        monkeypatch.setitem(sys.modules, name, module)
    for name in ("lerobot_robot_slipgrip", "lerobot_robot_slipgrip.robot"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    import lerobot_robot_slipgrip.robot as made

    yield made
    for name in ("lerobot_robot_slipgrip", "lerobot_robot_slipgrip.robot"):
        sys.modules.pop(name, None)


def test_a_status_bit_is_a_bus_that_failed(robot: Any) -> None:
    """LeRobot raises RuntimeError where a servo answers with overload or overheating."""
    for error in (RuntimeError("[RxPacketError] Overload error!"), IndexError("short"), ConnectionError("no status packet")):

        class Bus:
            def write(self, *_: Any, **__: Any) -> None:
                raise error  # noqa: B023

            read = write

        motor = robot.Motor(Bus(), threading.RLock())
        for call in (lambda: motor.limit(75), motor.limited, motor.load, motor.powered):  # noqa: B023
            with pytest.raises(OSError):
                call()


@pytest.mark.parametrize("missing", ["Board", "Bridge", "LiveSlip", "Daemon", "commands", None])
def test_a_connection_that_fails_leaves_nothing_behind(robot: Any, monkeypatch: pytest.MonkeyPatch, missing: Any) -> None:
    open_now: List[str] = []

    def part(name: str) -> Any:
        def made(*_: Any) -> Any:
            if missing == name:
                raise OSError(f"no {name}")
            open_now.append(name)
            flags = 0 if missing == "commands" else robot.WelcomeFlags.COMMANDS
            return SimpleNamespace(close=lambda: open_now.remove(name), readings=list, welcome=SimpleNamespace(flags=flags))

        return made

    for name in ("Board", "Bridge", "LiveSlip"):
        monkeypatch.setattr(robot, name, part(name))
    monkeypatch.setattr(robot, "Daemon", SimpleNamespace(open=part("Daemon")))
    config = SimpleNamespace(sensor="", rate_hz=800, rows="", gripd="", full_n=19.0, most=500, trial_n=1.5)
    arm = robot.SlipGrip(config)
    if missing is None:
        arm.connect()
        assert arm.connected and len(open_now) == 4
        arm.disconnect()
    else:
        with pytest.raises(OSError, match=f"no {missing}|takes no commands"):
            arm.connect()
    assert not arm.connected and not open_now


def test_a_part_that_does_not_end_keeps_no_other(robot: Any) -> None:
    arm, ended = robot.SlipGrip(SimpleNamespace()), []
    arm.connected = True

    def broken() -> None:
        raise OSError("unplugged")

    arm._board, arm._bridge = SimpleNamespace(close=lambda: ended.append("board")), SimpleNamespace(close=broken)
    with pytest.raises(OSError, match="unplugged"):
        arm.disconnect()
    assert ended == ["board"] and not arm.connected


def test_the_virtual_arm_answers_as_six_servos(tmp_path: Path) -> None:
    arm = Arm(tmp_path / "so101", World())
    try:
        for number in range(1, 7):
            servo = Gripper(str(arm.path), number, patience_s=2.0)
            servo.limit(300 + number)
            assert arm.servos[number].get(TORQUE_LIMIT) == servo.limited() == 300 + number and not servo.powered() and servo.load() < 100
            servo.close()
        absent = Gripper(str(arm.path), 9)
        with pytest.raises(OSError, match="servo 9: no answer"):
            absent.load()
        absent.close()
        assert arm.gripper.number == GRIPPER and abs(arm.world.jaw - OPEN) < 1 and arm.readings()
    finally:
        arm.close()


@pytest.mark.parametrize(("chunk_ms", "delay_ms"), [(5, 5), (20, 5), (5, 20)])
def test_random_objects_are_held(chunk_ms: int, delay_ms: int) -> None:
    chance = random.Random(4)
    worlds = [grasp(chosen(chance, number), chunk_ms * RATE_HZ // 1000, delay_ms * RATE_HZ // 1000) for number in range(12)]
    assert not any(world.dropped for world in worlds)
    # What stands needs 5 % less than what slides.
    assert all(1.05 * world.force_n >= world.needed_n for world in worlds)
    assert any(world.travel_m > 0 for world in worlds), "nothing slipped"
