"""GRIP commands and ticks in, the force for the actuator out: rules R1 to R5 of the failsafe.

Force rises only while a command is fresh (age <= ttl). Then it stays, falling to the hold cap where it is above;
after the loss delay the configured loss action follows. All changes of force keep the slew.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Optional

from ..messages import Config, ForceClamp, Grip, GripMode, Limits, LossAction
from ..messages.link import TTL_MAX_MS, TTL_MIN_MS

LONGEST_STEP_MS = 10
"""Longest step of time in which the force moves: a task that was late does not catch up with a jump."""


class DriveKind(Enum):
    """What the actuator is to do."""

    PASSIVE = "passive"
    """Torque off."""
    FORCE = "force"
    OPEN = "open"


@dataclass(frozen=True)
class Drive:
    """What the actuator is to do, and with which force [mN]; 0 when passive or opening."""

    kind: DriveKind
    force_mn: int = 0

    @property
    def force_n(self) -> float:
        """The force [N]."""
        return self.force_mn / 1000.0


PASSIVE = Drive(DriveKind.PASSIVE)
OPENING = Drive(DriveKind.OPEN)


class Phase(Enum):
    """How the last command stands."""

    REST = "rest"
    """No command is followed and nothing runs out."""
    ACTIVE = "active"
    HOLD = "hold"
    LOST = "lost"


class Taken(Enum):
    """What became of a GRIP."""

    ACCEPTED = "accepted"
    OLD = "old"
    REJECTED = "rejected"


class ForceGuard:
    """Follows fresh commands within the limits and holds when there are none."""

    def __init__(self, tick_hz: int, limits: Limits) -> None:
        self._tick_hz = tick_hz
        self._config = Config(
            ttl_ms=TTL_MIN_MS,
            force_max_mn=limits.force_max_mn,
            slew_mn_s=limits.slew_max_mn_s,
            hold_cap_mn=limits.hold_cap_mn,
        )
        self.goal = PASSIVE
        self.phase = Phase.REST
        self.applied_mn = 0
        self.clamp = ForceClamp(0)
        self.last: Optional[tuple[int, int]] = None
        """Number and tick of the newest accepted command."""
        self.at_travel_end = False
        self._phase_tick = 0
        self._slew_mn_s = limits.slew_max_mn_s
        self._updated = 0
        self._credit = 0

    def _ticks(self, ms: int) -> int:
        return self._tick_hz * ms // 1000

    def arm(self, config: Config) -> None:
        """New limits; command numbers start afresh, the force stays as it is."""
        self._config = config
        self.last = None
        self.clamp = ForceClamp(0)
        self._limit_goal(config.force_max_mn)

    def reject(self) -> None:
        """Notes that a command was rejected."""
        self.clamp |= ForceClamp.REJECTED

    def command(self, tick: int, grip: Grip) -> Taken:
        """Takes a command: clamps what is too much, rejects what has no meaning, ignores what is old."""
        if self.last is not None and not 1 <= (grip.cmd_id - self.last[0]) & 0xFFFFFFFF < 1 << 31:
            return Taken.OLD
        if grip.force_mn < 0 or grip.mode not in _GOALS:
            self.reject()
            return Taken.REJECTED
        config = self._config
        ttl_ms = min(max(grip.ttl_ms, TTL_MIN_MS), TTL_MAX_MS) if grip.ttl_ms else config.ttl_ms
        force_mn = min(grip.force_mn, config.force_max_mn)
        self._slew_mn_s = min(grip.slew_mn_s, config.slew_mn_s) if grip.slew_mn_s else config.slew_mn_s
        self.clamp = ForceClamp(
            (ForceClamp.FORCE if force_mn < grip.force_mn else 0)
            | (ForceClamp.SLEW if self._slew_mn_s < grip.slew_mn_s else 0)
            | (ForceClamp.TTL if grip.ttl_ms and ttl_ms != grip.ttl_ms else 0)
        )
        self.goal = _GOALS[grip.mode] or Drive(DriveKind.FORCE, force_mn)
        self.last = (grip.cmd_id, tick)
        self.phase, self._phase_tick = Phase.ACTIVE, tick + self._ticks(ttl_ms)
        return Taken.ACCEPTED

    def _limit_goal(self, most_mn: int) -> bool:
        if self.goal.kind is DriveKind.FORCE and self.goal.force_mn > most_mn:
            self.goal = Drive(DriveKind.FORCE, most_mn)
            return True
        return False

    def hold(self, since: int) -> None:
        """Stops rising: the force stays, at most at the hold cap. The loss delay starts if a command was followed."""
        if self.phase is Phase.ACTIVE:
            self.phase, self._phase_tick = Phase.HOLD, since
        self._stay()

    def freeze(self) -> None:
        """Stops everything that moves, without a loss action later."""
        self.phase = Phase.REST
        if self.goal.kind is DriveKind.OPEN:
            self.goal = PASSIVE
        self._stay()

    def _stay(self) -> None:
        self._limit_goal(self.applied_mn)
        if self._limit_goal(self._config.hold_cap_mn):
            self.clamp |= ForceClamp.HOLD_CAP

    def settle(self) -> None:
        """The loss action is under way: nothing runs out any more."""
        self.phase = Phase.REST

    def release(self) -> None:
        """Torque off."""
        self.phase = Phase.REST
        self.goal = PASSIVE
        self.applied_mn = 0

    def advance(self, tick: int) -> Drive:
        """Lets commands run out and moves the force towards its goal."""
        step = min(max(tick - self._updated, 0), self._tick_hz * LONGEST_STEP_MS // 1000)
        self._updated = max(self._updated, tick)
        self._expire(tick)
        if self.goal.kind is not DriveKind.FORCE:
            self.applied_mn = self._credit = 0
            return self.goal
        target = self.goal.force_mn
        blocked = self.at_travel_end and target > self.applied_mn
        self.clamp = (self.clamp & ~ForceClamp.TRAVEL) | (ForceClamp.TRAVEL if blocked else ForceClamp(0))
        if blocked or target == self.applied_mn:
            self._credit = 0
        else:
            self._credit += step * self._slew_mn_s
            allowed, self._credit = divmod(self._credit, self._tick_hz)
            self.applied_mn += min(max(target - self.applied_mn, -allowed), allowed)
        return Drive(DriveKind.FORCE, self.applied_mn)

    def _expire(self, tick: int) -> None:
        if self.phase in (Phase.REST, Phase.LOST):
            return
        if self.phase is Phase.ACTIVE and tick > self._phase_tick:
            self.hold(self._phase_tick)
        since = max(tick - self._phase_tick, 0)
        if self.phase is Phase.HOLD and since >= self._ticks(self._config.loss_after_ms):
            self.phase = Phase.LOST
            if self.goal.kind is DriveKind.FORCE:
                self.goal = _LOSS_GOALS.get(self._config.loss_action, self.goal)


_GOALS: dict[int, Optional[Drive]] = {GripMode.FORCE: None, GripMode.OPEN: OPENING, GripMode.PASSIVE: PASSIVE}
_LOSS_GOALS = {LossAction.OPEN: OPENING, LossAction.PASSIVE: PASSIVE}
