"""Host and device on one line in simulated time: greeting, loss, reboot, echo, garbage, clocks."""

from __future__ import annotations

import random

import pytest
from grip_link import frame
from grip_link.decoder import Role
from grip_link.device import DeviceLink, DriveKind
from grip_link.frame import Header
from grip_link.host import Batch, Closed, ClockUpdated, Configured, GripCommand, HostState, Identified, Rebooted
from grip_link.messages import (
    Clamped,
    Config,
    DeviceState,
    Event,
    EventKind,
    Grip,
    Hello,
    Kind,
    Log,
    LogLevel,
    SampleFormat,
    Stats,
)

from grip_link.sender import Sender
from line import WANTED, Line, ident, kinds_in, without


def test_the_number_of_a_frame_wraps() -> None:
    sender = Sender(to_host=True)
    sender.next_seq = 0xFFFF
    assert len(sender.send(Kind.LOG)) > 0
    assert (sender.next_seq, sender.sent) == (0, 1)


def test_a_session_from_hello_to_samples() -> None:
    line = Line()
    line.open()
    assert line.states == [HostState.HELLO, HostState.CONFIG, HostState.STREAM]
    assert line.told(Identified)[0].ident.uid == b"grip-link-test-1"
    assert line.told(Configured) == [Configured(WANTED, Clamped(0))]
    line.run(1000)
    rows = sum(len(batch.samples) for batch in line.told(Batch))
    assert rows == line.host.loss.received >= 1000
    assert line.host.loss.lost == 0
    assert line.host.counters.bad_blocks == line.host.counters.gap == line.host.counters.stale == 0
    assert len(line.told(Stats)) >= 1
    assert line.status.state == DeviceState.ARMED


def test_samples_scale_to_their_units() -> None:
    for sample_format in SampleFormat:
        line = Line(Config(batch=1, channel_mask=3, format=sample_format))
        line.open()
        samples = line.told(Batch)[-1].samples
        stylus_m, force_n = line.host.layout.scaled(samples.rows[0], samples.format)
        assert abs(stylus_m) <= 1e-6 and force_n == pytest.approx(2.5)


def test_what_is_asked_too_much_is_clamped_and_named() -> None:
    line = Line(Config(sample_rate_hz=10**6, force_max_mn=10**6, ttl_ms=500, channel_mask=3, hold_cap_mn=10**6))
    line.open()
    (configured,) = line.told(Configured)
    assert configured.clamped == Clamped.RATE | Clamped.FORCE_MAX | Clamped.TTL | Clamped.HOLD_CAP
    assert configured.config.force_max_mn == 20_000 and configured.config.hold_cap_mn == 15_000
    assert configured.config.ttl_ms == 100


@pytest.mark.parametrize("kind", [Kind.HELLO, Kind.CONFIG, Kind.START])
def test_two_lost_requests_are_repeated(kind: Kind) -> None:
    line = Line()
    line.to_device = without(kind, 2)
    line.host.open(line.now_us, 7)
    line.run(400)
    assert line.host.state is HostState.STREAM


@pytest.mark.parametrize("kind", [Kind.IDENT, Kind.CONFIG_ACK, Kind.ACK])
def test_two_lost_answers_are_repeated(kind: Kind) -> None:
    line = Line()
    line.to_host = without(kind, 2)
    line.host.open(line.now_us, 7)
    line.run(400)
    assert line.host.state is HostState.STREAM
    assert line.host.loss.lost == 0


def test_no_answer_says_what_came() -> None:
    line = Line()
    line.to_device = lambda data: b""
    line.to_host = lambda data: b"F=5.12 I=0.331\r\n"
    line.host.open(line.now_us, 7)
    line.run(3100)
    (closed,) = line.told(Closed)
    assert closed.reason.code == "no_answer" and closed.reason.detail.startswith("30 HELLOs")
    assert "F=5.12 I=0.331" in closed.reason.detail and closed.reason.detail.endswith("docs/rows.md")
    assert line.host.reopen_after_us == 50_000
    assert line.host.grip(line.now_us, GripCommand.newtons(1.0)) is None


