"""Types of the dictionaries that come out."""

from __future__ import annotations

from typing import List, Optional, TypedDict

SCENES = ("idle", "moving", "holding", "slipping")
"""Names of the numbers in ``Detection.scene``."""

BANDS = ("shear", "vibration", "octave 1", "octave 2", "octave 3", "octave 4")
"""Names of the columns of ``Detection.levels``."""

NEED = ("need_low_n", "need_n", "need_high_n", "admissible_m_s2")
"""Names of the columns of ``Detection.need``: quantiles of the normal force of one finger that the object needs at full weight (10, 50 and
90 %, N); acceleration of the arm at which it slips at the commanded force with a probability of 10 % (m/s^2)."""


class Event(TypedDict, total=False):
    """A line of ``gripctl replay --json`` with the number of its row; which keys there are depends on ``type``."""

    type: str
    """``slip``, ``slip_end``, ``grip`` or ``health``."""
    sample: int
    """Number of the row that led to it, from 0."""
    t_s: float
    phase: str
    method: str
    statistic: Optional[float]
    confidence: Optional[float]
    certified: bool
    certified_interval_s: Optional[float]
    ruled_out: List[str]
    possible: List[str]
    duration_s: Optional[float]
    speed_m_s: Optional[float]
    speed_sigma_m_s: Optional[float]
    speed_source: Optional[str]
    moved_m: Optional[float]
    irregularities: Optional[int]
    esc_w: Optional[float]
    esc_informative: Optional[bool]
    esc_flags: Optional[List[str]]
    esc_reading: Optional[str]
    esc_value: Optional[float]
    esc_unit: Optional[str]
    estimate_n: Optional[float]
    estimate_sigma_n: Optional[float]
    estimate_lo_n: Optional[float]
    estimate_hi_n: Optional[float]
    extrapolated: Optional[bool]
    command_n: Optional[float]
    event: str
    channel: str
    health: str


class EscReading(TypedDict):
    """One reading of E_sc; the exact value of its formula lies within ``lo`` to ``hi``."""

    value: Optional[float]
    """In ``unit``; None without a usable irregularity."""
    lo: Optional[float]
    hi: Optional[float]
    unit: str
    """``W`` or ``J``."""
    n: int
    """Irregularities that entered."""
    degenerate: int
    """Irregularities left out: a length was zero, negative or not finite."""
    condition: Optional[float]
    """Relative condition number with respect to the sum of the reading."""
    sigma_s: Optional[float]
    """Deviation of that sum by the noise of delta/s."""
    flags: List[str]
    formula: str


class Truth(TypedDict):
    """What no sensor of the simulator knows."""

    time_s: float
    needed_n: float
    """Force of each finger that balances the load now (N)."""
    needed_max_n: float
    """The largest of it so far (N)."""
    crush_n: float
    """Force of a finger above which the object breaks (N)."""
    applied_n: float
    peak_n: float
    slip_m: float
    speed_m_s: float
    slipping: bool
    lifted: bool
    dropped: bool
    crushed: bool
