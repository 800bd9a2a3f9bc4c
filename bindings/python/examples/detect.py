"""Detect in my recording: python detect.py [PICTURE] [FILE]

Without a file the recording is a simulated grasp with too little force, whose slips are known.
"""

from __future__ import annotations

import sys

import numpy as np

import slipgrip
from drawing import axes, envelope, save
from slipgrip import Recording


def simulated() -> Recording:
    """A finger that holds too loosely twice and is pressed harder each time."""
    grasp = slipgrip.Grasp("default", seed=5003)
    second = round(grasp.rate_hz)
    pieces = [grasp.step(0.0, second // 2), grasp.step(1.2 * grasp.truth()["needed_n"], second)]
    for share in (0.8, 1.3, 0.85, 1.3):
        pieces.append(grasp.step(share * grasp.truth()["needed_n"], second // 15 if share < 1 else second))
    return Recording(np.concatenate(pieces), grasp.rate_hz, grasp.channels, name="simulated grasp")


def main() -> None:
    recording = slipgrip.read(sys.argv[2]) if len(sys.argv) > 2 else simulated()
    print(recording)
    found = slipgrip.detect(recording)
    for event in found.events:
        if event["type"] == "slip":
            speed = event["speed_m_s"]
            how_fast = "" if speed is None else f", {1e3 * speed:.1f} mm/s"
            print(f"{event['t_s']:8.4f} s  slip ({event['phase']}, by {event['method']}{how_fast})")
        elif event["type"] == "slip_end":
            print(f"{event['t_s']:8.4f} s  ended after {1e3 * (event['duration_s'] or 0.0):.1f} ms")
    assert len(sys.argv) > 2 or found.slips >= 2

    figure, ((signal,), (statistic,)) = axes(2)
    name = recording.channels[0]
    signal.plot(*envelope(recording.times, 1e6 * recording[name] if name == "stylus" else recording[name]), linewidth=0.5)
    signal.set_ylabel("stylus (um)" if name == "stylus" else name)
    statistic.semilogy(*envelope(found.t_s, np.maximum(found.statistic, 1e-2)), linewidth=0.8)
    statistic.axhline(1.0, color="tab:red", linewidth=0.8, label="interval")
    slipping = found.scene == slipgrip.SCENES.index("slipping")
    statistic.fill_between(
        found.t_s[::50], 0, 1, where=slipping[::50], transform=statistic.get_xaxis_transform(), alpha=0.2, label="slip"
    )
    statistic.set(xlabel="time (s)", ylabel="evidence / interval")
    statistic.legend(loc="upper left")
    save(figure)


if __name__ == "__main__":
    main()
