"""E_sc against its formulas in arbitrary precision, and profiles."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import mpmath
import numpy as np
import numpy.typing as npt

from slipgrip import esc, profile

mpmath.mp.prec = 400
Doubles = npt.NDArray[np.float64]
FORCE, SPEED = 2.0, 0.05


def truth(delta: Doubles, s: Doubles, reading: str) -> mpmath.mpf:
    """Each reading by its formula with 120 digits."""
    pairs = [(mpmath.mpf(float(d)), mpmath.mpf(float(w))) for d, w in zip(delta, s)]
    n, force, speed = len(pairs), mpmath.mpf(FORCE), mpmath.mpf(SPEED)
    # The damper of a stylus of 1 g on 500 N/m with damping ratio 0.1, in single precision.
    damping = mpmath.mpf(float(np.float32(0.14142136)))
    sums = {
        "literal": lambda: n * force * speed * mpmath.tan(sum(mpmath.cot(d / w) for d, w in pairs)),
        "arc_cot": lambda: n * force * speed * mpmath.tan(sum(mpmath.acot(d / w) for d, w in pairs)),
        "slope_power": lambda: force * speed * sum(2 * d / w for d, w in pairs),
        "lift_work": lambda: force * sum(d for d, _ in pairs),
        "viscous_work": lambda: mpmath.pi**2 / 2 * damping * speed * sum(d * d / w for d, w in pairs),
    }
    return sums[reading]()


def surface(rng: np.random.Generator, n: int) -> "tuple[Doubles, Doubles]":
    s = rng.uniform(5e-6, 5e-4, n)
    return s * 10 ** rng.uniform(-4, 0.5, n), s


def test_every_enclosure_holds_the_value_in_400_bits() -> None:
    rng = np.random.default_rng(5000)
    finite = 0
    for n in [1, 2, 3, 10, 100, 1000] * 20:
        delta, s = surface(rng, n)
        for name, line in esc(delta, s, FORCE, SPEED).items():
            exact = truth(delta, s, name)
            lo, hi = line["lo"], line["hi"]
            assert lo is not None and hi is not None and lo <= exact <= hi, (name, n)
            finite += np.isfinite(lo) and np.isfinite(hi)
    assert finite > 580


def test_what_has_no_value_says_so() -> None:
    line = esc([0.0, np.nan], [1.0, 1.0], FORCE, SPEED)["literal"]
    assert line["value"] is None and line["flags"] == ["degenerate"] and line["degenerate"] == 2
    assert esc([], [], FORCE, SPEED)["literal"]["n"] == 0


def test_a_profile_is_that_of_gripctl(tmp_path: Path, gripctl: str) -> None:
    step = 1e-6
    x = step * np.arange(12_500)
    heights = np.round(1e-6 * np.sin(2 * np.pi * x / 80e-6), 12)
    file = tmp_path / "p.csv"
    np.savetxt(file, np.stack([1e3 * x, 1e6 * heights], axis=1), "%.9f", ",", header="x_mm,height_um", comments="")
    command = [gripctl, "profile", str(file), "--speed", "0.05", "--step-um", "1", "--json"]
    ran = subprocess.run(command, capture_output=True, text=True, check=True)
    found = profile(heights, step)
    expected = json.loads(ran.stdout)
    assert found.parameters["n"] == expected["n"] == len(found.irregularities_m) > 100
    assert abs(found.parameters["ra_um"] / expected["ra_um"] - 1) < 1e-9
    assert abs(found.parameters["ra_um"] - 2 / np.pi) < 0.05
    assert found.roughness_m.shape == heights.shape and found.turns_m.shape[1] == 2
    delta, s = found.irregularities_m.T
    assert esc(delta, s, 1.0, 0.05)["literal"]["value"] == found.parameters["esc"][0]["value"]
