"""Time and latency of slipgrip beside what Python has for it, on the same data: python compare.py RUST_TIME [--speed]

RUST_TIME is the program that `cargo build --release --example rust_time` makes. Prints one JSON object a line; with
--speed only times.

The data: white noise, then noise that crackles, and 100 slips of 0.2 s at 10 kHz, 100 to 800 Hz, of several
strengths, 2 s apart. Each other detector has its threshold set on ten minutes of noise without slip, to one false
alarm in these: the level that its statistic reaches once. slipgrip is calibrated on ten minutes of other noise, and
its false alarms in these ten minutes are counted. The latency is from the onset to the first row at which a detector
can know. Every statistic is causal.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple

import numpy as np
import numpy.typing as npt
import ruptures
from river import drift
from scipy import signal

import slipgrip

RATE = 10_000
BLOCK = 10
SLIPS, SLIP_S, APART_S, GUARD_S = 100, 0.2, 2.0, 4.0
STRENGTHS = (0.5, 1.0, 2.0, 4.0)
ROUNDS = 9
Signal = npt.NDArray[np.float32]
Statistic = Callable[[Signal], npt.NDArray[np.float64]]


def noise(seconds: float, seed: int, kind: str = "white") -> Signal:
    """White noise, alone or with a crackle: every other second 3 ms are two to five times as strong."""
    rng = np.random.default_rng(seed)
    x = rng.standard_normal(round(seconds * RATE)).astype(np.float32)
    if kind == "crackle":
        for at in rng.integers(round(GUARD_S * RATE), len(x) - 30, round(seconds / 2)):
            x[at : at + 30] *= rng.uniform(2.0, 5.0)
    return x


def with_slips(strength: float, seed: int, kind: str) -> Tuple[Signal, npt.NDArray[np.int64]]:
    """Noise with slips, whose rms in 100 to 800 Hz is so many times that of the whole noise."""
    x = noise(GUARD_S + SLIPS * APART_S, seed, kind)
    rng = np.random.default_rng(seed + 1)
    onsets = np.round((GUARD_S + np.arange(SLIPS) * APART_S + rng.uniform(0, 1, SLIPS)) * RATE).astype(np.int64)
    rows = round(SLIP_S * RATE)
    sos = signal.butter(4, (100, 800), "bandpass", fs=RATE, output="sos")
    for at in onsets:
        slip = signal.sosfilt(sos, rng.standard_normal(rows + 1000))[1000:]
        x[at : at + rows] += (strength * slip / slip.std()).astype(np.float32)
    return x, onsets


SOS = [signal.butter(2, band, "bandpass", fs=RATE, output="sos") for band in ((20, 400), (100, 800), (800, 3200))]


def sos_energy(x: Signal) -> npt.NDArray[np.float64]:
    """The largest energy of three bands over its rest, in blocks of 1 ms with an envelope of 5 ms."""
    levels = []
    for sos in SOS:
        y = signal.sosfilt(sos, x)
        energy = (y**2)[: len(y) // BLOCK * BLOCK].reshape(-1, BLOCK).mean(axis=1)
        smooth = signal.lfilter([0.2], [1, -0.8], energy)
        levels.append(smooth / np.median(smooth[: 2 * RATE // BLOCK]))
    return np.max(levels, axis=0)


def detections(statistic: npt.NDArray[np.float64], threshold: float, step: int) -> npt.NDArray[np.int64]:
    """Rows after which the statistic has risen above the threshold."""
    above = statistic > threshold
    return (np.flatnonzero(above[1:] & ~above[:-1]) + 2) * step


def once_in(statistic: npt.NDArray[np.float64], skip: int) -> float:
    """The level that noise reaches once: above it there is one false alarm in all of it."""
    return float(np.sort(statistic[skip:])[-2])


def latencies(rows: npt.NDArray[np.int64], onsets: npt.NDArray[np.int64]) -> List[float]:
    """Milliseconds from each onset that was found within its slip."""
    found = []
    for at in onsets:
        inside = rows[(rows > at) & (rows <= at + SLIP_S * RATE)]
        if len(inside):
            found.append(1e3 * (inside[0] - at) / RATE)
    return found


def line(name: str, what: str, **values: Any) -> None:
    print(json.dumps({"detector": name, "what": what, **values}), flush=True)


def report(name: str, strength: float, rows: npt.NDArray[np.int64], onsets: npt.NDArray[np.int64]) -> None:
    found = latencies(rows, onsets)
    p50, p95 = np.percentile(found, [50, 95]).round(2) if found else (None, None)
    line(name, "slips", strength=strength, found=len(found), of=SLIPS, p50_ms=p50, p95_ms=p95)


def processor_s(run: Callable[[], Any]) -> float:
    """Processor time of a call, which other work on the machine changes less than the time of day."""
    begin = time.process_time()
    run()
    return time.process_time() - begin


def beside_rust(rust_time: str) -> None:
    """Ten minutes at 10 kHz through `detect` and through the pipeline in Rust, in turns."""
    x = noise(600, 5000)
    for at in range(300_000, len(x), 550_000):
        x[at : at + 3000] *= 8
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "x.f32"
        x.tofile(file)
        ours, samples, rows = [], [], []
        for _ in range(ROUNDS):
            ours.append(processor_s(lambda: slipgrip.detect(x, RATE)))
            ran = subprocess.run([rust_time, str(file), str(RATE)], capture_output=True, text=True, check=True)
            times = json.loads(ran.stdout)
            samples.append(times["samples_s"])
            rows.append(times["rows_s"])
    ratio = min(ours) / min(samples)
    line("slipgrip", "10 min at 10 kHz", s=round(min(ours), 3), rust_samples_s=min(samples), rust_rows_s=min(rows), ratio=round(ratio, 2))
    detector, pushes = slipgrip.Detector(RATE), []
    for block in np.split(x[:1_000_000], 100_000):
        begin = time.perf_counter_ns()
        detector.push(block)
        pushes.append(time.perf_counter_ns() - begin)
    p50, p99 = (np.percentile(pushes, [50, 99]) / 1e3).round(2)
    line("slipgrip", "push of 1 ms", p50_us=p50, p99_us=p99)


def ours(rest: Signal, cases: List[Tuple[float, Signal, npt.NDArray[np.int64]]], kind: str) -> None:
    made = slipgrip.calibrate(noise(600, 5010, kind), RATE, interval_s=600)
    for name, calibration in (("slipgrip, defaults", None), ("slipgrip, calibrated", made)):

        def rows(x: Signal, calibration: Optional[slipgrip.Calibration] = calibration) -> npt.NDArray[np.int64]:
            events = slipgrip.detect(x, RATE, calibration=calibration).events
            return np.array([e["sample"] + 1 for e in events if e["type"] == "slip"], dtype=np.int64)

        line(name, "noise", false_alarms=len(rows(rest)))
        for strength, x, onsets in cases:
            report(name, strength, rows(x), onsets)


def by_statistic(
    name: str, statistic: Statistic, step: int, rest: Signal, cases: List[Tuple[float, Signal, npt.NDArray[np.int64]]]
) -> None:
    skip = round(GUARD_S * RATE) // step
    threshold = once_in(statistic(rest), skip)
    line(name, "noise", false_alarms=1, threshold=round(threshold, 3))
    for strength, x, onsets in cases:
        report(name, strength, detections(statistic(x), threshold, step), onsets)


def block_energy(x: Signal) -> npt.NDArray[np.float64]:
    """Energy of 100 to 800 Hz over its rest in the first two seconds, in blocks of 1 ms."""
    energy = (signal.sosfilt(SOS[1], x) ** 2)[: len(x) // BLOCK * BLOCK].reshape(-1, BLOCK).mean(axis=1)
    return np.asarray(energy / np.median(energy[: 2 * RATE // BLOCK]))


def page_hinkley(threshold: float) -> drift.PageHinkley:
    return drift.PageHinkley(min_instances=100, delta=1.0, threshold=threshold, alpha=0.999, mode="up")


def river_page_hinkley(x: Signal) -> npt.NDArray[np.float64]:
    """river's Page-Hinkley test of that energy: its sum over the smallest so far."""
    energy, test = block_energy(x), page_hinkley(1e18)
    out = np.empty(len(energy))
    for at, value in enumerate(energy):
        test.update(float(value))
        out[at] = test._sum_increase - test._min_increase
    return out


