"""GripLink and VirtualMcu in simulated time over two queues of bytes, which tests may damage."""

from __future__ import annotations

import math
import random
from typing import Callable, Optional

import pytest
from grip_link import ChannelKind, Config, DriveKind, GripLink, LinkClosed, StreamClosed, VirtualMcu
from grip_link.decoder import Decoder, Role
from grip_link.device import Drive
from grip_link.diff import reference_ident
from grip_link.messages import DeviceState, Event, EventKind, FaultCode, Kind, SampleFormat
from grip_link.sender import Sender

CONFIG = Config(sample_rate_hz=1000, batch=1)
Wire = Callable[[bytes], bytes]


class World:
    """One clock, two ends of a line; the gripper runs whenever the host waits."""

    def __init__(self, room: int = 10_000, ppm: float = 0.0) -> None:
        self.now_us, self.room, self.session = 5_000_000, room, 0xABC
        self.at_mcu = self.at_host = b""
        self.cut, self.mcu_runs = False, True
        self.to_mcu: Wire = lambda data: data
        self.to_host: Wire = lambda data: data
        self.forces: list[tuple[int, Drive]] = []
        self.mcu = VirtualMcu(
            McuEnd(self), lambda t_s: [1e-6 * math.sin(50 * t_s), 2.0, 1.0, 2.0, math.nan, 1e9],
            lambda t_s, drive: self.forces.append((self.now_us, drive)),
            ident=reference_ident(), clock_us=lambda: round(self.now_us * (1 + ppm * 1e-6)),
        )  # fmt: skip

    def wait(self, timeout_s: float) -> None:
        end_us = self.now_us + max(round(timeout_s * 1e6), 100)
        while self.now_us < end_us and not self.at_host:
            self.now_us += 100
            if self.mcu_runs:
                self.mcu.step()

    def link(self, config: Optional[Config] = None) -> GripLink:
        self.cut, self.session = False, self.session + 1
        return GripLink(HostEnd(self), config, clock_us=lambda: self.now_us, session=self.session)

    def linked(self, config: Config = CONFIG) -> GripLink:
        link = self.link(config)
        link.connect()
        return link

    def most_mn(self, since_us: int) -> int:
        return max(drive.force_mn for at_us, drive in self.forces if at_us >= since_us)


class McuEnd:
    def __init__(self, world: World) -> None:
        self.world = world

    def read(self, timeout_s: float) -> bytes:
        data, self.world.at_mcu = self.world.at_mcu, b""
        return data

    def write(self, data: bytes) -> int:
        taken = data[: self.world.room]
        self.world.at_host += self.world.to_host(taken)
        return len(taken)

    def close(self) -> None:
        self.world.cut = True


class HostEnd(McuEnd):
    def read(self, timeout_s: float) -> bytes:
        if self.world.cut:
            raise StreamClosed("unplugged")
        self.world.wait(timeout_s)
        data, self.world.at_host = self.world.at_host, b""
        return data

    def write(self, data: bytes) -> int:
        if self.world.cut:
            raise StreamClosed("unplugged")
        self.world.at_mcu += self.world.to_mcu(data)
        return len(data)


def without(kind: Kind, most: int = 1_000_000) -> Wire:
    """A line that loses the first ``most`` frames of a type."""
    left = most

    def lose(data: bytes) -> bytes:
        nonlocal left
        lost = left > 0 and any(block.frame and block.frame.header.kind == kind for block in Decoder(Role.TAP).feed(data))
        left -= lost
        return b"" if lost else data

    return lose


def pressed(link: GripLink, force_n: float, seconds: float) -> None:
    """Commands a force with each sample."""
    for sample in link.samples(seconds):
        link.grip(force_n, cause_sample=sample.index)


def idle(link: GripLink, seconds: float) -> None:
    link.wait(lambda: False, seconds)


@pytest.mark.parametrize("sample_format", list(SampleFormat))
def test_samples_come_in_order_in_si_units(sample_format: SampleFormat) -> None:
    link = World(room=100).linked(Config(sample_rate_hz=2000, batch=2, format=sample_format))
    samples = list(link.samples(1.0))
    assert 1990 <= len(samples) <= 2010 and link.loss.lost == 0 and link.loss.received >= len(samples)
    assert [sample.index for sample in samples] == list(range(len(samples)))
    assert link.counters.bad_blocks == link.counters.gap == link.counters.stale == link.malformed_frames == 0
    for sample in samples[100::100]:
        assert sample[ChannelKind.STYLUS] == pytest.approx(1e-6 * math.sin(50 * sample.tick / 1e6), abs=5.1e-9)
        assert sample[ChannelKind.NORMAL_FORCE] == pytest.approx(2.0)
        pressures = sample.array(ChannelKind.PRESSURE_ARRAY)
        raw = sample_format is SampleFormat.I16
        assert pressures == pytest.approx((0.0 if raw else 1.0, pressures[1], math.nan, 327_670.0 if raw else 1e9), nan_ok=True)
        with pytest.raises(KeyError):
            sample[ChannelKind.TRAVEL]


