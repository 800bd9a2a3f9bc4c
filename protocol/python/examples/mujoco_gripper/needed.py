"""An object in, the grip force that it needs and what an oracle would make of it out: the same physics, without gripd and faster than time."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .items import GRAVITY, Item
from .world import HOLD_S, LIFT_PEAK_M_S2, LIFT_S, SWAY_AT_S, SWAY_S, World

CRUSH_RATIO = 2.5
ORACLE_RATIO = 1.25
STAYS_M = 1e-3
"""An object that has moved by less on the pads than this was held."""


@dataclass(frozen=True)
class Held:
    """The end of a grasp with a constant force."""

    dropped: bool
    slip_m: float
    peak_n: float
    final_n: float


def hold(item: Item, force_n: float, until_s: float = HOLD_S, most_m: float = math.inf) -> Held:
    """Grips with ``force_n`` before the lift and keeps it, until so long after the lift or until the object has moved by ``most_m``."""
    world = World(item)
    if item.release_s is not None:
        until_s = min(until_s, item.release_s)
    while not world.is_over and world.since_lift_s < until_s and world.peak_slip_m < most_m:
        world.step(world.close(force_n))
        if world.time_s > 10.0:
            raise RuntimeError(f"{item.kind} {item.seed}: the fingers never touched it")
    return Held(world.dropped, world.peak_slip_m, world.peak_n, world.force_n)


def _worst_s(item: Item) -> float:
    """When nothing more will act on it than already has [s from the lift]."""
    if item.pull is not None:
        return item.pull.start_s + item.pull.rise_s + min(item.pull.hold_s, 0.4)
    return SWAY_AT_S + SWAY_S + 0.2 if item.sway_m else LIFT_S + 0.2


def needed_n(item: Item, within: float = 0.02) -> float:
    """The smallest constant force [N] under which it does not slip, whatever acts on it until it is at rest, by bisection."""
    worst = _worst_s(item)

    def stays(force_n: float) -> bool:
        return hold(item, force_n, worst, STAYS_M).slip_m < STAYS_M

    pull_n = item.pull.force_n if item.pull is not None else 0.0
    low = high = (item.mass_kg * (GRAVITY + LIFT_PEAK_M_S2) + pull_n) / (2.0 * item.friction)
    step = 1.0 + 2.0 * within
    while not stays(high):
        low, high, step = high, high * step, step * step
        if high > 50.0 * item.weight_force_n:
            raise RuntimeError(f"{item.kind} {item.seed}: nothing holds it")
    step = 1.0 + within
    while low >= high and stays(low / step):
        low, high, step = low / step, low / step, step * step
    low = min(low, high / step)
    while high / low > 1.0 + within:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if stays(middle) else (middle, high)
    return high
