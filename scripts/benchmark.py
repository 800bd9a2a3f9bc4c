#!/usr/bin/env python3
"""Scores every detector on every set of recordings and prints the tables of docs/benchmark.md.

usage: benchmark.py GRIPCTL DATA [MOTION...]
  GRIPCTL   a release build of gripctl
  DATA      the folder of recordings (CONTRIBUTING.md, Data)
  MOTION    folders made by a generator of slips under motion: each with set/labels.csv and work.csv
Needs Python 3.9 and nothing else. Nothing is written but to a temporary folder.
"""
import json, pathlib, shutil, subprocess, sys, tempfile

STYLUS = ["default", "stylus", "esc", "esc_literal", "nn"]
DETECTORS = [*STYLUS, "travel", "pressure", "fused"]


def score(gripctl, folder, detectors, *more):
    command = [gripctl, "score", str(folder), "--json", "--detectors", ",".join(detectors), *more]
    ran = subprocess.run(command, capture_output=True, text=True)
    if ran.returncode != 0:
        return None, ran.stderr.strip().splitlines()[-1]
    return [json.loads(line) for line in ran.stdout.splitlines()], ""


def number(value, digits=1):
    return "-" if value is None else f"{value:.{digits}f}"


def span(interval, digits=1):
    return "-" if interval is None else f"{interval[0]:.{digits}f} to {interval[1]:.{digits}f}"


def rows(lines, detector, name=None):
    total = next(line for line in lines if line.get("type") == "total" and line["detector"] == detector)
    slips, chance = [], []
    for kind, missed in (("onsets", "missed"), ("steady", "steady_missed")):
        if total[kind]:
            inside = total["inside"] if kind == "onsets" else 0
            found = f"{total[kind] - total[missed] - inside} of {total[kind]}"
            slips.append(f"{found} ({inside} inside)" if inside else found)
            by = total[f"{kind}_chance"]
            chance.append(f"{by['found']:.1f} (p {by['p']:.0e})" if by else "-")
    early = str(total["early"]) if total["onsets"] else "-"
    latency = total["latency_ms"] if total["onsets"] else total["steady_ms"]
    causes = [line for line in lines if line.get("type") == "cause" and line["detector"] == detector]
    counted = [f"{c['cause']} {c['alarms']} in {c['seconds']:.1f} s, {c['in_alarm_s']:.1f} s in alarm ({span(c['per_hour_ci'], 0)})" for c in causes]
    return (f"| {name or detector} | {', '.join(slips) or '-'} | {', '.join(chance) or '-'} | {early} | "
            f"{number(latency['p50'])} / {number(latency['p95'])} | {'; '.join(counted) or '-'} |")


def head(title):
    print(f"\n### {title}\n")
    print("| detector | found | by chance | early | latency p50 / p95 (ms) | alarms without slip, by cause (per hour, 95 %) |")
    print("|---|---|---|---|---|---|")


def table(gripctl, title, folder, detectors, *more):
    head(title)
    for detector in detectors:
        # One by one: a set may not train the network of nn.
        lines, error = score(gripctl, folder, [detector], *more)
        reason = error.removeprefix("gripctl: ").removeprefix("error: ")
        print(f"| {detector} | not scored: {reason} | | | | |" if lines is None else rows(lines, detector), flush=True)


def sliding(data, folder):
    """The hand-held stylus has no labels: it slides all the time."""
    names = sorted(data.glob("texture*.csv"))
    for file in names:
        head, rest = file.read_text().split("\n", 1)
        (folder / file.name).write_text(head.replace("acceleration", "vibration") + "\n" + rest)
    labels = "".join(f"{file.stem},steady,{file.stem},\n" for file in names)
    (folder / "labels.csv").write_text("recording,kind,material,onset_s\n" + labels)


def in_unit(source, folder, factor):
    """The vibration alone, in another unit."""
    shutil.copy(source / "labels.csv", folder)
    for file in source.glob("*.csv"):
        if file.name == "labels.csv":
            continue
        lines = file.read_text().splitlines()
        place = lines[0].split(",").index("vibration")
        cells = (line.split(",") for line in lines[1:])
        text = "".join(f"{row[0]},{factor * float(row[place])!r}\n" for row in cells)
        (folder / file.name).write_text("t_s,vibration\n" + text)


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    gripctl, data = sys.argv[1], pathlib.Path(sys.argv[2])
    stylus, arrays = STYLUS, ["pressure"]
    table(gripctl, "biotac_slide, floors of the other materials", data / "biotac_slide", DETECTORS)
    table(gripctl, "taxels_dos", data / "taxels_dos", arrays)
    table(gripctl, "papillarray", data / "papillarray", arrays)
    table(gripctl, "papillarray, noise learned live", data / "papillarray", arrays, "--floor", "live")
    table(gripctl, "imu_manipulation, m/s2", data / "imu_manipulation", stylus, "--floor", "live")
    with tempfile.TemporaryDirectory() as folder:
        in_unit(data / "imu_manipulation", pathlib.Path(folder), 1 / 9.80665)
        table(gripctl, "imu_manipulation, g, without reference", folder, stylus, "--floor", "live")
    with tempfile.TemporaryDirectory() as folder:
        sliding(data / "stylus_accel_1k", pathlib.Path(folder))
        table(gripctl, "stylus_accel_1k", folder, stylus, "--floor", "live")
    for motion in map(pathlib.Path, sys.argv[3:]):
        title = f"slips under motion, {motion.name}, uncalibrated, floors live"
        table(gripctl, title, motion / "set", stylus, "--floor", "live")


if __name__ == "__main__":
    main()
