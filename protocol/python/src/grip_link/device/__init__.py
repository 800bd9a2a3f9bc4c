"""The microcontroller's side of the link, without IO and clock."""

from __future__ import annotations

from .batches import KEPT_BATCHES
from .events import (
    Cleared,
    Command,
    Configured,
    DeviceEvent,
    Estopped,
    Linked,
    Rejected,
    RowError,
    Started,
    Stopped,
)
from .force import Drive, DriveKind
from .link import DeviceLink

__all__ = [
    "KEPT_BATCHES", "Cleared", "Command", "Configured", "DeviceEvent", "DeviceLink", "Drive", "DriveKind", "Estopped",
    "Linked", "Rejected", "RowError", "Started", "Stopped",
]  # fmt: skip
