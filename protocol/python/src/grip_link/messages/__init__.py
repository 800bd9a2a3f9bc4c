"""Payload bytes in, typed messages out, and back; every offset is fixed and little-endian.

Payloads grow only by appending: a reader takes the bytes it knows and ignores what follows.
"""

from __future__ import annotations

from .codes import (
    ChannelKind,
    Clamped,
    DeviceState,
    EventKind,
    FaultCode,
    ForceClamp,
    GripMode,
    Kind,
    LogLevel,
    LossAction,
    NackReason,
    ResetReason,
    SampleFormat,
    StatusFlags,
    Unit,
)
from .ident import Channel, Hello, Ident, Limits
from .link import Ack, ClearFault, Config, ConfigAck, Event, Grip, Heartbeat, Log, Nack, Ping, Pong, Stats, Status
from .samples import Column, Layout, Samples, pack_rows
from .wire import MESSAGES, BadValue, PayloadError, ShortPayload

__all__ = [
    "Ack", "BadValue", "Channel", "ChannelKind", "Clamped", "ClearFault", "Column", "Config", "ConfigAck",
    "DeviceState", "Event", "EventKind", "FaultCode", "ForceClamp", "Grip", "GripMode", "Heartbeat", "Hello", "Ident",
    "Kind", "Layout", "Limits", "Log", "LogLevel", "LossAction", "MESSAGES", "Nack", "NackReason", "PayloadError", "Ping", "Pong",
    "ResetReason", "SampleFormat", "Samples", "ShortPayload", "Stats", "Status", "StatusFlags", "Unit", "pack_rows",
]  # fmt: skip
