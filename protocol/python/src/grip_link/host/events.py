"""What a host's link can tell and be told: states, events, commands, reasons of an end."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import Union

from ..clock import PongVerdict
from ..messages import Clamped, Config, Event, GripMode, Ident, Kind, Log, Nack, Samples, Stats, Status
from .loss import Loss


class HostState(Enum):
    """State of the host's side."""

    CLOSED = "closed"
    OPEN = "open"
    """Port open, nothing written yet."""
    HELLO = "hello"
    """Asking who is there."""
    CONFIG = "config"
    """Gripper known; limits and sampling not agreed, or sampling stopped."""
    STREAM = "stream"
    DEGRADED = "degraded"
    """Samples are stale or have a gap: force is not raised."""


@dataclass(frozen=True)
class HostConfig:
    """What a host wants of the link."""

    config: Config = field(default_factory=Config)
    stale_us: int = 5_000
    """No samples for longer: DEGRADED. Three sample periods count if that is longer."""
    lost_us: int = 1_000_000
    """No frame for longer: CLOSED."""
    hello_for_us: int = 3_000_000
    """HELLO is repeated this long."""

    def check(self) -> None:
        """Raises ValueError for times that cannot be, PayloadError for a CONFIG that no device takes."""
        if not (0 < self.stale_us < self.lost_us and self.hello_for_us > 0):
            raise ValueError(
                f"stale after {self.stale_us} us, lost after {self.lost_us} us, HELLO for {self.hello_for_us} us"
            )
        Config.parse(self.config.pack())


@dataclass(frozen=True)
class GripCommand:
    """A force command of a controller."""

    force_mn: int
    """Force [mN], >= 0; above F_max it is clamped."""
    mode: GripMode = GripMode.FORCE
    answers_slip: bool = False
    ttl_ms: int = 0
    """Life [ms], 0 = that of CONFIG."""
    slew_mn_s: int = 0
    """Change of force [mN/s], 0 = that of CONFIG."""
    cause_sample: int = 0

    @classmethod
    def newtons(cls, force_n: float, *, answers_slip: bool = False, cause_sample: int = 0) -> GripCommand:
        """A force in newtons, rounded to mN; raises ValueError for NaN, a negative force or one over 2.1 MN."""
        if not (force_n >= 0.0 and force_n * 1000.0 <= 0x7FFFFFFF):
            raise ValueError(f"force {force_n} N: expected 0 or more, at most 2.1e6")
        force_mn = math.floor(force_n * 1000.0 + 0.5)
        return cls(force_mn, answers_slip=answers_slip, cause_sample=cause_sample)


@dataclass(frozen=True)
class CloseReason:
    """Why the link closed. Codes: requested, no_answer, version_mismatch, no_stylus, bad_ident, unanswered, refused,
    lost, port."""

    code: str
    detail: str

    def __str__(self) -> str:
        return f"{self.code}: {self.detail}"


@dataclass(frozen=True)
class StateChanged:
    """The host's state changed."""

    before: HostState
    after: HostState


@dataclass(frozen=True)
class Identified:
    """A gripper answered; ``rebooted``: it is another boot or gripper than in the session before."""

    ident: Ident
    rebooted: bool


@dataclass(frozen=True)
class Rebooted:
    """The gripper started anew in the middle of a session; HELLO goes out again by itself."""

    before: int
    now: int


@dataclass(frozen=True)
class Configured:
    """CONFIG is in force; ``clamped`` names the fields the gripper changed."""

    config: Config
    clamped: Clamped


@dataclass(frozen=True)
class Batch:
    """A batch of samples and what is missing before it."""

    samples: Samples
    loss: Loss


@dataclass(frozen=True)
class ClockUpdated:
    """A PONG went to the clock estimate."""

    verdict: PongVerdict


@dataclass(frozen=True)
class Done:
    """A request was carried out."""

    kind: Kind


@dataclass(frozen=True)
class Refused:
    """A request was refused; the link goes on."""

    nack: Nack


@dataclass(frozen=True)
class Closed:
    """The link closed."""

    reason: CloseReason


HostEvent = Union[
    StateChanged, Identified, Rebooted, Configured, Batch, Status, Stats, Event, Log, ClockUpdated, Done, Refused, Closed
]
