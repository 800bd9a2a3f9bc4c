#!/usr/bin/env python3
"""Grasps of gripd in the rows of decision 0088: one object set, sensors and drives from good to bad.

usage: grasp-rows.py GRIPCTL [--trials N] [--seed N] [--rows NAME,..] [--jobs N]
"""
import argparse, concurrent.futures, json, pathlib, subprocess, sys, tempfile

DOCS = pathlib.Path(__file__).resolve().parent.parent / "docs/examples/scenes"
# name: lines of the scene, sensors, stress
ROWS = {
    "good": ("", "scene", "none"),
    "alone": ("", "stylus", "none"),
    "at_once": ((DOCS / "at_once.toml").read_text(), "stylus", "none"),
    "coarse": ("noise.travel_um = 10.0\nnoise.travel_step_um = 20.0", "scene", "none"),
    "noisy": ("noise.travel_um = 9.0", "scene", "none"),
    "late_20": ("reading.travel_delay_ms = 20.0", "scene", "none"),
    "late_50": ("reading.travel_delay_ms = 50.0", "scene", "none"),
    "seldom": (
        "noise.travel_um = 2.0\nnoise.travel_step_um = 5.0\nreading.travel_hz = 500.0\nreading.travel_delay_ms = 3.0",
        "scene", "none",
    ),
    "tenth": ("gain.travel = 0.1", "scene", "none"),
    "pads_5": ("pad.shear_n_mm = 5.0", "scene", "none"),
    "pads_10": ("pad.shear_n_mm = 10.0", "scene", "none"),
    "pads_20": ("pad.shear_n_mm = 20.0", "scene", "none"),
    "pads_10_alone": ("pad.shear_n_mm = 10.0", "stylus", "none"),
    "jitter": ("", "scene", "jitter"),
    "latency": ("", "scene", "latency"),
    "drive_30": ("drive.lag_ms = 30.0", "scene", "none"),
    "drive_50": ("drive.lag_ms = 50.0", "scene", "none"),
    "dead_30": ("drive.delay_ms = 30.0", "scene", "none"),
    "ratio_1.4": ("friction_ratio = 1.4", "scene", "none"),
    "ratio_1.6": ("friction_ratio = 1.6", "scene", "none"),
    "ratio_1.6_alone": ("friction_ratio = 1.6", "stylus", "none"),
    "noise_3": ("", "scene", "noise"),
}


def run(args, name):
    lines, sensors, stress = ROWS[name]
    with tempfile.TemporaryDirectory() as folder:
        scene = pathlib.Path(folder) / f"{name}.toml"
        scene.write_text(lines if "name =" in lines else f'name = "{name}"\n{lines}\n')
        command = [args.gripctl, "grasp", scene, "--sensors", sensors, f"--stress={stress}", "--json"]
        command += ["--trials", str(args.trials), "--seed", str(args.seed)]
        if name == "at_once":
            command += ["--config", DOCS / "gripd.toml"]
        out = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    return json.loads(out.splitlines()[0])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("gripctl")
    parser.add_argument("--trials", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rows", default=",".join(ROWS))
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    print("| row | dropped + crushed | peak over needed | final over needed | final 1.0-1.4 | slip mm |\n|---|---|---|---|---|---|")
    dropped = crushed = 0
    pair = lambda of: "{p50:.2f} / {p95:.2f}".format(**of) if of["p50"] is not None else "-"
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        names = args.rows.split(",")
        for name, row in zip(names, pool.map(lambda name: run(args, name), names)):
            dropped, crushed = dropped + row["dropped"], crushed + row["crushed"]
            within = round(100 * row["within_1_4"] / row["trials"])
            print(f"| {name} | {row['dropped']} + {row['crushed']} | {pair(row['peak_ratio'])} | {pair(row['force_ratio'])} "
                  f"| {within} % | {pair(row['slip_mm'])} |", flush=True)
    print(f"| all {args.trials * len(names)} | {dropped} + {crushed} | | | | |")


if __name__ == "__main__":
    sys.exit(main())
