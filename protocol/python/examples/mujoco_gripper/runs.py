"""One object in, its needed force and its grasps out, as rows of the table."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from .items import Item, draw
from .loop import FORCE_MAX_N, Grasp, grasp
from .needed import CRUSH_RATIO, ORACLE_RATIO, Held, hold, needed_n

MOST_REPEATS = 5


@dataclass(frozen=True)
class Job:
    """One object and what is to be done with it."""

    number: int
    kind: str
    options: argparse.Namespace


@dataclass(frozen=True)
class Prepared:
    """An object, the grip force that it needs, and what the oracle made of it."""

    item: Item
    needed_n: float
    oracle: Held | None


@contextmanager
def _before_others(wanted: bool) -> Iterator[None]:
    """This process and the gripd that it starts go before others, where the system grants it."""
    if wanted:
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
        except PermissionError:
            print("mujoco_gripper: --realtime is not granted; goes on without", file=sys.stderr)
            wanted = False
    try:
        yield
    finally:
        if wanted:
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def prepare(job: Job) -> Prepared:
    """Needed force and oracle: pure computation, which any process may do at any time."""
    item = draw(job.kind, job.options.seed, job.number)
    needed = needed_n(item)
    return Prepared(item, needed, hold(item, ORACLE_RATIO * needed) if job.options.oracle else None)


def rows(prepared: Prepared, options: argparse.Namespace) -> list[dict[str, Any]]:
    """One grasp with each sensor set, in real time, and what was prepared."""
    item, needed, held = prepared.item, prepared.needed_n, prepared.oracle
    about = {
        "class": item.kind, "shape": item.shape, "seed": item.seed[0], "number": item.seed[1], "mass_kg": item.mass_kg,
        "friction": item.friction, "ra_um": item.roughness_um, "needed_n": needed,
    }  # fmt: skip
    found: list[dict[str, Any]] = []
    if held is not None:
        found.append({
            **about, "way": "oracle", "dropped": held.dropped, "crushed": held.peak_n > CRUSH_RATIO * needed, "slip_mm": held.slip_m * 1e3,
            "peak": held.peak_n / needed, "final": held.final_n / needed,
        })  # fmt: skip
    for sensors in options.sensors:
        done, repeats = _in_good_time(item, sensors, options)
        row = {
            **about, "way": sensors, "dropped": done.dropped, "crushed": done.peak_n > CRUSH_RATIO * needed, "slip_mm": done.slip_m * 1e3,
            "peak": done.peak_n / needed, "final": done.final_n / needed, "most_commanded_n": done.most_commanded_n,
            "at_limit": done.most_commanded_n >= FORCE_MAX_N, "slips": done.slips, "late_ms": done.late_ms, "repeats": repeats,
            "too_late": done.late_ms > options.late_ms,
        }  # fmt: skip
        if item.release_s is not None:
            row["released"] = done.released
        if done.error:
            row["error"] = done.error
        found.append(row)
        if options.trace is not None:
            from . import trace

            trace.draw(item, sensors, done, needed, options.trace)
    return found


def _in_good_time(item: Item, sensors: str, options: argparse.Namespace) -> tuple[Grasp, int]:
    """A grasp, repeated while it was late, and how often."""
    for repeats in range(MOST_REPEATS + 1):
        with _before_others(options.realtime):
            done = grasp(item, sensors, options.gripd, sink_m_n=options.sink * 1e-6, realtime=options.realtime)
        if done.error or done.late_ms <= options.late_ms:
            break
    return done, repeats
