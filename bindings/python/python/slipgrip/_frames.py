"""What is known of slips at the frames of a camera or a learner: events and readings in, one value for each frame out."""

from __future__ import annotations

import math
from typing import Dict, Mapping, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from ._core import Detection, Recording
from ._types import NEED, SCENES

FEATURES: Dict[str, str] = {
    "active": "1 where an object slipped at any time since the frame before, else 0",
    "statistic": "evidence of a slip over the wanted interval: 1 and above is a slip; 1000 at most",
    "confidence": "of the present slip, 0 to 1; 0 while nothing slips",
    "speed_m_s": "speed of the present slip as last reported (m/s); 0 while nothing slips",
    "esc_w": "E_sc of the last slip as last reported (W); 0 before the first",
    "estimate_n": "estimate of the adequate force as last reported (N); 0 before the first",
    "need_n": "force of a finger that the object needs at full weight, median (N); 0 before the first, and without the force controller",
    "held": "1 while an object is held at rest (scene holding), else 0",
    "force_n": "measured force of a finger (N); 0 before the first reading",
    "travel_m": "travel of the object past the fingers (m); 0 before the first reading",
    "command_n": "commanded force (N), where the force controller runs",
    "action": "the same as an action",
}
"""Names of the features with their meaning and unit."""

CHANNELS = ("force_n", "travel_m")
"""Features that are channels: they are there where the gripper has the sensor."""

OF_SLIPS = ("confidence", "speed_m_s", "esc_w", "estimate_n")
"""Features that events of slips report, under the same names."""

Frame = Dict[str, npt.NDArray[np.float32]]
"""A value of shape (1,) for each name of a dataset."""
Columns = Dict[str, npt.NDArray[np.float32]]
"""Values of shape (frames,) for each feature."""

HOLDING = SCENES.index("holding")
MOST = 1000.0
"""Of the statistic, which grows beyond all squares that a float32 holds: LeRobot's deviation of it would be no number."""
HALF_US = 0.5e-6
"""Times are whole microseconds: a row belongs to a frame of the same one."""


class SlipState:
    """What the events of slips amount to, up to now and since the frame before."""

    def __init__(self) -> None:
        self.values: Dict[str, float] = dict.fromkeys(OF_SLIPS, 0.0)
        self.slipping = False
        self._since_frame = False

    def event(self, event: Mapping[str, object]) -> None:
        """Takes an event; all but ``slip`` and ``slip_end`` are left out, and so is a value that is not known."""
        ended = event.get("type") == "slip_end"
        if not ended and event.get("type") != "slip":
            return
        if not self.slipping:
            self._rest()
        for name in OF_SLIPS:
            value = event.get(name)
            if isinstance(value, (int, float)) and math.isfinite(np.float32(value)):
                self.values[name] = float(value)
        self.seen(not ended)

    def seen(self, slipping: bool) -> None:
        """Whether something slips now."""
        self._since_frame |= slipping
        self.slipping = slipping
        if not slipping:
            self._rest()

    def frame(self) -> Dict[str, float]:
        """The features of a frame that ends now."""
        active, self._since_frame = self._since_frame, self.slipping
        return {"active": float(active), **self.values}

    def _rest(self) -> None:
        self.values["confidence"] = self.values["speed_m_s"] = 0.0


def chosen(there: Sequence[str], wanted: Optional[Sequence[str]]) -> Tuple[str, ...]:
    """The wanted features in their order, or all that are there; ValueError where one is unknown or not there."""
    if wanted is None:
        return tuple(name for name in FEATURES if name in there)
    for name in wanted:
        if name not in FEATURES:
            raise ValueError(f"features: {name!r} is not known; known are {', '.join(FEATURES)}")
        if name not in there:
            raise ValueError(f"features: there are no readings of {name!r}")
    if not wanted or len(set(wanted)) != len(wanted):
        raise ValueError(f"features: {list(wanted)} is empty or names one twice")
    return tuple(name for name in FEATURES if name in wanted)


def columns(
    recording: Recording, found: Detection, fps: float, features: Optional[Sequence[str]] = None
) -> Columns:
    """Features of a recording at its frames, by name: the wanted ones, or all that it has.

    Frame k stands at the first row's time plus k / fps, and the last one not after the last row. Its values are those
    of the last row at or before it; ``active`` is 1 where a slip was present at any time since the frame before.
    ``found`` is what ``detect`` or ``trace`` made of these rows.
    """
    times = recording.times
    if len(found.t_s) != len(times):
        raise ValueError(f"found: it is of {len(found.t_s)} rows, the recording has {len(times)}")
    last = _rows_of_frames(recording, times, fps)
    readings = {"statistic": np.minimum(_held(found.statistic, last), np.float32(MOST)), "held": (found.scene[last] == HOLDING).astype(np.float32)}
    for name in CHANNELS:
        if name in recording.channels and np.isfinite(recording[name]).any():
            readings[name] = _held(recording[name], last)
    state, events, at = SlipState(), found.events, 0
    slips = []
    for row in last:
        while at < len(events) and events[at]["sample"] <= row:
            state.event(events[at])
            at += 1
        slips.append(state.frame())
    readings.update({name: np.array([frame[name] for frame in slips], np.float32) for name in slips[0]})
    if found.command_n is not None:
        readings["action"] = readings["command_n"] = _held(found.command_n, last)
    if found.need is not None:
        readings["need_n"] = _held(found.need[:, NEED.index("need_n")], last)
    return {name: readings[name] for name in chosen(list(readings), features)}


def _rows_of_frames(recording: Recording, times: npt.NDArray[np.float64], fps: float) -> npt.NDArray[np.intp]:
    """Number of the last row at or before each frame."""
    if not (np.isfinite(fps) and 0 < fps <= recording.rate_hz):
        raise ValueError(f"fps = {fps}: more than 0 and at most the {recording.rate_hz:g} rows a second are possible")
    frames = math.floor((times[-1] - times[0] + HALF_US) * fps) + 1
    if frames > len(times):
        raise ValueError(f"{recording.name}: {frames} frames of {len(times)} rows: it has gaps; cut it there")
    at = times[0] + np.arange(frames) / fps
    rows: npt.NDArray[np.intp] = np.searchsorted(times, at + HALF_US, side="right") - 1
    return rows


def _held(values: npt.NDArray[np.float32], rows: npt.NDArray[np.intp]) -> npt.NDArray[np.float32]:
    """The last finite value at or before each of these rows; 0 where there is none yet."""
    known = np.isfinite(values)
    newest = np.maximum.accumulate(np.where(known, np.arange(len(values)), 0))[rows]
    return np.where(known[newest], values[newest], np.float32(0.0))
