"""The clock estimate against a known clock."""

from __future__ import annotations

import random

import pytest
from grip_link.clock import ClockSync, PongVerdict
from grip_link.messages import Pong


def pong(true_us: float, out_us: float, back_us: float, ppm: float = 0.0) -> tuple[Pong, int]:
    """A PING sent at ``true_us``; the MCU counts microseconds from 1000 s on, ``ppm`` too fast."""
    rx = 1e9 + (true_us + out_us) * (1 + ppm * 1e-6)
    return Pong(round(true_us), round(rx), round(rx + 10)), round(true_us + out_us + 10 + back_us)


@pytest.mark.parametrize("ppm", [0.0, 80.0, -60.0])
def test_offset_and_drift(ppm: float) -> None:
    rng = random.Random(7)
    clock = ClockSync(1_000_000, 1)
    assert clock.host_us(5) is None and clock.tick(5) is None and clock.drift_ppm is None and clock.sigma_us is None
    for second in range(200):
        jitter = rng.expovariate(1 / 30)
        verdict = clock.push(*pong(second * 1e6, 100 + jitter, 100 + rng.expovariate(1 / 30), ppm))
        assert verdict in (PongVerdict.KEPT, PongVerdict.SLOW)
    at_us = 199.5e6
    tick = 1e9 + at_us * (1 + ppm * 1e-6)
    host = clock.host_us(round(tick))
    assert host == pytest.approx(at_us, abs=clock.uncertainty_us)
    assert clock.tick(at_us) == pytest.approx(tick, abs=clock.uncertainty_us)
    assert clock.drift_ppm == pytest.approx(ppm, abs=1.0)
    assert 100 <= clock.uncertainty_us <= 110 and clock.points > 40


def test_late_answers_are_slow_and_impossible_ones_refused() -> None:
    clock = ClockSync(1_000_000, 1)
    for k in range(8):
        assert clock.push(*pong(k * 50_000, 100, 100)) is PongVerdict.KEPT
    assert clock.push(*pong(1e6, 100, 16_000)) is PongVerdict.SLOW
    assert clock.push(Pong(100, 5, 6), 99) is PongVerdict.IMPOSSIBLE
    assert clock.push(Pong(100, 6, 5), 200) is PongVerdict.IMPOSSIBLE
    assert clock.push(Pong(100, 5, 500), 200) is PongVerdict.IMPOSSIBLE
    assert clock.points == 8


def test_a_jump_of_the_clock_restarts_after_eight_outliers() -> None:
    clock = ClockSync(1_000_000, 1)
    for k in range(10):
        clock.push(*pong(k * 1e6, 100, 100))
    verdicts = []
    for k in range(10, 20):
        question, t4_us = pong(k * 1e6, 100, 100)
        verdicts.append(clock.push(Pong(question.t1_us, question.rx_tick + 10**6, question.tx_tick + 10**6), t4_us))
    assert verdicts == [PongVerdict.OUTLIER] * 7 + [PongVerdict.RESTARTED] + [PongVerdict.KEPT] * 2