def test_three_configs_without_an_answer_close_the_link() -> None:
    line = Line()
    line.to_host = without(Kind.CONFIG_ACK)
    line.host.open(line.now_us, 7)
    line.run(400)
    (closed,) = line.told(Closed)
    assert closed.reason.code == "unanswered"


def test_a_silent_line_is_lost_after_a_second() -> None:
    line = Line()
    line.open()
    line.to_host = lambda data: b""
    line.run(900)
    assert line.host.state is HostState.DEGRADED
    line.run(200)
    (closed,) = line.told(Closed)
    assert closed.reason.code == "lost"


def test_lost_samples_are_counted_and_degrade() -> None:
    line = Line()
    line.open()
    before = line.host.loss.received
    line.to_host = without(Kind.SAMPLES, 3)
    line.run(20)
    assert line.host.loss.lost == 3 and HostState.DEGRADED in line.states
    assert line.host.state is HostState.STREAM
    assert line.host.loss.received == before + 17


def test_rows_that_cannot_be_sent_are_dropped_oldest_first_and_counted() -> None:
    line = Line()
    line.open()
    device = line.device
    for tick in range(line.tick + 1000, line.tick + 11_000, 1000):
        device.push(tick, (1, 2))
    assert device.dropped_rows == 6
    line.now_us += 11_000
    line.run(20)
    assert line.host.loss.dropped_by_mcu == line.host.loss.lost == device.dropped_rows == 7


def test_a_reboot_in_mid_grip_greets_again_and_never_moves_by_itself() -> None:
    line = Line()
    line.open()
    line.force_n = 5.0
    line.run(200)
    assert line.force_mn == 5000
    line.force_n = None
    line.reboot()
    start_us = line.now_us
    line.run(1500)
    assert line.told(Rebooted)[0].now == 2
    assert line.told(Identified)[-1].rebooted and line.host.session == 0xBEF0
    assert line.host.state is HostState.STREAM and line.device.state == DeviceState.ARMED
    assert all(drive.kind is DriveKind.PASSIVE for at_us, drive in line.drives if at_us > start_us)
    line.force_n = 2.0
    line.run(100)
    assert line.force_mn == 2000


def test_frames_of_another_session_are_stale_to_both() -> None:
    line = Line()
    line.open()
    stale = frame.encode(Header(Kind.GRIP, 40_000, 0x1234, to_host=False), Grip(99, 1, 0, 50, 9000, 0, 0).pack())
    line.device.receive(line.tick, stale)
    line.run(20)
    assert line.device.counters.stale == 1 and line.force_mn == 0
    line.host.receive(line.now_us, frame.encode(Header(Kind.STATUS, 40_000, 0x1234, to_host=True), bytes(24)))
    assert line.host.counters.stale == 1


def test_a_new_session_ends_the_old_one() -> None:
    line = Line()
    line.open(1)
    line.host.close()
    line.open(2)
    assert line.host.counters.stale == 0 and line.device.session == 2
    old = frame.encode(Header(Kind.GRIP, 50_000, 1, to_host=False), Grip(1, 1, 0, 50, 9000, 0, 0).pack())
    assert line.device.receive(line.tick, old) == []
    line.run(30)
    assert line.force_mn == 0


def test_an_echoing_line_is_counted_and_works() -> None:
    line = Line()
    line.to_host = lambda data: data
    sent: list[bytes] = []

    def echo_to_device(data: bytes) -> bytes:
        sent.append(data)
        return data

    line.to_device = echo_to_device
    line.to_host = lambda data: data + b"".join(sent) + (sent.clear() or b"")
    line.open()
    line.force_n = 1.0
    line.run(200)
    assert line.host.counters.echo > 100 and line.host.state is HostState.STREAM
    assert line.host.loss.lost == 0 and line.force_mn == 1000


def test_modem_commands_and_noise_are_garbage_only() -> None:
    rng = random.Random(4)
    line = Line()
    line.to_device = lambda data: b"AT+GCAP\r\nATZ\r" + data
    line.open()
    line.to_device = lambda data: rng.randbytes(rng.randrange(30)) + b"\0" + data
    line.to_host = lambda data: rng.randbytes(rng.randrange(30)) + data
    line.force_n = 3.0
    line.run(500)
    assert line.device.counters.garbage_bytes > 1000 and line.host.counters.garbage_bytes > 1000
    assert line.device.counters.gap == line.host.counters.gap == 0
    assert line.force_mn == 3000


