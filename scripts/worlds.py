#!/usr/bin/env python3
"""Leave one world out: a network learns from what gripd measured in all worlds but one, and is judged in that one.

Usage: scripts/worlds.py PROGRAMS [--trials N] [--seed N] [--built-in]

PROGRAMS is the folder of gripctl. Rows for the trainings come from seeds 30000 and following, those that judge from --seed. Beside the network
stand the closed formula, the model that is built in, and the mean of the training. The networks state an interval from the worlds they learn of, each
held out once; the one of the built-in model is made anew from the other worlds: the worst of them. Prints the table of docs/results/learning.md and
the width over all worlds, which stands in the file of the built-in model.
"""

import argparse
import csv
import json
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile

# Loads come at once: while one still grows nobody can know what it will need.
WORLDS = {
    "rigid": "",
    "soft_pads": "[pad]\nshear_n_mm = 15.0\n",
    "rubber": "friction_power = 0.6667\n",
    "stribeck": "friction_ratio = 1.3\n[pad]\nstribeck_mm_s = 10.0\n",
    "viscous": "viscous_n_s_m = 60.0\n",
    "swinging": "[shake]\namplitude_m_s2 = 1.5\nfrequency_hz = 4.0\n",
    "slow_drive": "[drive]\nlag_ms = 30.0\n",
    "optical_flow": "[noise]\ntravel_um = 2.0\ntravel_step_um = 5.0\n[reading]\ntravel_hz = 500.0\ntravel_delay_ms = 3.0\n",
    "force_250_hz": "[noise]\nforce_mn = 50.0\n[reading]\nforce_hz = 250.0\n",
}
FEW = ["slip_acceleration_m_s2", "trial_force_n:ln"]
MANY = FEW + ["slip_speed_m_s", "micro_displacement_m", "contact_time_s"]
MARGIN = 1.2
G_M_S2 = 9.80665
LEVEL = 0.9
SIGMAS = 1.645


def gripctl(programs, *arguments):
    done = subprocess.run([programs / "gripctl", *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"gripctl {' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def grasps(programs, world, seeds, rows, model="default"):
    """Grasps of a world: totals, and the rows of its slips."""
    seed, trials = seeds
    printed = gripctl(programs, "grasp", world, "--seed", seed, "--trials", trials, "--rows", rows, "--model", model, "--json")
    with open(rows, newline="") as file:
        return json.loads(printed.splitlines()[-1]), list(csv.DictReader(file))


def formula(row):
    left = 1.0 - float(row["slip_acceleration_m_s2"]) / G_M_S2
    return MARGIN * float(row["trial_force_n"]) / left if left > 0.0 else math.inf


def errors(rows, estimate):
    """Median and 95 % of |estimate / adequate - 1|, in per cent."""
    off = sorted(abs(estimate(row) / float(row["adequate_force_n"]) - 1.0) for row in rows)
    return f"{100 * statistics.median(off):.0f} / {100 * off[int(0.95 * len(off))]:.0f}"


def held(rows):
    """Share of the rows with a stated interval that holds the truth, in per cent."""
    stated = [row for row in rows if row["estimate_lo_n"]]
    inside = [float(row["estimate_lo_n"]) <= float(row["adequate_force_n"]) <= float(row["estimate_hi_n"]) for row in stated]
    return f"{100 * sum(inside) / len(inside):.0f}" if inside else "-"


def squares(row):
    """What an estimate missed by as a logarithm, squared, and what of that the noise of the sensor explains."""
    estimate = float(row["estimate_n"])
    noise = SIGMAS * float(row["estimate_sigma_n"]) / estimate
    return math.log(float(row["adequate_force_n"]) / estimate) ** 2, noise**2


def width(rows):
    """The width (as a logarithm) with which the interval of the built-in model holds the truth in so many of the rows."""
    beyond = sorted(off - noise for off, noise in map(squares, rows))
    return math.sqrt(max(beyond[min(len(beyond), math.ceil(LEVEL * (len(beyond) + 1))) - 1], 0.0))


def held_by(rows, width):
    """Share of the rows that an interval of that width holds, in per cent."""
    return f"{100 * sum(off <= width**2 + noise for off, noise in map(squares, rows)) / len(rows):.0f}"


def stated(rows):
    """Those with an interval: estimated within the range of the model."""
    return [row for row in rows if row["estimate_lo_n"]]


def write(rows, path):
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("programs", type=pathlib.Path)
    arguments.add_argument("--trials", type=int, default=60)
    arguments.add_argument("--seed", type=int, default=990_000)
    arguments.add_argument("--built-in", action="store_true", help="train no networks: their columns stay empty")
    args = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        judge(args, pathlib.Path(folder))


def judge(args, folder):
    learned = {}
    for name, keys in WORLDS.items():
        (folder / f"{name}.toml").write_text(f'name = "{name}"\nlift_ramp_s = 0.0\n{keys}')
        _, learned[name] = grasps(args.programs, folder / f"{name}.toml", (30_000, args.trials), folder / "rows.csv")
    print("| world left out | rows | mean | formula | built in | network, 2 inputs | network, 5 inputs | 90 % interval holds, built in / 2 / 5 inputs"
          " | its factor, built in / 2 / 5 inputs | dropped + crushed, built in / 2 / 5 inputs |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    widths = {name: width(stated(rows)) for name, rows in learned.items()}
    for name in WORLDS:
        others = [row for other, rows in learned.items() if other != name for row in rows]
        write(others, folder / "others.csv")
        world, seeds = folder / f"{name}.toml", (args.seed, args.trials)
        total, rows = grasps(args.programs, world, seeds, folder / "rows.csv")
        mean = math.exp(statistics.mean(math.log(float(row["adequate_force_n"])) for row in others))
        answered = [row for row in rows if row["estimate_n"]]
        built_in = errors(answered, lambda row: float(row["estimate_n"]))
        worst = max(width for other, width in widths.items() if other != name)
        nets, fates = [], [f"{total['dropped']} + {total['crushed']}"]
        shares, factors = [held_by(stated(answered), worst)], [f"{math.exp(worst):.1f}"]
        for inputs in () if args.built_in else (FEW, MANY):
            model = folder / "model.json"
            gripctl(args.programs, "train", folder / "others.csv", "--inputs", ",".join(inputs), "--target", "adequate_force_n:ln",
                    "--algorithm", "scg", "--epochs", "600", "--interval", LEVEL, "--split-by", "scene", "--output", model)
            factors.append(f"{json.loads(model.read_text())['interval']['widths'][0]:.1f}")
            fate, found = grasps(args.programs, world, seeds, folder / "rows.csv", model)
            found = [row for row in found if row["estimate_n"]]
            nets.append(errors(found, lambda row: float(row["estimate_n"])))
            shares.append(held(found))
            fates.append(f"{fate['dropped']} + {fate['crushed']}")
        print(f"| {name} | {len(rows)} | {errors(rows, lambda _: mean)} | {errors(rows, formula)} | {built_in} | {' | '.join(nets or '--')}"
              f" | {' / '.join(shares)} | {' / '.join(factors)} | {' / '.join(fates)} |", flush=True)
    print(f"over all worlds the built-in model needs the factor {math.exp(max(widths.values())):.2f}")


main()
