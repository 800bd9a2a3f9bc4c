"""Payloads between a daemon and its clients in, typed messages out, and back. ``protocol/CLIENTS.md``."""

from __future__ import annotations

from .codes import (
    Causes,
    DroppedClass,
    EscKind,
    Goodbye,
    GripStage,
    LinkState,
    Method,
    NoticeKind,
    Operation,
    Phase,
    RealTime,
    Recording,
    RowSet,
    Scene,
    Sensor,
    SensorHealth,
    SpeedSource,
    Topics,
    Unsure,
    WelcomeFlags,
)
from .reports import Estimates, Gripper, Health, Slip, State
from .requests import Command, Load, Notice, Object, Setup, Subscribe, Welcome
from .rows import Row, Rows

__all__ = [
    "Causes", "Command", "DroppedClass", "EscKind", "Estimates", "Goodbye", "GripStage", "Gripper", "Health", "LinkState", "Load",
    "Method", "Notice", "NoticeKind", "Object", "Operation", "Phase", "RealTime", "Recording", "Row", "RowSet", "Rows", "Scene",
    "Sensor", "SensorHealth", "Setup", "Slip", "SpeedSource", "State", "Subscribe", "Topics", "Unsure", "Welcome",
    "WelcomeFlags",
]  # fmt: skip
