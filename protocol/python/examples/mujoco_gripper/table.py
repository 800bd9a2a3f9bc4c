"""Rows of grasps in, the lines of a table by class of object out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from .items import CLASSES

Row = dict[str, Any]
_HEAD = ("class", "grasps", "dropped", "crushed", "slip mm", "peak over needed", "final over needed", "at f_max", "released")


_Z = 1.96


def wilson(hits: int, of: int) -> tuple[float, float]:
    """The interval of Wilson (1927) that has the share behind ``hits`` of ``of`` at 95 %."""
    if not of:
        return 0.0, 1.0
    share, z2 = hits / of, _Z * _Z / of
    half = _Z * math.sqrt(share * (1.0 - share) / of + z2 / (4.0 * of))
    low, high = ((share + 0.5 * z2 + sign * half) / (1.0 + z2) for sign in (-1.0, 1.0))
    return (low if hits else 0.0), (high if hits < of else 1.0)


def _count(hits: int, of: int) -> str:
    low, high = wilson(hits, of)
    return f"{hits} ({100 * low:.1f}-{100 * high:.1f} %)"


def _pair(rows: Sequence[Row], key: str) -> str:
    if not rows:
        return "-"
    values = [row[key] for row in rows]
    return f"{np.percentile(values, 50):.2f} / {np.percentile(values, 95):.2f}"


def _line(name: str, rows: Sequence[Row]) -> str:
    held = [row for row in rows if not row["dropped"]]
    given = [row for row in rows if "released" in row]
    cells = [
        name, len(rows), _count(sum(row["dropped"] for row in rows), len(rows)), _count(sum(row["crushed"] for row in rows), len(rows)),
        _pair(held, "slip_mm"), _pair(held, "peak"), _pair(held, "final"), sum(row.get("at_limit", False) for row in rows),
        f"{sum(row['released'] for row in given)} of {len(given)}" if given else "-",
    ]  # fmt: skip
    return "| " + " | ".join(map(str, cells)) + " |"


def lines(rows: Sequence[Row], ways: Sequence[str]) -> Iterator[str]:
    """A table for each way of holding; counts with Wilson intervals at 95 %, pairs are median / 95 % of what was not dropped."""
    for way in ways:
        all_of = [row for row in rows if row["way"] == way and "error" not in row]
        kept = [row for row in all_of if not row.get("too_late")]
        yield f"{way}: {len(kept)} grasps"
        yield "| " + " | ".join(_HEAD) + " |"
        yield "|" + "---|" * len(_HEAD)
        for name in CLASSES:
            if some := [row for row in kept if row["class"] == name]:
                yield _line(name, some)
        yield _line("all", kept)
        again, late = sum(row.get("repeats", 0) for row in all_of), len(all_of) - len(kept)
        failed = sum("error" in row for row in rows if row["way"] == way)
        yield f"{again} late grasps repeated, {late} late to the end and not counted, {failed} failed to run"
        yield ""
