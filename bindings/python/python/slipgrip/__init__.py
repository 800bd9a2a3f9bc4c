"""Slip detection for robot grippers.

Readings go in as NumPy arrays of shape ``(rows, channels)``, or ``(rows,)`` for one channel. C-contiguous arrays of
``float32`` are used where they are; all others are converted. A reading may be NaN or infinite: that is what a broken
sensor sends. Channels have the names of the columns of a recording, and their units: ``stylus`` (m) or ``vibration``
(any unit), ``force_n`` (N), ``tangential_n`` (N), ``travel_m`` (m), ``velocity_m_s`` (m/s), ``stylus2`` (m),
``reference``, ``pressure``, ``motion``, and ``pressure_0``, ``pressure_1``, ... for a taxel array. A column whose name
is empty is left out.

What is wrong is a ``ValueError`` or ``TypeError`` with a sentence. Long calls release the GIL; an array must not be
written to meanwhile.
"""

from ._core import (
    Calibration,
    Detection,
    Detector,
    Grasp,
    Model,
    Pipeline,
    Profile,
    Recording,
    calibrate,
    detect,
    esc,
    profile,
    read,
    replay,
    trace,
    train,
)
from ._env import GraspEnv
from ._types import BANDS, NEED, SCENES, EscReading, Event, Truth

__version__ = "0.1.0"

__all__ = [
    "BANDS",
    "NEED",
    "SCENES",
    "Calibration",
    "Detection",
    "Detector",
    "EscReading",
    "Event",
    "Grasp",
    "GraspEnv",
    "Model",
    "Pipeline",
    "Profile",
    "Recording",
    "Truth",
    "calibrate",
    "detect",
    "esc",
    "profile",
    "read",
    "replay",
    "trace",
    "train",
]
