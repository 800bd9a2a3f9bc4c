"""STATS, EVENT and LOG: what the microcontroller has to tell."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from .codes import DeviceState, EventKind, FaultCode, LogLevel
from .wire import PayloadError, ShortPayload, pack, unpack

_STATS = struct.Struct("<19I")
_EVENT = struct.Struct("<QBBBxHHi")
_LOG = struct.Struct("<QBB")


@dataclass(frozen=True)
class Stats:
    """STATS (92), MCU to host, every second: 19 u32 counts since the MCU started, saturating. The first twelve are
    those of its decoder."""

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

    @classmethod
    def parse(cls, payload: bytes) -> Stats:
        """Reads a payload; raises PayloadError."""
        return cls(*unpack(_STATS, payload))

    def pack(self) -> bytes:
        """The 76 payload bytes."""
        return pack(
            _STATS, self.ok, self.too_long, self.cobs, self.length, self.crc, self.echo, self.version, self.stale,
            self.duplicate, self.unknown, self.gap, self.garbage_bytes, self.sent, self.dropped_batches,
            self.dropped_rows, self.malformed, self.old, self.refused, self.unanswered,
        )  # fmt: skip


@dataclass(frozen=True)
class Event:
    """EVENT (93), MCU to host, 20 bytes: u64 tick, u8 kind, u8 state before, u8 state after, u8 reserved, u16 fault,
    u16 events dropped, i32 value by kind (the force of a rejected GRIP [mN], the code of a fault)."""

    tick: int
    kind: EventKind
    before: DeviceState
    after: DeviceState
    fault: FaultCode
    dropped: int
    value: int

    @classmethod
    def parse(cls, payload: bytes) -> Event:
        """Reads a payload; raises PayloadError."""
        tick, kind, before, after, fault, dropped, value = unpack(_EVENT, payload)
        return cls(tick, EventKind(kind), DeviceState(before), DeviceState(after), FaultCode(fault), dropped, value)

    def pack(self) -> bytes:
        """The 20 payload bytes."""
        return pack(_EVENT, self.tick, self.kind, self.before, self.after, self.fault, self.dropped, self.value)


@dataclass(frozen=True)
class Log:
    """LOG (94), MCU to host: u64 tick, u8 level, u8 bytes of text, text in UTF-8 (0..255 bytes)."""

    tick: int
    level: LogLevel
    text: bytes

    @property
    def message(self) -> str:
        """The text; bytes that are no UTF-8 are shown as replacement characters."""
        return self.text.decode("utf-8", "replace")

    @classmethod
    def parse(cls, payload: bytes) -> Log:
        """Reads a payload; raises PayloadError."""
        tick, level, length = unpack(_LOG, payload)
        end = _LOG.size + length
        if len(payload) < end:
            raise ShortPayload(end, len(payload))
        return cls(tick, LogLevel(level), payload[_LOG.size : end])

    def pack(self) -> bytes:
        """The payload; raises PayloadError for a text over 255 bytes."""
        if len(self.text) > 255:
            raise PayloadError(f"text of {len(self.text)} bytes, at most 255 fit")
        return pack(_LOG, self.tick, self.level, len(self.text)) + self.text
