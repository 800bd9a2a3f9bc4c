"""SUBSCRIBE, COMMAND, LOAD and SHADOW: what a client sends; OBJECT stands with the texts."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from ..wire import BadValue, PayloadError, ShortPayload, closed, pack, unpack
from .codes import Operation, Topics

_SUBSCRIBE = struct.Struct("<BBHHH")
_COMMAND = struct.Struct("<BBHiI")
_LOAD = struct.Struct("<32sIIB")
# Load has a field of that name.
_Bytes = bytes


@dataclass(frozen=True)
class Subscribe:
    """SUBSCRIBE (A8), 8 bytes: u8 lowest and highest version, u16 topics, u16 every n-th sample (0 = none), u16 least
    time between two STATE [ms]."""

    version_min: int = 1
    version_max: int = 1
    topics: Topics = Topics(15)
    every_nth: int = 0
    state_ms: int = 0

    @classmethod
    def parse(cls, payload: bytes) -> Subscribe:
        """Reads a payload; raises PayloadError."""
        low, high, topics, every_nth, state_ms = unpack(_SUBSCRIBE, payload)
        return cls(low, high, Topics(topics), every_nth, state_ms)

    def pack(self) -> bytes:
        """The payload; raises PayloadError."""
        return pack(_SUBSCRIBE, self.version_min, self.version_max, self.topics, self.every_nth, self.state_ms)


@dataclass(frozen=True)
class Command:
    """COMMAND (A9), 12 bytes: u8 operation, u8 reserved, u16 fault of CLEAR_FAULT, i32 force of AT_LEAST and EXPECT [mN], u32 token
    of RELEASE."""

    operation: Operation
    fault: int = 0
    force_mn: int = 0
    token: int = 0

    @classmethod
    def parse(cls, payload: bytes) -> Command:
        """Reads a payload; raises PayloadError, also for a negative force."""
        operation, _, fault, force_mn, token = unpack(_COMMAND, payload)
        wanted = closed(Operation, operation, 0)
        if force_mn < 0:
            raise BadValue(4, force_mn)
        return cls(wanted, fault, force_mn, token)

    def pack(self) -> bytes:
        """The payload; raises PayloadError."""
        return pack(_COMMAND, self.operation, 0, self.fault, self.force_mn, self.token)


@dataclass(frozen=True)
class Load:
    """LOAD (AB) and SHADOW (AD), 41 bytes and a piece: a part of a model file; size 0 stands for the model of the configuration, or for
    no shadow."""

    sha256: _Bytes
    size: int
    offset: int
    bytes: _Bytes

    @classmethod
    def parse(cls, payload: _Bytes) -> Load:
        """Reads a payload; raises PayloadError, also for a file of more than 1 MiB."""
        sha256, size, offset, length = unpack(_LOAD, payload)
        if size > 1 << 20:
            raise BadValue(32, size)
        end = _LOAD.size + length
        if len(payload) < end:
            raise ShortPayload(end, len(payload))
        return cls(sha256, size, offset, payload[_LOAD.size : end])

    def pack(self) -> _Bytes:
        """The payload; raises PayloadError."""
        if len(self.bytes) > 255:
            raise PayloadError(f"piece of {len(self.bytes)} bytes, at most 255 fit")
        return pack(_LOAD, self.sha256, self.size, self.offset, len(self.bytes)) + self.bytes
