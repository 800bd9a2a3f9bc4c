"""Calibrate: slack for my sensor from a minute without slip: python calibrate.py [PICTURE]

The sensor of this example has a noise with heavy tails, as cables and gears make it. The defaults, which know
nothing of that, alarm where nothing slips; the calibration asks for one false alarm in ten minutes.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

import slipgrip
from drawing import axes, save

RATE = 2_000.0


def rest(seconds: float, seed: int) -> npt.NDArray[np.float32]:
    """Noise of a sensor in its own unit: white, with a crackle of 3 ms every other second."""
    rng = np.random.default_rng(seed)
    rows = round(seconds * RATE)
    x = rng.standard_normal(rows)
    for at in rng.integers(0, rows - 10, round(seconds / 2)):
        x[at : at + 6] *= rng.uniform(2.0, 5.0)
    return x.astype(np.float32)


def main() -> None:
    made = slipgrip.calibrate(rest(120.0, 5000), RATE, interval_s=600.0)
    assert made.slack is not None
    print("slack:", np.round(made.slack, 1))
    print("not certified:", made.not_certified)

    # Ten minutes that were not used, and then slips of growing strength.
    fresh = rest(600.0, 5001)
    before, after = slipgrip.detect(fresh, RATE), slipgrip.detect(fresh, RATE, calibration=made)
    print(f"false alarms in 10 min: {before.slips} by default, {after.slips} calibrated")
    assert after.slips <= 3

    strengths = np.geomspace(0.3, 6.0, 14)
    shares = {"default": [], "calibrated": []}  # type: dict[str, list[float]]
    for strength in strengths:
        for name, calibration in (("default", None), ("calibrated", made)):
            shares[name].append(found(strength, calibration))
    assert shares["calibrated"][-1] == 1.0

    figure, ((axis,),) = axes(1, 3.2)
    for name, share in shares.items():
        alarms = before.slips if name == "default" else after.slips
        axis.semilogx(strengths, 100 * np.array(share), marker="o", markersize=3, label=f"{name}: {alarms} false alarms in 10 min")
    axis.set_xticks([0.3, 0.5, 1, 2, 4], ["0.3", "0.5", "1", "2", "4"])
    axis.minorticks_off()
    axis.set(xlabel="vibration of the slip / noise (rms, 100 to 400 Hz)", ylabel="slips found (%)")
    axis.legend()
    save(figure)


def found(strength: float, calibration: "slipgrip.Calibration | None") -> float:
    """The share of 20 slips of 0.1 s that is found."""
    rng = np.random.default_rng(5002)
    x = rest(25.0, 5003)
    onsets = [round((4.0 + k) * RATE) for k in range(20)]
    for at in onsets:
        x[at : at + 200] += band(rng, 200) * strength
    events = slipgrip.detect(x, RATE, calibration=calibration).events
    starts = np.array([event["sample"] for event in events if event["type"] == "slip"])
    return float(np.mean([np.any((starts >= at) & (starts < at + 250)) for at in onsets]))


def band(rng: np.random.Generator, rows: int) -> npt.NDArray[np.float32]:
    """Noise of 100 to 400 Hz, as strong as the sensor's whole noise."""
    spectrum = np.fft.rfft(rng.standard_normal(rows))
    hertz = np.fft.rfftfreq(rows, 1 / RATE)
    x = np.fft.irfft(np.where((hertz >= 100) & (hertz <= 400), spectrum, 0), rows)
    return np.asarray(x / x.std(), dtype=np.float32)


if __name__ == "__main__":
    main()