@pytest.mark.parametrize("ppm", [0.0, 90.0, -90.0])
def test_times_of_the_host_follow_a_clock_that_drifts(ppm: float) -> None:
    world = World(ppm=ppm)
    link = world.linked(Config(sample_rate_hz=100, batch=1))
    for sample in link.samples(20.0):
        true_s = (sample.tick + round(5e6 * (1 + ppm * 1e-6))) / (1e6 + ppm)
        assert -1e-5 < sample.host_s - true_s < 5e-4


@pytest.mark.parametrize("kind", [Kind.HELLO, Kind.CONFIG, Kind.START, Kind.IDENT, Kind.CONFIG_ACK, Kind.ACK])
def test_two_lost_requests_or_answers_are_repeated(kind: Kind) -> None:
    world = World()
    world.to_mcu = world.to_host = without(kind, 2)
    link = world.linked()
    pressed(link, 1.0, 0.1)
    assert world.mcu.drive.force_mn == 1000 and link.loss.lost == 0


def test_a_controller_holds_and_a_silent_one_makes_the_gripper_hold() -> None:
    world = World()
    with world.link(Config(sample_rate_hz=1000, batch=1, loss_after_ms=400)) as link:
        link.connect()
        sent = [link.grip(3.0, cause_sample=sample.index) for sample in link.samples(0.2)]
        assert all(grip is not None and grip.force_mn == 3000 for grip in sent)
        assert link.status is not None and link.status.applied_mn == 3000
        assert link.status.state == DeviceState.ACTIVE
        idle(link, 0.2)
        assert link.status.state == DeviceState.HOLD and link.status.applied_mn == 3000
        idle(link, 0.5)
        assert link.status.state == DeviceState.LOSS_ACTION
        link.reconfigure(CONFIG)
        pressed(link, 2.5, 0.1)
        assert link.status.applied_mn == 2500 and link.status.state == DeviceState.ACTIVE
        kinds = {(event.kind, event.after) for event in link.reports if isinstance(event, Event)}
        assert (EventKind.STATE, DeviceState.HOLD) in kinds
    assert world.cut and world.forces[-1][1] == Drive(DriveKind.FORCE, 2500)


def test_force_is_never_sent_before_samples_flow_nor_nonsense_at_all() -> None:
    world = World()
    link = world.link()
    assert link.grip(1.0) is None
    link.connect()
    for force_n in (math.nan, -1.0, math.inf, 3e6):
        with pytest.raises(ValueError):
            link.grip(force_n)
    link.close()
    with pytest.raises(LinkClosed):
        link.grip(1.0)
    assert all(drive.kind is DriveKind.PASSIVE for _, drive in world.forces)
    with pytest.raises(ValueError):
        world.link(Config(force_max_mn=-1))


def test_a_force_is_not_raised_while_samples_are_missing() -> None:
    world = World()
    link = world.linked()
    pressed(link, 2.0, 0.1)
    world.to_host = without(Kind.SAMPLES)
    idle(link, 0.02)
    for _ in range(10):
        grip = link.grip(9.0)
        assert grip is not None and grip.force_mn == 2000
        idle(link, 0.01)
    assert link.is_degraded and world.mcu.drive.force_mn == 2000
    # A gripper may hold what this link has never commanded: then 0 N would let it go.
    world.to_host = without(Kind.SAMPLES, 0)
    again = world.linked()
    world.to_host = without(Kind.SAMPLES)
    idle(again, 0.02)
    assert again.grip(0.0) is None and world.mcu.drive.force_mn == 2000


def test_lost_and_dropped_rows_are_counted() -> None:
    world = World()
    link = world.linked()
    idle(link, 0.1)
    world.to_host = without(Kind.SAMPLES, 3)
    idle(link, 0.1)
    assert (link.loss.lost, link.loss.dropped_by_mcu) == (3, 0)
    world.room = 0
    idle(link, 0.03)
    world.room = 10_000
    idle(link, 0.1)
    assert link.loss.lost == 3 + link.loss.dropped_by_mcu > 10 and not link.is_degraded