def adwin_alarms(x: Signal, delta: float) -> npt.NDArray[np.int64]:
    """Rows at which river's ADWIN alarms on the logarithm of the energy in blocks of 1 ms."""
    test, rows = drift.ADWIN(delta=delta, clock=1, min_window_length=5, grace_period=10), []
    for at, value in enumerate(np.log(block_energy(x) + 1e-12)):
        test.update(float(value))
        if test.drift_detected:
            rows.append((at + 1) * BLOCK)
    return np.array(rows, dtype=np.int64)


def river_page_hinkley_alarms(rest: Signal, cases: List[Tuple[float, Signal, npt.NDArray[np.int64]]]) -> None:
    """The threshold from its statistic in noise; then the test itself, which starts anew after each alarm."""
    name = "river Page-Hinkley"
    threshold = once_in(river_page_hinkley(rest), round(GUARD_S * RATE) // BLOCK)
    line(name, "noise", false_alarms=1, threshold=round(threshold, 3))
    for strength, x, onsets in cases:
        energy = block_energy(x)
        test, rows = page_hinkley(threshold), []
        for at, value in enumerate(energy):
            test.update(float(value))
            if test.drift_detected:
                rows.append((at + 1) * BLOCK)
        report(name, strength, np.array(rows, dtype=np.int64), onsets)


def river_adwin(rest: Signal, cases: List[Tuple[float, Signal, npt.NDArray[np.int64]]]) -> None:
    """ADWIN has no threshold but delta: the largest of these with at most one false alarm in the noise."""
    for delta in (1e-3, 1e-5, 1e-9, 1e-20, 1e-50):
        false = len(adwin_alarms(rest, delta))
        if false <= 1:
            break
    line("river ADWIN", "noise", false_alarms=false, delta=delta)
    for strength, x, onsets in cases:
        report("river ADWIN", strength, adwin_alarms(x, delta), onsets)


def ruptures_window(x: Signal) -> npt.NDArray[np.float64]:
    """ruptures' sliding window over the rms in blocks of 1 ms: gain of a change 10 ms ago."""
    energy, half = np.sqrt(block_energy(x)), 10
    window = ruptures.Window(width=2 * half, model="l2", min_size=2, jump=1).fit(energy)
    score = np.zeros(len(energy))
    # score[i] belongs to a change at window.inds[i]; it is known when the window has passed it.
    gains = np.asarray(window.score, dtype=np.float64)
    at = np.asarray(window.inds) + half - 1
    score[at[at < len(score)]] = gains[: np.sum(at < len(score))]
    return score


def times() -> None:
    """Processor time for ten minutes of noise: ten times that for one minute."""
    runs: Dict[str, Callable[[Signal], Any]] = {
        "slipgrip": lambda x: slipgrip.detect(x, RATE),
        "scipy sosfilt, three bands": sos_energy,
        "river Page-Hinkley": river_page_hinkley,
        "river ADWIN": lambda x: adwin_alarms(x, 1e-3),
        "ruptures Window, l2": ruptures_window,
    }
    x = noise(60, 5020)
    for name, run in runs.items():
        seconds = min(processor_s(lambda: run(x)) for _ in range(3))
        line(name, "10 min of noise", s=round(10 * seconds, 2))


def main() -> None:
    beside_rust(sys.argv[1])
    times()
    if "--speed" in sys.argv:
        return
    for kind in ("white", "crackle"):
        line("all", f"{kind} noise")
        rest = noise(600, 5020, kind)
        cases = [(strength, *with_slips(strength, 5030 + k, kind)) for k, strength in enumerate(STRENGTHS)]
        ours(rest, cases, kind)
        by_statistic("scipy sosfilt, three bands", sos_energy, BLOCK, rest, cases)
        river_page_hinkley_alarms(rest, cases)
        river_adwin(rest, cases)
        by_statistic("ruptures Window, l2", ruptures_window, BLOCK, rest, cases)


if __name__ == "__main__":
    main()
