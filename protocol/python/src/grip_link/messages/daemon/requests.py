"""SUBSCRIBE, COMMAND, LOAD and SHADOW: what a client sends; OBJECT stands with the texts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from ..codes import Kind
from ..wire import MESSAGES, Message
from .codes import Operation, Topics

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
