"""SLIP, STATE, HEALTH, GRIPPER and ESTIMATES: what a daemon tells. NaN stands for what is not known; infinite values are refused."""

from __future__ import annotations

import math
import struct
from dataclasses import astuple, dataclass
from typing import Any

from ..codes import DeviceState, Unit
from ..wire import BadValue, pack, unpack
from .codes import Causes, EscKind, GripStage, LinkState, Method, Phase, Recording, Scene, SensorHealth, SpeedSource, Unsure

NOT_KNOWN = 0xFFFFFFFF
_SLIP = struct.Struct("<IQQBBBBfffffIffBBBBfff")
_CERTIFIED = struct.Struct("<f")
_STATE = struct.Struct("<QQBBBBBBBBHBBfffffIQ")
_FLOAT = struct.Struct("<f")
_GROWN = 5
"""Fields of STATE that were appended to its first version."""
_HEALTH = struct.Struct("<QfQQIIIIIIQQIHBBfffQQQQQIIQ")
_APPENDED = struct.Struct("<ffq" + 24 * "Q")
_GRIPPER = struct.Struct("<16sIIfBBBB")
_ESTIMATES = struct.Struct("<IQQfffHH")


def _offsets(layout: struct.Struct) -> list[int]:
    """Offset of each field."""
    codes = layout.format.lstrip("<").replace("16s", "s")
    sizes = [16 if code == "s" else struct.calcsize(code) for code in codes]
    return [sum(sizes[:n]) for n in range(len(sizes))]


def _finite(layout: struct.Struct, payload: bytes, start: int = 0) -> tuple[Any, ...]:
    values = unpack(layout, payload[start:])
    for at, value in zip(_offsets(layout), values):
        if isinstance(value, float) and math.isinf(value):
            raise BadValue(start + at, value)
    return values


@dataclass(frozen=True)
class Slip:
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
    certified: float | None = None
    """s, interval that the slip is certified with; None where it is not."""

    @classmethod
    def parse(cls, payload: bytes) -> Slip:
        """Reads a payload; raises PayloadError."""
        v = _finite(_SLIP, payload)
        values: list[Any] = [*v[:3], Phase(v[3]), Method(v[4]), SpeedSource(v[5]), EscKind(v[6]), *v[7:17], Causes(v[17]), Causes(v[18]), *v[19:]]
        if len(payload) >= _SLIP.size + _CERTIFIED.size:
            values += _finite(_CERTIFIED, payload, _SLIP.size)
        return cls(*values)

    def pack(self) -> bytes:
        """The payload; raises PayloadError."""
        *first, certified = astuple(self)
        return pack(_SLIP, *first) + (b"" if certified is None else pack(_CERTIFIED, certified))


@dataclass(frozen=True)
class State:
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
    late: float | None = None
    """ms, age of the newest usable row at the last command; None, as what follows, where the payload ends before it."""
    need_low: float | None = None
    """N, normal force of one finger that the object needs at full weight: its 10 % quantile"""
    need: float | None = None
    """N, its median"""
    need_high: float | None = None
    """N, its 90 % quantile"""
    admissible: float | None = None
    """m/s^2, acceleration of the arm beside gravity at which the object slips with a probability of 10 %"""

    @classmethod
    def parse(cls, payload: bytes) -> State:
        """Reads a payload; raises PayloadError."""
        v = _finite(_STATE, payload)
        sensors = [SensorHealth(code) for code in v[4:8]]
        values: list[Any] = [*v[:2], Scene(v[2]), GripStage(v[3]), *sensors, DeviceState(v[8]), *v[9:12], EscKind(v[12]), *v[13:]]
        for at in range(_STATE.size, _STATE.size + _GROWN * _FLOAT.size, _FLOAT.size):
            if len(payload) >= at + _FLOAT.size:
                values += _finite(_FLOAT, payload, at)
        return cls(*values)

    def pack(self) -> bytes:
        """The payload; raises PayloadError."""
        values = astuple(self)
        first, grown = values[:-_GROWN], values[-_GROWN:]
        known_to = max((n for n, value in enumerate(grown, 1) if value is not None), default=0)
        known = (math.nan if value is None else value for value in grown[:known_to])
        return pack(_STATE, *first) + b"".join(pack(_FLOAT, value) for value in known)


@dataclass(frozen=True)
class Health:
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
    p999: float | None = None
    """us; None, as all from here on, where the daemon is older than that."""
    clock_half: float | None = None
    """us, what clock_offset may be off; NaN: the clocks are not known."""
    clock_offset: int | None = None
    """us, host time minus device time."""
    histogram: tuple[int, ...] | None = None
    """Frames by latency: number k counts those below 256 * 2**k ns that no number before counts; the last one all longer ones."""

    @classmethod
    def parse(cls, payload: bytes) -> Health:
        """Reads a payload; raises PayloadError."""
        v = _finite(_HEALTH, payload)
        values: list[Any] = [*v[:14], LinkState(v[14]), Recording(v[15]), *v[16:]]
        if len(payload) >= _HEALTH.size + _APPENDED.size:
            p999, clock_half, clock_offset, *histogram = _finite(_APPENDED, payload, _HEALTH.size)
            # An offset that is not known is none, whatever stands there.
            values += [p999, clock_half, 0 if math.isnan(clock_half) else clock_offset, tuple(histogram)]
        return cls(*values)

    def pack(self) -> bytes:
        """The payload; raises PayloadError."""
        *first, p999, clock_half, clock_offset, histogram = astuple(self)
        appended = b"" if histogram is None else pack(_APPENDED, p999, clock_half, clock_offset, *histogram)
        return pack(_HEALTH, *first) + appended


@dataclass(frozen=True)
class Gripper:
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

    @classmethod
    def parse(cls, payload: bytes) -> Gripper:
        """Reads a payload; raises PayloadError."""
        v = _finite(_GRIPPER, payload)
        values: list[Any] = [*v[:4], LinkState(v[4]), v[5], Unit(v[6])]
        return cls(*values)

    def pack(self) -> bytes:
        """The payload; raises PayloadError."""
        return pack(_GRIPPER, *astuple(self), 0)


@dataclass(frozen=True)
class Estimates:
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

    @classmethod
    def parse(cls, payload: bytes) -> Estimates:
        """Reads a payload; raises PayloadError."""
        v = _finite(_ESTIMATES, payload)
        values: list[Any] = [*v[:6], Unsure(v[6])]
        return cls(*values)

    def pack(self) -> bytes:
        """The payload; raises PayloadError."""
        return pack(_ESTIMATES, *astuple(self), 0)