def test_random_damage_never_makes_a_force_that_was_not_asked() -> None:
    rng = random.Random(5)

    def damage(data: bytes) -> bytes:
        if not data or rng.random() < 0.9:
            return data
        at, kind = rng.randrange(len(data)), rng.randrange(4)
        if kind == 0:
            return data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1 :]
        if kind == 1:
            return data[:at] + data[at + rng.randint(1, 8) :]
        if kind == 2:
            return data[:at] + rng.randbytes(4) + data[at:]
        return data + data[-64:]

    line = Line()
    line.open()
    line.to_device = line.to_host = damage
    start_us = line.now_us
    line.force_n = 2.0
    line.run(1500)
    assert 0 < line.most_mn_since(start_us) <= 2000
    assert line.device.counters.crc + line.device.counters.cobs + line.device.counters.length > 10
    assert line.device.rejected == 0


def test_the_clock_is_known_to_half_the_round_trip() -> None:
    line = Line()
    line.open()
    line.run(1500)
    clock = line.host.clock
    assert clock is not None and len(line.told(ClockUpdated)) >= 9 and clock.points >= 8
    at_us = clock.host_us(line.tick)
    assert at_us == pytest.approx(line.now_us, abs=clock.uncertainty_us + 1)
    assert clock.uncertainty_us <= Line.STEP_US


def test_log_and_events_arrive() -> None:
    line = Line()
    line.open()
    wire = line.device.log(line.tick, LogLevel.WARN, "low supply".encode())
    assert wire is not None
    events = line.host.receive(line.now_us, wire)
    assert [event.message for event in events if isinstance(event, Log)] == ["low supply"]
    kinds = {(event.kind, event.before, event.after) for event in line.told(Event)}
    assert (EventKind.STATE, DeviceState.LINKED, DeviceState.ARMED) in kinds


def test_stop_and_start() -> None:
    line = Line()
    line.open()
    line.host.stop(line.now_us)
    line.run(20)
    assert line.host.state is HostState.CONFIG and not line.device.sampling
    line.host.start(line.now_us)
    line.run(20)
    assert line.host.state is HostState.STREAM and line.host.loss.lost == 0


def test_another_configuration_on_the_way() -> None:
    line = Line()
    line.open()
    line.host.reconfigure(line.now_us, Config(sample_rate_hz=500, channel_mask=1, batch=1))
    line.run(50)
    assert line.host.in_force is not None and line.host.in_force.sample_rate_hz == 500
    assert line.host.layout.elements == 1 and line.host.state is HostState.STREAM
    with pytest.raises(ValueError):
        line.host.reconfigure(line.now_us, Config(force_max_mn=-1))


@pytest.mark.parametrize("role", [Role.HOST, Role.DEVICE])
def test_a_peer_of_another_version_is_told_and_left_alone(role: Role) -> None:
    line = Line()
    if role is Role.DEVICE:
        hello = frame.encode(Header(Kind.HELLO, 0, 9, False, True, 2), Hello(0, 2, 3).pack())
        assert line.device.receive(0, hello) == []
        answer = line.device.poll_transmit(0)
        assert answer is not None and kinds_in(answer) == [Kind.IDENT] and line.device.state == DeviceState.IDLE
    else:
        line.host.open(line.now_us, 9)
        while line.host.poll_transmit(line.now_us):
            pass
        events = line.host.receive(line.now_us, frame.encode(Header(Kind.IDENT, 0, 9, True, False, 2), b"\2\3"))
        assert [event.reason.code for event in events if isinstance(event, Closed)] == ["version_mismatch"]


def test_the_device_is_deaf_in_boot() -> None:
    device = DeviceLink(ident())
    hello = frame.encode(Header(Kind.HELLO, 0, 9, False, True), Hello(0).pack())
    assert device.receive(0, hello) == [] and device.poll_transmit(0) is None
    assert device.state == DeviceState.BOOT and device.counters.ok == 1
