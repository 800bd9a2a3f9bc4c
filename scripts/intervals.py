#!/usr/bin/env python3
"""90 % intervals of `gripctl train --interval 0.9` on rows that no training saw: how many truths they hold, and how wide they are.

Usage: scripts/intervals.py PROGRAMS [--seed N] [--sets N]

PROGRAMS is the folder of gripctl. Rows: `gripctl generate --source trial` with 3 % noise, 100 for training, 2,000 unseen. Prints the table of
docs/results/learning.md.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

COLUMNS = ["--inputs", "slip_acceleration_m_s2,trial_force_n:ln", "--target", "adequate_force_n:ln"]
LEARNERS = {
    "gd": ["--algorithm", "gd"],
    "RPROP": ["--algorithm", "rprop"],
    "SCG": ["--algorithm", "scg"],
    "LM": ["--algorithm", "lm", "--epochs", "100"],
    "br": ["--algorithm", "br"],
    "ensemble of four": ["--model", "ensemble", "--members", "4"],
    "Gaussian process": ["--model", "gp"],
}


def gripctl(programs, *arguments):
    done = subprocess.run([programs / "gripctl", *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"gripctl {' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def generated(programs, folder, seed):
    for name, count, of in (("train", 100, seed), ("unseen", 2000, seed + 1_000_000)):
        gripctl(programs, "generate", "-o", folder / f"{name}.csv", "--source", "trial", "--rows", count, "--seed", of, "--speed-noise", 0.03,
                "--force-noise", 0.03, "--force")


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("programs", type=pathlib.Path)
    arguments.add_argument("--seed", type=int, default=2_000_000)
    arguments.add_argument("--sets", type=int, default=60)
    args = arguments.parse_args()
    found = {name: [] for name in LEARNERS}
    for at in range(args.sets):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            generated(args.programs, folder, args.seed + 1000 * at)
            for learner, settings in LEARNERS.items():
                model = folder / "model.json"
                trained = gripctl(args.programs, "train", folder / "train.csv", *COLUMNS, *settings, "--interval", 0.9, "--seed", at,
                                  "-o", model, "--force", "--json")
                trained = json.loads(trained.splitlines()[-1])
                unseen = json.loads(gripctl(args.programs, "eval", model, folder / "unseen.csv", "--json"))
                found[learner].append((100 * unseen["coverage"], trained["interval"]["widths"][0], trained["held_out_r2"], unseen["r2"]))
    print("| learner | truths held, mean +- deviation (least - most) | factor | R2 on held-out / unseen rows |\n|---|---|---|---|")
    for learner, sets in found.items():
        held, widths, before, after = zip(*sets)
        print(f"| {learner} | {statistics.mean(held):.1f} +- {statistics.stdev(held):.1f} ({min(held):.0f} - {max(held):.0f}) | {statistics.median(widths):.2f}"
              f" | {statistics.median(before):.3f} / {statistics.median(after):.3f} |")


main()