def test_a_reboot_ends_the_link_and_moves_nothing() -> None:
    world = World()
    link = world.linked()
    pressed(link, 2.0, 0.1)
    world.mcu.reboot()
    with pytest.raises(LinkClosed, match="rebooted"):
        idle(link, 1.1)
    assert world.mcu.drive.kind is DriveKind.PASSIVE
    again = world.linked()
    assert again.ident is not None and again.ident.boot_id == 0xB008
    assert sum(1 for _ in again.samples(0.1)) > 90 and world.mcu.drive.kind is DriveKind.PASSIVE


def test_estop_and_clear() -> None:
    world = World()
    link = world.linked()
    pressed(link, 2.0, 0.1)
    assert link.estop()
    assert world.mcu.link.state == DeviceState.ESTOP and world.mcu.drive.force_mn == 2000
    link.clear_fault(FaultCode.ESTOP)
    pressed(link, 2.5, 0.1)
    assert world.mcu.drive.force_mn == 2500 and link.estop()
    again = world.link()
    with pytest.raises(LinkClosed, match="refused: CONFIG: latched"):
        again.connect()
    with pytest.raises(LinkClosed, match="no CONFIG is in force"):
        next(again.samples(0.1))
    again.clear_fault(FaultCode.ESTOP)
    assert world.mcu.link.state == DeviceState.ARMED


def test_what_ends_a_link_is_named() -> None:
    world = World()
    link = world.linked()
    world.cut = True
    for _ in range(2):
        with pytest.raises(LinkClosed, match="port"):
            list(link.samples(1.0))
    link.close()
    unplugged = world.link()
    world.cut = True
    with pytest.raises(LinkClosed, match="port"):
        unplugged.connect()
    link = world.linked()
    world.mcu_runs = False
    with pytest.raises(LinkClosed, match="lost"):
        idle(link, 3.0)
    with pytest.raises(LinkClosed, match="no_answer"):
        world.linked()
    version = World()
    sender = Sender(to_host=True)
    sender.session = version.session + 1
    version.to_host = lambda data: sender.send(Kind.IDENT, b"\2\3") if data else b""
    with pytest.raises(LinkClosed, match="version_mismatch"):
        version.linked()


def test_an_echoing_line_is_counted_and_works() -> None:
    world = World()

    def echo(data: bytes) -> bytes:
        world.at_host += data
        return data

    world.to_mcu = echo
    link = world.linked()
    pressed(link, 1.0, 0.2)
    assert link.counters.echo > 100 and link.loss.lost == 0 and world.mcu.drive.force_mn == 1000


def test_modem_commands_and_noise_are_garbage_only() -> None:
    rng, world = random.Random(4), World()
    world.to_mcu = lambda data: b"AT+GCAP\r\nATZ\r" + data
    link = world.linked()
    world.to_mcu = world.to_host = lambda data: rng.randbytes(rng.randrange(30)) + b"\0" + data
    pressed(link, 3.0, 0.5)
    assert link.counters.garbage_bytes > 1000 and world.mcu.link.counters.garbage_bytes > 1000
    assert link.counters.gap == world.mcu.link.counters.gap == 0 and world.mcu.drive.force_mn == 3000


def test_random_damage_never_makes_a_force_that_was_not_asked() -> None:
    rng, world = random.Random(5), World()

    def damage(data: bytes) -> bytes:
        if not data or rng.random() < 0.9:
            return data
        at, kind = rng.randrange(len(data)), rng.randrange(4)
        if kind == 0:
            return data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1 :]
        if kind == 1:
            return data[:at] + data[at + rng.randint(1, 8) :]
        return data[:at] + rng.randbytes(4) + data[at:] if kind == 2 else data + data[-64:]

    link = world.linked()
    start_us, world.to_mcu, world.to_host = world.now_us, damage, damage
    pressed(link, 2.0, 1.5)
    assert 0 < world.most_mn(start_us) <= 2000
    counters = world.mcu.link.counters
    assert counters.crc + counters.cobs + counters.length > 10 and world.mcu.link.rejected == 0


def test_rows_that_nobody_fetches_are_bounded_and_counted() -> None:
    link = World().linked(Config(sample_rate_hz=5000, batch=5))
    link.KEPT_ROWS = 100
    idle(link, 0.5)
    assert link.overflow > 2000
    assert [next(link.samples()).index for _ in range(50)] == list(range(link.overflow, link.overflow + 50))


def test_a_sensor_with_too_few_channels_is_an_error() -> None:
    world = World()
    world.mcu._sensor = lambda t_s: [1.0]
    with pytest.raises(ValueError, match="6 elements"):
        world.linked()
