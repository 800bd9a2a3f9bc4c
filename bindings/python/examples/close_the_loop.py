"""Close the loop in simulation: sensor rows in, force commands out, a millisecond at a time: python close_the_loop.py [PICTURE]"""

from __future__ import annotations

import numpy as np

from drawing import axes, save
from slipgrip import GraspEnv, Pipeline


def main() -> None:
    env = GraspEnv("default", duration_s=3.0, seed=5003)
    rows, truth = env.reset()
    controller = Pipeline(env.rate_hz, env.channels)
    courses, slips, over = [], [], False
    while not over:
        force, events = controller.step(rows)
        rows, _, terminated, truncated, truth = env.step(force)
        over = terminated or truncated
        slips += [event["t_s"] for event in events if event["type"] == "slip"]
        needed = truth["needed_n"] if truth["lifted"] else np.nan
        courses.append((truth["time_s"], force, truth["applied_n"], needed, 1e3 * truth["slip_m"]))
    print(f"needed {truth['needed_n']:.2f} N, applied {truth['applied_n']:.2f} N, slipped {1e3 * truth['slip_m']:.2f} mm")
    assert truth["lifted"] and not truth["dropped"] and not truth["crushed"]
    assert 1.0 <= truth["applied_n"] / truth["needed_n"] < 1.6

    time, command, applied, needed_n, slip = np.array(courses)[::5].T
    figure, ((force_axis,), (slip_axis,)) = axes(2)
    force_axis.plot(time, command, linewidth=1, label="commanded")
    force_axis.plot(time, applied, linewidth=1, label="applied")
    force_axis.plot(time, needed_n, "k--", linewidth=1, label="needed (no sensor knows it)")
    force_axis.plot(slips, np.zeros(len(slips)), "r^", markersize=5, label="slip noticed", clip_on=False)
    force_axis.set_ylabel("force of a finger (N)")
    force_axis.legend(loc="lower right")
    slip_axis.plot(time, slip, linewidth=1)
    slip_axis.set(xlabel="time (s)", ylabel="slipped (mm)")
    save(figure)


if __name__ == "__main__":
    main()
