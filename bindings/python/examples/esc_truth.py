"""E_sc against the truth: every reading and its enclosure beside 400 bits of mpmath: python esc_truth.py [PICTURE]"""

from __future__ import annotations

from typing import Dict, List, Tuple

import mpmath
import numpy as np
import numpy.typing as npt

from drawing import axes, save
from slipgrip import esc

mpmath.mp.prec = 400
Doubles = npt.NDArray[np.float64]
FORCE, SPEED, SURFACES = 2.0, 0.05, 20


def literal(delta: Doubles, s: Doubles) -> mpmath.mpf:
    """n F v tan(sum cot(delta / s)) of the very numbers that went in."""
    angle = sum(mpmath.cot(mpmath.mpf(float(d)) / mpmath.mpf(float(w))) for d, w in zip(delta, s))
    return len(delta) * mpmath.mpf(FORCE) * mpmath.mpf(SPEED) * mpmath.tan(angle)


def main() -> None:
    rng = np.random.default_rng(5000)
    outside, points = 0, []  # type: Tuple[int, List[Tuple[int, float, float, float]]]
    for n in (1, 3, 10, 30, 100, 300, 1000):
        for _ in range(SURFACES):
            s = rng.uniform(20e-6, 300e-6, n)
            delta = s * rng.uniform(0.01, 0.5, n)
            line = esc(delta, s, FORCE, SPEED)["literal"]
            value, lo, hi = line["value"], line["lo"], line["hi"]
            assert value is not None and lo is not None and hi is not None
            exact = literal(delta, s)
            outside += not lo <= exact <= hi
            naive = n * FORCE * SPEED * np.tan(np.sum(1 / np.tan(delta / s)))
            points.append((n, float(abs((hi - lo) / 2 / exact)), float(abs(value / exact - 1)), float(abs(naive / exact - 1))))
    table = np.array(points)
    print("    n   half width   error of the value   error of numpy (largest, relative)")
    for n in np.unique(table[:, 0]):
        width, error, naive = table[table[:, 0] == n, 1:].max(axis=0)
        print(f"{int(n):5d}   {width:10.1e}   {error:18.1e}   {naive:14.1e}")
    print(f"outside their enclosure: {outside} of {len(table)}")
    assert outside == 0

    figure, ((axis,),) = axes(1, 3.2)
    names: Dict[str, int] = {"half width of the enclosure": 1, "error of the value": 2, "error of the formula in numpy": 3}
    for (name, column), marker in zip(names.items(), "_x."):
        axis.loglog(table[:, 0], np.maximum(table[:, column], 1e-18), marker, label=name)
    axis.set(xlabel="irregularities n", ylabel="relative to the truth")
    axis.legend()
    save(figure)


if __name__ == "__main__":
    main()
