"""What the pictures of the examples have in common."""

from __future__ import annotations

import sys
from typing import Any, Tuple

import matplotlib
import numpy as np
import numpy.typing as npt

matplotlib.use("Agg")
import matplotlib.pyplot as plt

plt.rcParams.update(
    {
        "svg.hashsalt": "slipgrip",
        "svg.fonttype": "none",
        "font.size": 9,
        "axes.grid": True,
        "grid.alpha": 0.3,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "legend.frameon": False,
    }
)


def axes(rows: int, height: float = 5.0) -> Tuple[Any, Any]:
    """A figure with so many axes above each other."""
    return plt.subplots(rows, 1, figsize=(7.0, height), sharex=rows > 1, layout="constrained", squeeze=False)


def envelope(x: npt.NDArray[Any], y: npt.NDArray[Any], points: int = 350) -> Tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """The largest and smallest value of each of so many stretches: a line of any length as a small picture."""
    stretch = max(1, len(y) // points)
    rows = len(y) // stretch
    cut = y[: rows * stretch].reshape(rows, stretch)
    pairs = np.stack([cut.min(axis=1), cut.max(axis=1)], axis=1).ravel()
    return np.repeat(x[: rows * stretch : stretch], 2), pairs


def save(figure: Any) -> None:
    """Writes the picture where the first argument names a file."""
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], metadata={"Date": None})
        print(f"picture: {sys.argv[1]}")
