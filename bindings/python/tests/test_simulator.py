"""The simulator as an environment, and the controller in its loop."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from slipgrip import Grasp, GraspEnv, Pipeline


def test_the_controller_holds_the_object() -> None:
    env = GraspEnv(duration_s=6.0, seed=5003)
    rows, truth = env.reset()
    pipeline = Pipeline(env.rate_hz, env.channels)
    force, reward = 0.0, 0.0
    while True:
        force, _ = pipeline.step(rows)
        rows, gain, terminated, truncated, truth = env.step(force)
        reward += gain
        if terminated or truncated:
            break
    assert truncated and truth["lifted"] and not truth["dropped"] and not truth["crushed"]
    assert 1.0 <= truth["applied_n"] / truth["needed_n"] < 1.6 and reward > 0.0
    assert pipeline.state == "holding" and pipeline.slips > 0


def test_too_little_drops_it_and_too_much_crushes_it() -> None:
    for force, what in [(0.5, "dropped"), (60.0, "crushed")]:
        env = GraspEnv(seed=5000)
        env.reset()
        terminated = truncated = False
        while not (terminated or truncated):
            _, reward, terminated, truncated, truth = env.step(force)
        assert terminated and reward < 0 and truth[what]  # type: ignore[literal-required]
        with pytest.raises(ValueError, match="reset"):
            env.step(force)


def test_the_same_seed_is_the_same_grasp() -> None:
    one, other = Grasp("default", 5000), Grasp("default", 5000)
    assert np.array_equal(one.step(5.0, 2_000), other.step(5.0, 2_000))
    assert one.truth() == other.truth() != Grasp("default", 5001).truth()
    assert one.step(5.0, 3).shape == (3, len(one.channels))


def test_gymnasium_accepts_it() -> None:
    env: Any = GraspEnv(duration_s=0.5, seed=5000)
    check_env(env, skip_render_check=True)
