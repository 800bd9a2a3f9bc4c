"""A way along a surface in, readings of a stylus and of the other sensors out, with noise and steps.

The surface is self-affine (Hurst exponent 0.8 between 10 um and 0.5 mm, flat below and nothing above), its phases random; its height is the sum of
a profile along and one across the finger. Ra is that of either profile.
"""

from __future__ import annotations

import math

import numpy as np

from .taxels import NOISE_PA

PITCH_M = 2e-6
POINTS = 1 << 15
HURST = 0.8
LONGEST_M, SHORTEST_M = 0.5e-3, 10e-6
STYLUS_STEP_S = 2.5e-5
STYLUS_HZ, STYLUS_DAMPING = 1500.0, 0.7
STYLUS_NOISE_M, STYLUS_STEP_M, STYLUS_RANGE_M = 1e-7, 1e-8, 3.2e-4
FORCE_NOISE_N, TRAVEL_NOISE_M = 5e-3, 2e-6


def profile(rng: np.random.Generator, ra_m: float) -> np.ndarray:
    """Heights [m] at every 2 um, periodic, with the mean deviation ``ra_m``."""
    wave = np.fft.rfftfreq(POINTS, PITCH_M)
    amplitude = np.where((wave > 0) & (wave < 1.0 / SHORTEST_M), np.maximum(wave, 1.0 / LONGEST_M) ** -(HURST + 0.5), 0.0)
    heights = np.fft.irfft(amplitude * np.exp(2j * math.pi * rng.random(len(wave))), POINTS)
    heights -= heights.mean()
    return np.asarray(heights * (ra_m / np.abs(heights).mean()))


class Surface:
    """Heights over the way along and across the finger."""

    def __init__(self, rng: np.random.Generator, ra_m: float) -> None:
        self._along = profile(rng, ra_m).tolist()
        self._across = profile(rng, ra_m).tolist()

    def height_m(self, down_m: float, aside_m: float) -> float:
        """The height at a place."""
        return _between(self._along, down_m) + _between(self._across, aside_m)


def _between(heights: list[float], at_m: float) -> float:
    place = at_m / PITCH_M
    below = math.floor(place)
    share = place - below
    return heights[below % POINTS] * (1.0 - share) + heights[(below + 1) % POINTS] * share


class Stylus:
    """A mass on a spring with a damper that follows the surface; it is solved in steps of 25 us."""

    def __init__(self) -> None:
        self._at: float | None = None
        self._speed = 0.0

    def follow(self, duration_s: float, height_m: float) -> float:
        """Where the tip is [m] after so long on a surface of this height."""
        if self._at is None:
            self._at = height_m
        omega, step = 2.0 * math.pi * STYLUS_HZ, STYLUS_STEP_S
        for _ in range(round(duration_s / step)):
            self._speed += (omega * omega * (height_m - self._at) - 2.0 * STYLUS_DAMPING * omega * self._speed) * step
            self._at += self._speed * step
        return self._at


class Sensors:
    """What the true values look like to the gripper."""

    def __init__(self, seed: tuple[int, int], ra_m: float, sink_m_n: float = 0.0) -> None:
        """``sink_m_n`` is how far the pads give way under the stylus for each newton; 0 where it has a skid that rests on the object."""
        rng = np.random.default_rng([*seed, 1])
        self._sink_m_n = sink_m_n
        self._surface = Surface(rng, ra_m)
        self._stylus = Stylus()
        self._rng = rng
        self._noise: list[float] = []

    def _normal(self) -> float:
        if not self._noise:
            self._noise = self._rng.standard_normal(40_000).tolist()
        return self._noise.pop()

    def stylus(self, since_s: float, down_m: float, aside_m: float, force_n: float) -> float:
        """Displacement of the stylus [m], so long after the last one, in steps of the converter."""
        true = self._stylus.follow(since_s, self._surface.height_m(down_m, aside_m)) + self._sink_m_n * force_n
        steps = round((true + STYLUS_NOISE_M * self._normal()) / STYLUS_STEP_M)
        return max(-STYLUS_RANGE_M, min(STYLUS_RANGE_M, steps * STYLUS_STEP_M))

    def force(self, force_n: float) -> float:
        """A force [N] with noise."""
        return force_n + FORCE_NOISE_N * self._normal()

    def travel(self, down_m: float) -> float:
        """A moved distance [m] with noise."""
        return down_m + TRAVEL_NOISE_M * self._normal()

    def taxels(self, pressures_pa: list[float]) -> list[float]:
        """Pressures [Pa] with noise."""
        return [pressure + NOISE_PA * self._normal() for pressure in pressures_pa]
