"""What a client sends (SUBSCRIBE, COMMAND, LOAD, SHADOW, OBJECT), who the daemon is, and what a client should know (WELCOME, NOTICE, SETUP)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from ..codes import Kind
from ..wire import MESSAGES, Message
from .codes import NoticeKind, Operation, RealTime, Topics, WelcomeFlags

# Load has a field of that name.
_Bytes = bytes


@dataclass(frozen=True)
class Subscribe(Message, kind=Kind.SUBSCRIBE, layout="BBHHH"):
    """SUBSCRIBE (A8), 8 bytes: u8 lowest and highest version, u16 topics, u16 every n-th sample (0 = none), u16 least
    time between two STATE [ms]."""

    version_min: int = 1
    version_max: int = 1
    topics: Topics = Topics(15)
    every_nth: int = 0
    state_ms: int = 0


@dataclass(frozen=True)
class Command(Message, kind=Kind.COMMAND, layout="BxHiI"):
    """COMMAND (A9), 12 bytes: u8 operation, u8 reserved, u16 fault of CLEAR_FAULT, i32 force of AT_LEAST and EXPECT [mN], u32 token
    of RELEASE."""

    RANGES: ClassVar = {"force_mn": (0, math.inf)}
    operation: Operation
    fault: int = 0
    force_mn: int = 0
    token: int = 0


@dataclass(frozen=True)
class Load(Message, kind=Kind.LOAD, layout="32sIIt"):
    """LOAD (AB) and SHADOW (AD), 41 bytes and a piece: a part of a model file; size 0 stands for the model of the configuration, or for
    no shadow."""

    RANGES: ClassVar = {"size": (0, 1 << 20)}
    sha256: _Bytes
    size: int
    offset: int
    bytes: _Bytes


MESSAGES[Kind.SHADOW] = Load


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
