"""GripLink and VirtualMcu in simulated time over two queues of bytes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Optional

import pytest
from grip_link import ChannelKind, Config, DriveKind, GripLink, HostState, LinkClosed, StreamClosed, VirtualMcu
from grip_link.device import Drive
from grip_link.diff import reference_ident
from grip_link.host import Closed, GripCommand, Rebooted
from grip_link.messages import DeviceState, FaultCode, Heartbeat, SampleFormat
from grip_link.stream import Outgoing


class World:
    """One clock, two ends of a line; the gripper runs whenever the host waits."""

    def __init__(self) -> None:
        self.now_us = 5_000_000
        self.to_mcu = self.to_host = b""
        self.cut = False
        self.mcu_runs = True
        self.forces: list[tuple[int, Drive]] = []
        self.mcu = VirtualMcu(
            McuEnd(self), self.sense, lambda t_s, drive: self.forces.append((self.now_us, drive)),
            ident=reference_ident(), clock_us=lambda: self.now_us,
        )  # fmt: skip

    def sense(self, t_s: float) -> list[float]:
        return [1e-6 * math.sin(50 * t_s), 2.0, 1.0, 2.0, math.nan, 1e9]

    def wait(self, timeout_s: float) -> None:
        end_us = self.now_us + max(round(timeout_s * 1e6), 100)
        while self.now_us < end_us and not self.to_host:
            self.now_us += 100
            if self.mcu_runs:
                self.mcu.step()

    def link(self, config: Optional[Config] = None) -> GripLink:
        return GripLink(HostEnd(self), config, clock_us=lambda: self.now_us, session=0xABC)


class McuEnd:
    def __init__(self, world: World) -> None:
        self.world = world

    def read(self, timeout_s: float) -> bytes:
        data, self.world.to_mcu = self.world.to_mcu, b""
        return data

    def write(self, data: bytes) -> int:
        self.world.to_host += data[:100]
        return min(len(data), 100)

    def close(self) -> None:
        self.world.cut = True


class HostEnd(McuEnd):
    def read(self, timeout_s: float) -> bytes:
        if self.world.cut:
            raise StreamClosed("unplugged")
        self.world.wait(timeout_s)
        data, self.world.to_host = self.world.to_host, b""
        return data

    def write(self, data: bytes) -> int:
        if self.world.cut:
            raise StreamClosed("unplugged")
        self.world.to_mcu += data
        return len(data)


@pytest.fixture
def world() -> Iterator[World]:
    yield World()


@pytest.mark.parametrize("sample_format", list(SampleFormat))
def test_samples_come_in_order_in_si_units(world: World, sample_format: SampleFormat) -> None:
    with world.link(Config(sample_rate_hz=2000, batch=2, format=sample_format)) as link:
        link.connect()
        samples = list(link.samples(1.0))
        assert 1990 <= len(samples) <= 2010 and link.loss.lost == 0
        assert [sample.index for sample in samples] == list(range(len(samples)))
        for sample in samples[100::100]:
            stylus_m = 1e-6 * math.sin(50 * sample.tick / 1e6)
            assert sample[ChannelKind.STYLUS] == pytest.approx(stylus_m, abs=5.1e-9)
            assert sample[ChannelKind.NORMAL_FORCE] == pytest.approx(2.0)
            pressures = sample.array(ChannelKind.PRESSURE_ARRAY)
            largest = 327_670.0 if sample_format is SampleFormat.I16 else 1e9
            assert pressures == pytest.approx((0.0 if sample_format is SampleFormat.I16 else 1.0, pressures[1], math.nan, largest), nan_ok=True)
            assert sample.host_s == pytest.approx((sample.tick + 5_000_000) / 1e6, abs=1e-3)
            with pytest.raises(KeyError):
                sample[ChannelKind.TRAVEL]


def test_a_controller_holds_and_a_silent_one_makes_the_gripper_hold(world: World) -> None:
    with world.link(Config(sample_rate_hz=1000, batch=1, loss_after_ms=400)) as link:
        link.connect()
        sent = [link.grip(3.0, cause_sample=sample.index) for sample in link.samples(0.2)]
        assert all(grip is not None and grip.force_mn == 3000 for grip in sent)
        assert link.status is not None and link.status.applied_mn == 3000
        assert link.status.state == DeviceState.ACTIVE
        link.wait(lambda: False, 0.2)
        assert link.status.state == DeviceState.HOLD and link.status.applied_mn == 3000
        link.wait(lambda: False, 0.5)
        assert link.status.state == DeviceState.LOSS_ACTION
        link.reconfigure(Config(sample_rate_hz=1000, batch=1))
        link.connect()
        for _ in link.samples(0.1):
            link.command(GripCommand(2500, answers_slip=True))
        assert link.status.applied_mn == 2500 and link.status.state == DeviceState.ACTIVE
    assert world.cut and world.forces[-1][1] == Drive(DriveKind.FORCE, 2500)


def test_force_is_never_sent_before_samples_flow_nor_nonsense_at_all(world: World) -> None:
    link = world.link()
    assert link.grip(1.0) is None and link.heartbeat(Heartbeat(1, 2, 3, 0)) is None
    link.connect()
    link.heartbeat(Heartbeat(1, 2, 3, 0))
    for force_n in (math.nan, -1.0, math.inf):
        with pytest.raises(ValueError):
            link.grip(force_n)
    link.close()
    with pytest.raises(LinkClosed):
        link.grip(1.0)
    assert all(drive.kind is DriveKind.PASSIVE for _, drive in world.forces)


def test_a_reboot_is_survived(world: World) -> None:
    with world.link(Config(sample_rate_hz=1000, batch=1)) as link:
        link.connect()
        for sample in link.samples(0.1):
            link.grip(2.0)
        assert world.mcu.drive.force_mn == 2000
        world.mcu.reboot()
        assert world.mcu.drive.kind is DriveKind.PASSIVE
        link.wait(lambda: any(isinstance(event, Rebooted) for event in link.events()), 2.0)
        link.connect()
        assert link.ident is not None and link.ident.boot_id == 0xB008
        assert sum(1 for _ in link.samples(0.1)) > 90
        assert world.mcu.drive.kind is DriveKind.PASSIVE


def test_estop_and_clear(world: World) -> None:
    with world.link(Config(sample_rate_hz=1000, batch=1)) as link:
        link.connect()
        for _ in link.samples(0.1):
            link.grip(2.0)
        assert link.estop()
        assert world.mcu.link.state == DeviceState.ESTOP and world.mcu.drive.force_mn == 2000
        link.clear_fault(FaultCode.ESTOP)
        assert link.wait(lambda: world.mcu.link.state == DeviceState.ARMED, 0.5)


def test_unplugging_raises_and_names_the_port(world: World) -> None:
    link = world.link()
    link.connect()
    world.cut = True
    with pytest.raises(LinkClosed) as closed:
        for _ in link.samples(1.0):
            pass
    assert closed.value.reason.code == "port" and link.state is HostState.CLOSED
    assert any(isinstance(event, Closed) for event in link.events())
    link.close()


def test_a_gripper_that_hangs_is_lost_and_one_that_is_not_there_is_said(world: World) -> None:
    link = world.link()
    link.connect()
    world.mcu_runs = False
    with pytest.raises(LinkClosed) as closed:
        link.wait(lambda: False, 3.0)
    assert closed.value.reason.code == "lost"
    silent = World()
    silent.mcu_runs = False
    with pytest.raises(LinkClosed) as closed:
        silent.link().connect()
    assert closed.value.reason.code == "no_answer"


def test_stop_ends_the_samples_and_start_goes_on(world: World) -> None:
    with world.link() as link:
        link.connect()
        for count, _ in enumerate(link.samples()):
            if count == 50:
                link.stop()
        assert link.wait(lambda: link.state is HostState.CONFIG, 1.0)
        link.start()
        link.connect()
        assert sum(1 for _ in link.samples(0.1)) > 50 and link.loss.lost == 0


def test_rows_that_nobody_fetches_are_bounded_and_counted(world: World) -> None:
    with world.link(Config(sample_rate_hz=5000, batch=5)) as link:
        link.KEPT_ROWS = 100
        link.connect()
        link.wait(lambda: False, 0.5)
        assert link.overflow > 2000
        assert next(link.samples()).index == link.overflow


def test_a_frame_that_does_not_fit_is_finished_before_the_next() -> None:
    class Slow:
        out = b""
        room = 3

        def read(self, timeout_s: float) -> bytes:
            return b""

        def write(self, data: bytes) -> int:
            taken = min(self.room, len(data))
            self.out += data[:taken]
            self.room -= taken
            return taken

        def close(self) -> None:
            pass

    slow = Slow()
    outgoing = Outgoing(slow)
    assert outgoing.send(b"abcdef") and not outgoing.is_free and not outgoing.send(b"lost")
    slow.room = 100
    assert outgoing.is_free and outgoing.send(b"ghi") and slow.out == b"abcdefghi"


def test_leaving_the_samples_early_loses_none(world: World) -> None:
    with world.link(Config(sample_rate_hz=2000, batch=20)) as link:
        link.connect()
        seen = [next(link.samples()).index for _ in range(200)]
        assert seen == list(range(200))


def test_a_sensor_with_too_few_channels_is_an_error(world: World) -> None:
    world.sense = lambda t_s: [1.0]
    world.mcu._sensor = world.sense
    with pytest.raises(ValueError, match="6 elements"):
        world.link().connect()
