"""WELCOME, NOTICE, SETUP and OBJECT: who the daemon is, what a client should know, what it works with and on."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from ..wire import PayloadError, ShortPayload, pack, unpack
from .codes import NoticeKind, RealTime, WelcomeFlags

_WELCOME = struct.Struct("<BBHIIIQBB")
_NOTICE = struct.Struct("<BBHIQB")
_SETUP = struct.Struct("<IBBH32s32sB")
_OBJECT = struct.Struct("<B")


def _text(layout: struct.Struct, payload: bytes, length: int) -> bytes:
    end = layout.size + length
    if len(payload) < end:
        raise ShortPayload(end, len(payload))
    return payload[layout.size : end]


def _length(text: bytes) -> int:
    if len(text) > 255:
        raise PayloadError(f"text of {len(text)} bytes, at most 255 fit")
    return len(text)


@dataclass(frozen=True)
class Welcome:
    """WELCOME (A0), 26 bytes and a text: the answer to SUBSCRIBE."""

    version_min: int
    version_max: int
    max_rx: int
    flags: WelcomeFlags
    token: int
    """What a RELEASE must bear; 0 where commands are not allowed."""
    run_id: int
    host_us: int
    real_time: RealTime
    text: bytes

    @property
    def daemon(self) -> str:
        """Name and version."""
        return self.text.decode("utf-8", "replace")

    @classmethod
    def parse(cls, payload: bytes) -> Welcome:
        """Reads a payload; raises PayloadError."""
        low, high, max_rx, flags, token, run_id, host_us, grant, length = unpack(_WELCOME, payload)
        text = _text(_WELCOME, payload, length)
        return cls(low, high, max_rx, WelcomeFlags(flags), token, run_id, host_us, RealTime(grant), text)

    def pack(self) -> bytes:
        """The payload; raises PayloadError."""
        head = (self.version_min, self.version_max, self.max_rx, self.flags, self.token, self.run_id, self.host_us)
        return pack(_WELCOME, *head, self.real_time, _length(self.text)) + self.text


@dataclass(frozen=True)
class Notice:
    """NOTICE (A6), 17 bytes and a text: drops, sensors, link, commands, the end."""

    kind: NoticeKind
    code: int
    value: int
    count: int
    host_us: int
    text: bytes

    @property
    def message(self) -> str:
        """The text."""
        return self.text.decode("utf-8", "replace")

    @classmethod
    def parse(cls, payload: bytes) -> Notice:
        """Reads a payload; raises PayloadError."""
        kind, code, value, count, host_us, length = unpack(_NOTICE, payload)
        return cls(NoticeKind(kind), code, value, count, host_us, _text(_NOTICE, payload, length))

    def pack(self) -> bytes:
        """The payload; raises PayloadError."""
        head = (self.kind, self.code, self.value, self.count, self.host_us)
        return pack(_NOTICE, *head, _length(self.text)) + self.text


@dataclass(frozen=True)
class Setup:
    """SETUP (A7), 73 bytes and a text: firmware of the gripper, SHA-256 of the models, name of the configured one."""

    settings: int
    """Reloads since the daemon's start."""
    fw_major: int
    fw_minor: int
    fw_patch: int
    in_force: bytes
    configured: bytes
    text: bytes

    @classmethod
    def parse(cls, payload: bytes) -> Setup:
        """Reads a payload; raises PayloadError."""
        settings, major, minor, patch, in_force, configured, length = unpack(_SETUP, payload)
        return cls(settings, major, minor, patch, in_force, configured, _text(_SETUP, payload, length))

    def pack(self) -> bytes:
        """The payload; raises PayloadError."""
        head = (self.settings, self.fw_major, self.fw_minor, self.fw_patch, self.in_force, self.configured)
        return pack(_SETUP, *head, _length(self.text)) + self.text


@dataclass(frozen=True)
class Object:
    """OBJECT (AC), 1 byte and a text: the name of the next object; empty for one without."""

    text: bytes

    @property
    def name(self) -> str:
        """The name."""
        return self.text.decode("utf-8", "replace")

    @classmethod
    def parse(cls, payload: bytes) -> Object:
        """Reads a payload; raises PayloadError."""
        (length,) = unpack(_OBJECT, payload)
        return cls(_text(_OBJECT, payload, length))

    def pack(self) -> bytes:
        """The payload; raises PayloadError."""
        return pack(_OBJECT, _length(self.text)) + self.text
