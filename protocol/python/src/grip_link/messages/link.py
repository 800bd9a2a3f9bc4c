"""The messages of the link that have fields only: configuration, force, faults, clocks and what the microcontroller has to tell."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import ClassVar

from ..crc import crc32c
from .codes import Clamped, DeviceState, EventKind, FaultCode, ForceClamp, Kind, LogLevel, LossAction, NackReason, SampleFormat, StatusFlags
from .wire import MESSAGES, BadValue, Message, ShortPayload, pack, unpack

TTL_MIN_MS = 20
TTL_MAX_MS = 100
ANSWERS_SLIP = 1


@dataclass(frozen=True)
class Config(Message, kind=Kind.CONFIG, layout="IBBHIiIiHBx"):
    """CONFIG (03), host to MCU: the sampling and the limits wanted, which the microcontroller clamps to its own."""

    RANGES: ClassVar = {
        "sample_rate_hz": (1, math.inf), "batch": (1, 255), "force_max_mn": (0, math.inf), "slew_mn_s": (1, math.inf), "hold_cap_mn": (0, math.inf),
    }  # fmt: skip
    sample_rate_hz: int = 1000
    """Samples a second, >= 1."""
    batch: int = 10
    """Rows a batch, 1..255; a batch also ends after 1 ms."""
    format: SampleFormat = SampleFormat.I16
    ttl_ms: int = 50
    """Life of a GRIP [ms], 20..100."""
    channel_mask: int = 0xFFFF
    """Channels to send; bit 0 is the first channel of IDENT."""
    force_max_mn: int = 10_000
    """Largest force [mN], >= 0."""
    slew_mn_s: int = 100_000
    """Fastest change of force [mN/s], >= 1."""
    hold_cap_mn: int = 10_000
    """Largest force held without commands [mN], >= 0."""
    loss_after_ms: int = 1000
    """Time in HOLD before the loss action [ms], 100..60000."""
    loss_action: LossAction = LossAction.HOLD

    def changed(self, given: Config) -> Clamped:
        """Which fields ``given`` has changed."""
        names = ("sample_rate_hz", "batch", "channel_mask", "force_max_mn", "slew_mn_s", "ttl_ms", "hold_cap_mn", "loss_after_ms")
        return Clamped(sum(1 << bit for bit, name in enumerate(names) if getattr(self, name) != getattr(given, name)))


_ACK = struct.Struct("<IHBx")


@dataclass(frozen=True)
class ConfigAck:
    """CONFIG_ACK (83), MCU to host, 36 bytes: u32 CRC-32C of bytes 8..36, u16 seq of the CONFIG, u8 clamped fields,
    u8 reserved, the CONFIG in force."""

    request_seq: int
    clamped: Clamped
    config: Config

    @classmethod
    def parse(cls, payload: bytes) -> ConfigAck:
        """Reads a payload and checks its CRC; raises PayloadError."""
        crc, seq, clamped = unpack(_ACK, payload)
        if len(payload) < 36:
            raise ShortPayload(36, len(payload))
        if crc32c(payload[8:36]) != crc:
            raise BadValue(0, crc)
        return cls(seq, Clamped(clamped), Config.parse(payload[8:36]))

    def pack(self) -> bytes:
        """The 36 payload bytes."""
        config = self.config.pack()
        return pack(_ACK, crc32c(config), self.request_seq, self.clamped) + config


MESSAGES[Kind.CONFIG_ACK] = ConfigAck


@dataclass(frozen=True)
class Ping(Message, kind=Kind.PING, layout="Q"):
    """PING (06), host to MCU: host time of sending, which the MCU only echoes."""

    t1_us: int


@dataclass(frozen=True)
class Pong(Message, kind=Kind.PONG, layout="QQQ"):
    """PONG (86), MCU to host: t1 of the PING, tick of receiving it, tick of writing this."""

    t1_us: int
    rx_tick: int
    tx_tick: int


@dataclass(frozen=True)
class Heartbeat(Message, kind=Kind.HEARTBEAT, layout="IIHH"):
    """HEARTBEAT (11), host to MCU: for the log; it does not refresh a GRIP. Turns of the hot loop, longest turn and late turns since the last
    HEARTBEAT, flags (b0 degraded)."""

    turns: int
    longest_us: int
    late: int
    flags: int


@dataclass(frozen=True)
class ClearFault(Message, kind=Kind.CLEAR_FAULT, layout="H"):
    """CLEAR_FAULT (13), host to MCU: the fault to clear, which must be the latched one."""

    fault: FaultCode


@dataclass(frozen=True)
class Ack(Message, kind=Kind.ACK, layout="BxH"):
    """ACK (8E), MCU to host: type of the request, its seq."""

    kind: Kind
    request_seq: int


@dataclass(frozen=True)
class Nack(Message, kind=Kind.NACK, layout="BBH"):
    """NACK (8F), MCU to host: type of the request, reason, its seq."""

    kind: Kind
    reason: NackReason
    request_seq: int


@dataclass(frozen=True)
class Grip(Message, kind=Kind.GRIP, layout="IBBHiII"):
    """GRIP (10), host to MCU: an absolute set point, sent every cycle. ``mode`` is the bare number: the MCU judges it."""

    cmd_id: int
    mode: int
    flags: int
    """b0 answers a slip."""
    ttl_ms: int
    force_mn: int
    slew_mn_s: int
    cause_sample: int
    """Number of the sample that caused it."""


@dataclass(frozen=True)
class Status(Message, kind=Kind.STATUS, layout="IBBHiiIHH"):
    """STATUS (91), MCU to host: at least every 10 ms and after every GRIP."""

    last_cmd_id: int
    state: DeviceState
    clamp: ForceClamp
    fault: FaultCode
    applied_mn: int
    """Force set at the actuator now, or measured where the gripper can [mN]."""
    target_mn: int
    """Force aimed at [mN]."""
    age_us: int
    """Age of the newest accepted GRIP [us], saturating."""
    flags: StatusFlags
    rejected: int
    """GRIPs rejected since the start, wrapping."""


@dataclass(frozen=True)
class Stats(Message, kind=Kind.STATS, layout=19 * "I"):
    """STATS (92), MCU to host, every second: counts since the MCU started, saturating. The first twelve are those of its decoder."""

    ok: int
    too_long: int
    cobs: int
    length: int
    crc: int
    echo: int
    version: int
    stale: int
    duplicate: int
    unknown: int
    gap: int
    garbage_bytes: int
    sent: int
    dropped_batches: int
    dropped_rows: int
    malformed: int
    old: int
    """GRIPs not newer than the newest one: ignored."""
    refused: int
    """Requests that could not be carried out: latched, wrong state, no channel left or another fault."""
    unanswered: int
    """Answers dropped because eight newer ones waited."""


@dataclass(frozen=True)
class Event(Message, kind=Kind.EVENT, layout="QBBBxHHi"):
    """EVENT (93), MCU to host; the value goes by the kind (the force of a rejected GRIP [mN], the code of a fault)."""

    tick: int
    kind: EventKind
    before: DeviceState
    after: DeviceState
    fault: FaultCode
    dropped: int
    value: int


@dataclass(frozen=True)
class Log(Message, kind=Kind.LOG, layout="QBt"):
    """LOG (94), MCU to host: a text in UTF-8 of at most 255 bytes."""

    tick: int
    level: LogLevel
    text: bytes

    @property
    def message(self) -> str:
        """The text; bytes that are no UTF-8 are shown as replacement characters."""
        return self.text.decode("utf-8", "replace")
