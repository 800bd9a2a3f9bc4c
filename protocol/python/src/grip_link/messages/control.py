"""The short messages: PING, PONG, HEARTBEAT, CLEAR_FAULT, ACK, NACK."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from .codes import FaultCode, Kind, NackReason
from .wire import pack, unpack

_PING = struct.Struct("<Q")
_PONG = struct.Struct("<QQQ")
_HEARTBEAT = struct.Struct("<IIHH")
_CLEAR = struct.Struct("<H")
_ACK = struct.Struct("<BxH")
_NACK = struct.Struct("<BBH")


@dataclass(frozen=True)
class Ping:
    """PING (06), host to MCU: u64 host time of sending [us], which the MCU only echoes."""

    t1_us: int

    @classmethod
    def parse(cls, payload: bytes) -> Ping:
        """Reads a payload; raises PayloadError."""
        return cls(*unpack(_PING, payload))

    def pack(self) -> bytes:
        """The 8 payload bytes."""
        return pack(_PING, self.t1_us)


@dataclass(frozen=True)
class Pong:
    """PONG (86), MCU to host: u64 t1 of the PING [us], u64 tick of receiving it, u64 tick of writing this."""

    t1_us: int
    rx_tick: int
    tx_tick: int

    @classmethod
    def parse(cls, payload: bytes) -> Pong:
        """Reads a payload; raises PayloadError."""
        return cls(*unpack(_PONG, payload))

    def pack(self) -> bytes:
        """The 24 payload bytes."""
        return pack(_PONG, self.t1_us, self.rx_tick, self.tx_tick)


@dataclass(frozen=True)
class Heartbeat:
    """HEARTBEAT (11), host to MCU: for the log; it does not refresh a GRIP. u32 turns of the hot loop, u32 longest
    turn [us] and u16 late turns since the last HEARTBEAT, u16 flags (b0 degraded)."""

    turns: int
    longest_us: int
    late: int
    flags: int

    @classmethod
    def parse(cls, payload: bytes) -> Heartbeat:
        """Reads a payload; raises PayloadError."""
        return cls(*unpack(_HEARTBEAT, payload))

    def pack(self) -> bytes:
        """The 12 payload bytes."""
        return pack(_HEARTBEAT, self.turns, self.longest_us, self.late, self.flags)


@dataclass(frozen=True)
class ClearFault:
    """CLEAR_FAULT (13), host to MCU: u16 fault to clear, which must be the latched one."""

    fault: FaultCode

    @classmethod
    def parse(cls, payload: bytes) -> ClearFault:
        """Reads a payload; raises PayloadError."""
        return cls(FaultCode(unpack(_CLEAR, payload)[0]))

    def pack(self) -> bytes:
        """The 2 payload bytes."""
        return pack(_CLEAR, self.fault)


@dataclass(frozen=True)
class Ack:
    """ACK (8E), MCU to host: u8 type of the request, u8 reserved, u16 its seq."""

    kind: Kind
    request_seq: int

    @classmethod
    def parse(cls, payload: bytes) -> Ack:
        """Reads a payload; raises PayloadError."""
        kind, seq = unpack(_ACK, payload)
        return cls(Kind(kind), seq)

    def pack(self) -> bytes:
        """The 4 payload bytes."""
        return pack(_ACK, self.kind, self.request_seq)


@dataclass(frozen=True)
class Nack:
    """NACK (8F), MCU to host: u8 type of the request, u8 reason, u16 its seq."""

    kind: Kind
    reason: NackReason
    request_seq: int

    @classmethod
    def parse(cls, payload: bytes) -> Nack:
        """Reads a payload; raises PayloadError."""
        kind, reason, seq = unpack(_NACK, payload)
        return cls(Kind(kind), NackReason(reason), seq)

    def pack(self) -> bytes:
        """The 4 payload bytes."""
        return pack(_NACK, self.kind, self.reason, self.request_seq)
