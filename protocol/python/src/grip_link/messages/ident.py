"""HELLO and IDENT: who is there, what it can do, and whether it is the same boot as before."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import Optional

from ..frame import PROTOCOL
from .codes import ChannelKind, DeviceState, FaultCode, Kind, ResetReason, SampleFormat, Unit
from .wire import MESSAGES, BadValue, PayloadError, pack, unpack

MAX_CHANNELS = 16

_HELLO = struct.Struct("<BBHIQ")
_VERSIONS = struct.Struct("<BB")
_IDENT = struct.Struct("<BBHI16sIIIiIiiiBBHBBHB")
_TABLE = struct.Struct("<BH4x")
_CHANNEL = struct.Struct("<BBBBf")
_TABLE_AT = 72

_UNITS = {
    ChannelKind.STYLUS: Unit.METRE,
    ChannelKind.NORMAL_FORCE: Unit.NEWTON,
    ChannelKind.TANGENTIAL_FORCE: Unit.NEWTON,
    ChannelKind.TRAVEL: Unit.METRE,
    ChannelKind.VELOCITY: Unit.METRE_PER_SECOND,
    ChannelKind.SECOND_STYLUS: Unit.METRE,
    ChannelKind.REFERENCE: Unit.METRE_PER_SECOND2,
    ChannelKind.PRESSURE: Unit.PASCAL,
    ChannelKind.PRESSURE_ARRAY: Unit.PASCAL,
}


def parse_versions(payload: bytes) -> tuple[int, int]:
    """Lowest and highest version: the first two bytes of a HELLO or IDENT of any version."""
    low, high = unpack(_VERSIONS, payload)
    return low, high


def common_version(low: int, high: int) -> Optional[int]:
    """Highest version of low..high that this package speaks."""
    best = min(PROTOCOL, high)
    return best if best >= PROTOCOL and best >= low else None


@dataclass(frozen=True)
class Hello:
    """HELLO (01), host to MCU, 16 bytes: u8 lowest and u8 highest version, u16 longest payload the host takes,
    u32 capabilities (0), u64 host time [us]. The header carries the new session, 1..65535."""

    time_us: int
    version_min: int = PROTOCOL
    version_max: int = PROTOCOL
    max_rx: int = 480
    caps: int = 0

    @classmethod
    def parse(cls, payload: bytes) -> Hello:
        """Reads a payload; raises PayloadError."""
        low, high, max_rx, caps, time_us = unpack(_HELLO, payload)
        return cls(time_us, low, high, max_rx, caps)

    def pack(self) -> bytes:
        """The 16 payload bytes."""
        return pack(_HELLO, self.version_min, self.version_max, self.max_rx, self.caps, self.time_us)


@dataclass(frozen=True)
class Limits:
    """What the hardware allows; CONFIG is clamped to it."""

    rate_max_hz: int
    force_max_mn: int
    slew_max_mn_s: int
    hold_cap_mn: int
    travel_min_um: int = 0
    travel_max_um: int = 0


@dataclass(frozen=True)
class Channel:
    """One channel of IDENT, 8 bytes: u8 kind, u8 unit, u8 formats (b0 i16, b1 f32), u8 count, f32 scale."""

    kind: ChannelKind
    unit: Unit
    formats: int
    count: int
    """Elements a row, 1..64; 1 except for an array."""
    scale: float
    """Unit per i16 step, finite and > 0."""

    @classmethod
    def single(cls, kind: ChannelKind, scale: float) -> Channel:
        """A channel of one element in its own SI unit that can be sent in both formats."""
        return cls(kind, _UNITS.get(kind, Unit.NONE), 3, 1, scale)

    def offers(self, sample_format: SampleFormat) -> bool:
        """Whether it can be sent in this format."""
        return bool(self.formats >> sample_format & 1)

    @classmethod
    def parse(cls, payload: bytes, at: int) -> Channel:
        """Reads the entry at offset ``at``; raises PayloadError."""
        kind, unit, formats, count, scale = unpack(_CHANNEL, payload, at)
        channel = cls(ChannelKind(kind), Unit(unit), formats, count, scale)
        if not 1 <= count <= 64:
            raise BadValue(at + 3, count)
        if not (math.isfinite(scale) and scale > 0.0):
            raise BadValue(at + 4, scale)
        return channel

    def pack(self) -> bytes:
        """The 8 bytes."""
        return pack(_CHANNEL, self.kind, self.unit, self.formats, self.count, self.scale)


@dataclass(frozen=True)
class Ident:
    """IDENT (81), MCU to host, 72 bytes and 8 a channel: the answer to HELLO. With session 0: "I know no session".

    u8 lowest and u8 highest version, u16 longest payload the MCU takes, u32 capabilities, u8[16] uid, u32 boot_id,
    u32 tick_hz, the six limits as 32-bit numbers, u8 u8 u16 firmware, u8 reset reason, u8 state, u16 fault,
    u8 channels, u8 bytes a channel entry, u16 offset of the channel table, u32 reserved, the table."""

    uid: bytes
    boot_id: int
    tick_hz: int
    limits: Limits
    channels: tuple[Channel, ...]
    firmware: tuple[int, int, int] = (0, 0, 0)
    reset: ResetReason = ResetReason.UNKNOWN
    state: DeviceState = DeviceState.BOOT
    fault: FaultCode = FaultCode.NONE
    version_min: int = PROTOCOL
    version_max: int = PROTOCOL
    max_rx: int = 480
    caps: int = 0

    @property
    def shows_slips(self) -> bool:
        """Whether a channel shows slips: a stylus, a travel or an array of taxels."""
        kinds = {channel.kind for channel in self.channels}
        return not kinds.isdisjoint({ChannelKind.STYLUS, ChannelKind.TRAVEL, ChannelKind.PRESSURE_ARRAY})

    def available(self, sample_format: SampleFormat) -> int:
        """Mask of the channels that can be sent in a format."""
        return sum(1 << bit for bit, channel in enumerate(self.channels) if channel.offers(sample_format))

    @classmethod
    def parse(cls, payload: bytes) -> Ident:
        """Reads a payload; raises PayloadError."""
        values = unpack(_IDENT, payload)
        low, high, max_rx, caps, uid, boot_id, tick_hz = values[:7]
        count = values[19]
        if count > MAX_CHANNELS:
            raise BadValue(64, count)
        if tick_hz < 1000:
            raise BadValue(28, tick_hz)
        stride, table = unpack(_TABLE, payload, 65)
        if stride < _CHANNEL.size:
            raise BadValue(65, stride)
        channels = tuple(Channel.parse(payload, table + stride * index) for index in range(count))
        reset, state, fault = ResetReason(values[16]), DeviceState(values[17]), FaultCode(values[18])
        return cls(
            uid, boot_id, tick_hz, Limits(*values[7:13]), channels, (values[13], values[14], values[15]), reset, state,
            fault, low, high, max_rx, caps,
        )  # fmt: skip

    def pack(self) -> bytes:
        """The payload; raises PayloadError for more than 16 channels or a uid that is not 16 bytes long."""
        if len(self.channels) > MAX_CHANNELS or len(self.uid) != 16:
            raise PayloadError(f"{len(self.channels)} channels, uid of {len(self.uid)} bytes")
        limits = self.limits
        head = pack(
            _IDENT, self.version_min, self.version_max, self.max_rx, self.caps, self.uid, self.boot_id, self.tick_hz,
            limits.rate_max_hz, limits.force_max_mn, limits.slew_max_mn_s, limits.hold_cap_mn, limits.travel_min_um,
            limits.travel_max_um, *self.firmware, self.reset, self.state, self.fault, len(self.channels),
        )  # fmt: skip
        table = pack(_TABLE, _CHANNEL.size, _TABLE_AT)
        return head + table + b"".join(channel.pack() for channel in self.channels)


MESSAGES.update({Kind.HELLO: Hello, Kind.IDENT: Ident})
