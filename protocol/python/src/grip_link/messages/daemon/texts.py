"""WELCOME, NOTICE, SETUP and OBJECT: who the daemon is, what a client should know, what it works with and on."""

from __future__ import annotations

from dataclasses import dataclass

from ..codes import Kind
from ..wire import Message
from .codes import NoticeKind, RealTime, WelcomeFlags


@dataclass(frozen=True)
class Welcome(Message, kind=Kind.WELCOME, layout="BBHIIIQBt"):
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


@dataclass(frozen=True)
class Notice(Message, kind=Kind.NOTICE, layout="BBHIQt"):
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


@dataclass(frozen=True)
class Setup(Message, kind=Kind.SETUP, layout="IBBH32s32st"):
    """SETUP (A7), 73 bytes and a text: firmware of the gripper, SHA-256 of the models, name of the configured one."""

    settings: int
    """Reloads since the daemon's start."""
    fw_major: int
    fw_minor: int
    fw_patch: int
    in_force: bytes
    configured: bytes
    text: bytes


@dataclass(frozen=True)
class Object(Message, kind=Kind.OBJECT, layout="t"):
    """OBJECT (AC), 1 byte and a text: the name of the next object; empty for one without."""

    text: bytes

    @property
    def name(self) -> str:
        """The name."""
        return self.text.decode("utf-8", "replace")
