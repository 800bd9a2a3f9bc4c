"""SLIP, STATE, HEALTH, GRIPPER and ESTIMATES: what a daemon tells. NaN stands for what is not known; infinite values are refused."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Optional

from ..codes import DeviceState, Kind, Unit
from ..wire import Message
from .codes import Causes, EscKind, GripStage, LinkState, Method, Phase, Recording, Scene, SensorHealth, SpeedSource, Unsure


@dataclass(frozen=True)
class Slip(Message, kind=Kind.SLIP, layout="IQQBBBBfffffIffBBBBfff", appended="f"):
    """SLIP (A1), 76 bytes, 72 where it is not certified: a slip was noticed, became gross, or ended."""

    number: int
    device_us: int
    host_us: int
    phase: Phase
    method: Method
    speed_source: SpeedSource
    esc_kind: EscKind
    statistic: float
    confidence: float
    speed: float
    """m/s"""
    sigma: float
    """m/s"""
    moved: float
    """m"""
    irregularities: int
    """4294967295 = not known."""
    esc: float
    """W"""
    esc_chosen: float
    """W or J"""
    esc_flags: int
    notes: int
    """b0 E_sc depends on the surface, b1 the estimate is extrapolated."""
    ruled_out: Causes
    """Causes other than a slip that were ruled out ..."""
    possible: Causes
    """... and those that were not; one in neither could not be judged."""
    estimate: float
    """N"""
    command: float
    """N"""
    duration: float
    """s"""
    certified: Optional[float] = None
    """s, interval that the slip is certified with; None where it is not."""


@dataclass(frozen=True)
class State(Message, kind=Kind.STATE, layout="QQBBBBBBBBHBBfffffIQ", appended="fffff"):
    """STATE (A2), 60 to 80 bytes, up to the last number that is known: what the pipeline thinks."""

    device_us: int
    host_us: int
    scene: Scene
    grip: GripStage
    stylus: SensorHealth
    travel: SensorHealth
    pressure: SensorHealth
    reference: SensorHealth
    device: DeviceState
    notes: int
    fault: int
    esc_flags: int
    esc_kind: EscKind
    statistic: float
    command: float
    """N"""
    applied: float
    """N"""
    esc: float
    """W or J"""
    estimate: float
    """N"""
    rate_hz: int
    lost: int
    late: Optional[float] = None
    """ms, age of the newest usable row at the last command; None, as what follows, where the payload ends before it."""
    need_low: Optional[float] = None
    """N, normal force of one finger that the object needs at full weight: its 10 % quantile"""
    need: Optional[float] = None
    """N, its median"""
    need_high: Optional[float] = None
    """N, its 90 % quantile"""
    admissible: Optional[float] = None
    """m/s^2, acceleration of the arm beside gravity at which the object slips with a probability of 10 %"""


@dataclass(frozen=True)
class Health(Message, kind=Kind.HEALTH, layout="QfQQIIIIIIQQIHBBfffQQQQQIIQ", appended=("ffq24Q",)):
    """HEALTH (A3), 352 bytes, 144 from older daemons: figures of the daemon since its start."""

    host_us: int
    rate: float
    """Hz"""
    samples: int
    lost: int
    too_long: int
    cobs: int
    length: int
    crc: int
    useless: int
    gap: int
    dropped_service: int
    dropped_recorder: int
    dropped_clients: int
    clients: int
    link: LinkState
    recording: Recording
    p50: float
    """us"""
    p99: float
    """us"""
    longest: float
    """us"""
    recorded: int
    """Bytes."""
    bands: int
    gate: int
    methods: int
    observation: int
    slips: int
    reconnects: int
    commands: int
    p999: Optional[float] = None
    """us; None, as all from here on, where the daemon is older than that."""
    clock_half: Optional[float] = None
    """us, what clock_offset may be off; NaN: the clocks are not known."""
    clock_offset: Optional[int] = None
    """us, host time minus device time."""
    histogram: Optional[tuple[int, ...]] = None
    """Frames by latency: number k counts those below 256 * 2**k ns that no number before counts; the last one all longer ones."""

    @classmethod
    def parse(cls, payload: bytes) -> Health:
        """Reads a payload; raises PayloadError. An offset that is not known is none, whatever stands there."""
        health = super().parse(payload)
        known = health.clock_half is None or not math.isnan(health.clock_half)
        return health if known else replace(health, clock_offset=0)


@dataclass(frozen=True)
class Gripper(Message, kind=Kind.GRIPPER, layout="16sIIfBBBx"):
    """GRIPPER (A4), 32 bytes: which gripper the daemon holds."""

    uid: bytes
    boot_id: int
    rate_hz: int
    force_max: float
    """N"""
    link: LinkState
    taxels: int
    stylus: Unit = Unit.NONE
    """Metres; a vibration in a unit of its own has none."""


@dataclass(frozen=True)
class Estimates(Message, kind=Kind.ESTIMATES, layout="IQQfffHxx"):
    """ESTIMATES (AE), 36 bytes: what the model in force and the shadow model made of a slip that has ended."""

    slip: int
    device_us: int
    host_us: int
    slipped: float
    """N"""
    in_force: float
    """N"""
    shadow: float
    """N"""
    unsure: Unsure
