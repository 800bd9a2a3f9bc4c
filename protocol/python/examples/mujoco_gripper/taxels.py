"""Contact forces on a pad in, frames of the taxel array under its cover out.

The array is square. The cover spreads each contact force as a Gaussian over the way along the surface, and the whole of the force lands on the array.
A frame comes each millisecond. The link has a pressure for each taxel and one tangential force for the finger, so shear of single taxels is not sent.
"""

from __future__ import annotations

import numpy as np

SIDE = 4
TAXELS = SIDE * SIDE
PITCH_M = 5e-3
AREA_M2 = PITCH_M**2
SPREAD_M = 2.5e-3
"""Standard deviation of the spread of a force by the cover."""
FRAME_S = 1e-3
LAG_S = 0.5e-3
"""Of the amplifiers: 300 Hz."""
NOISE_PA, STEP_PA = 200.0, 50.0
"""200 Pa on 25 mm2 is 5 mN, as of the other force sensors."""

_CENTRES_M = (np.arange(SIDE) - 0.5 * (SIDE - 1)) * PITCH_M


def pressures(places_m: np.ndarray, forces_n: np.ndarray) -> np.ndarray:
    """Pressures [Pa], row by row along the finger, of n forces at n x 2 places, across and along, from the middle of the array."""
    if not len(forces_n):
        return np.zeros(TAXELS)
    weights = np.exp(-0.5 * ((places_m[:, :, None] - _CENTRES_M) / SPREAD_M) ** 2)
    spread = weights[:, 1, :, None] * weights[:, 0, None, :]
    shares = spread / spread.sum(axis=(1, 2), keepdims=True)
    return np.asarray((forces_n[:, None, None] * shares).sum(axis=0).ravel() / AREA_M2)


class Array:
    """What the amplifiers of the array show."""

    def __init__(self) -> None:
        self.pressures_pa = np.zeros(TAXELS)

    def follow(self, places_m: np.ndarray, forces_n: np.ndarray, step_s: float) -> None:
        """Goes on by ``step_s`` with these forces on the cover."""
        self.pressures_pa += (pressures(places_m, forces_n) - self.pressures_pa) * (step_s / LAG_S)
