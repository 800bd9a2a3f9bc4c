#!/usr/bin/env python3
"""Processor time of a training against rows, ours beside scikit-learn's Gaussian process where that is installed.

    scripts/train-times.py GRIPCTL [ROWS..]        100 1000 10000 otherwise

Rows: `gripctl generate --source trial --speed-noise 0.03`, seed 1; tested on 2,000 rows of seed 2. Inputs a and ln F, target ln f; nets
2-10-1, 1,000 epochs at most. Prints seconds of processor time and the share within 10 %; a dash where a learner takes fewer rows.
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import time

GRIPCTL = pathlib.Path(sys.argv[1]).resolve()
ROWS = [int(rows) for rows in sys.argv[2:]] or [100, 1000, 10000]
COLUMNS = ["slip_acceleration_m_s2", "trial_force_n", "adequate_force_n"]
LEARNERS = {name: ["--algorithm", name] for name in ("br", "rprop", "scg")} | {"gp": ["--model", "gp"]}


def gripctl(folder, *args):
    return subprocess.run([GRIPCTL, *args], cwd=folder, capture_output=True, text=True, check=False)


def ours(folder, options):
    columns = ["--inputs", f"{COLUMNS[0]},{COLUMNS[1]}:ln", "--target", f"{COLUMNS[2]}:ln"]
    files = ["rows.csv", "--test", "test.csv", "-o", "model.json", "--force"]
    ran = gripctl(folder, "train", *files, *columns, *options, "--json")
    if ran.returncode:
        return None
    result = json.loads(ran.stdout.splitlines()[-1])
    return result["cpu_s"], result["test_within_10pct"]


def scikit(folder):
    try:
        import numpy as np
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
    except ImportError:
        return None

    def read(name):
        table = np.genfromtxt(folder / name, delimiter=",", names=True)
        a, force, target = (table[column] for column in COLUMNS)
        return np.column_stack([a, np.log(force)]), np.log(target)

    (x, y), (tested, wanted) = read("rows.csv"), read("test.csv")
    if len(x) > 3000:
        return None
    middle, spread = x.mean(0), x.std(0)
    kernel = ConstantKernel() * RBF([1.0, 1.0]) + WhiteKernel(0.01)
    process = GaussianProcessRegressor(kernel, normalize_y=True, n_restarts_optimizer=1, random_state=0)
    before = time.process_time()
    process.fit((x - middle) / spread, y)
    seconds = time.process_time() - before
    off = np.exp(process.predict((tested - middle) / spread) - wanted) - 1
    return seconds, float(np.mean(abs(off) <= 0.1))


def cell(found):
    return "-" if found is None else f"{found[0]:.2f} s, {100 * found[1]:.1f} %"


print("| rows | " + " | ".join(LEARNERS) + " | scikit-learn's GP |\n" + "|---" * (len(LEARNERS) + 2) + "|")
with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    noise = ["--source", "trial", "--speed-noise", "0.03"]
    gripctl(folder, "generate", "-o", "test.csv", "--rows", "2000", "--seed", "2", *noise)
    for rows in ROWS:
        gripctl(folder, "generate", "-o", "rows.csv", "--rows", str(rows), "--seed", "1", "--force", *noise)
        cells = [cell(ours(folder, options)) for options in LEARNERS.values()] + [cell(scikit(folder))]
        print(f"| {rows} | " + " | ".join(cells) + " |", flush=True)
