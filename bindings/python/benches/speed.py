"""Ten minutes at 10 kHz through `detect` beside the pipeline in Rust, and a push of 1 ms: python speed.py RUST_TIME

RUST_TIME is the program that `cargo build --release --example rust_time` makes; it needs numpy and slipgrip. Processor time, which other work on
the machine changes less than the time of day, the least of nine rounds in turns.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import slipgrip

RATE, ROUNDS = 10_000, 9


def main() -> None:
    x = np.random.default_rng(5000).standard_normal(600 * RATE).astype(np.float32)
    for at in range(300_000, len(x), 550_000):
        x[at : at + 3000] *= 8
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "x.f32"
        x.tofile(file)
        ours, theirs = [], []
        for _ in range(ROUNDS):
            begin = time.process_time()
            slipgrip.detect(x, RATE)
            ours.append(time.process_time() - begin)
            ran = subprocess.run([sys.argv[1], str(file), str(RATE)], capture_output=True, text=True, check=True)
            theirs.append(json.loads(ran.stdout))
    samples, rows = (min(times[name] for times in theirs) for name in ("samples_s", "rows_s"))
    print(f"10 min: {min(ours):.3f} s; over Rust with its samples in memory {min(ours) / samples:.2f}, that makes them {min(ours) / rows:.2f}")
    detector, pushes = slipgrip.Detector(RATE), []
    for block in np.split(x[:1_000_000], 100_000):
        before = time.perf_counter_ns()
        detector.push(block)
        pushes.append(time.perf_counter_ns() - before)
    print("push of 1 ms: p50 {:.2f}, p99 {:.2f} us".format(*np.percentile(pushes, [50, 99]) / 1e3))


if __name__ == "__main__":
    main()
