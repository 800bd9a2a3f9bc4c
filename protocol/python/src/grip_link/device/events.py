"""What a device's link can tell its firmware, and what it refuses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Union

from ..frame import MAX_PAYLOAD
from ..messages import Config, FaultCode, Grip, Heartbeat, Ident, Layout, SampleFormat
from ..messages.samples import HEADER as SAMPLES_HEADER


@dataclass(frozen=True)
class Linked:
    """A host opened this session."""

    session: int


@dataclass(frozen=True)
class Configured:
    """CONFIG was accepted, perhaps clamped."""

    config: Config


@dataclass(frozen=True)
class Started:
    """Rows are wanted."""


@dataclass(frozen=True)
class Stopped:
    """Rows are no longer wanted."""


@dataclass(frozen=True)
class Command:
    """A GRIP was accepted."""

    grip: Grip


@dataclass(frozen=True)
class Rejected:
    """A GRIP was rejected."""

    grip: Grip


@dataclass(frozen=True)
class Estopped:
    """ESTOP was latched."""


@dataclass(frozen=True)
class Cleared:
    """A fault was cleared."""

    fault: FaultCode


DeviceEvent = Union[Linked, Configured, Started, Stopped, Command, Rejected, Heartbeat, Estopped, Cleared]


class RowError(ValueError):
    """A row that is not wanted; ``reason`` is "not sampling", "format", "elements" or "value"."""

    def __init__(self, reason: str, detail: str) -> None:
        super().__init__(f"{reason}: {detail}")
        self.reason = reason


def check_ident(ident: Ident) -> None:
    """Raises ValueError for what a host does not take, or what no row can be of."""
    limits = ident.limits
    if not (limits.rate_max_hz > 0 and limits.slew_max_mn_s > 0 and 0 <= limits.hold_cap_mn <= limits.force_max_mn):
        raise ValueError(f"{limits}: expected a rate and a slew of more than 0, and a hold cap of at most the largest force")
    if not ident.shows_slips:
        raise ValueError(f"none of the {len(ident.channels)} channels shows a slip")
    Ident.parse(ident.pack())
    row = Layout(ident.channels, 0xFFFF).row_bytes(SampleFormat.F32)
    if row > MAX_PAYLOAD - SAMPLES_HEADER.size:
        raise ValueError(f"a row of {row} bytes does not fit a frame")
