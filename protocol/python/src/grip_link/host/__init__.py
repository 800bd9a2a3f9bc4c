"""The computer's side of the link, without IO and clock."""

from __future__ import annotations

from .events import (
    Batch,
    ClockUpdated,
    Closed,
    CloseReason,
    Configured,
    Done,
    GripCommand,
    HostConfig,
    HostEvent,
    HostState,
    Identified,
    Rebooted,
    Refused,
    StateChanged,
)
from .link import HostLink
from .loss import Loss, LossCount

__all__ = [
    "Batch", "ClockUpdated", "CloseReason", "Closed", "Configured", "Done", "GripCommand", "HostConfig", "HostEvent",
    "HostLink", "HostState", "Identified", "Loss", "LossCount", "Rebooted", "Refused", "StateChanged",
]  # fmt: skip
