#!/usr/bin/env python3
"""Rows as people send them, made up with a fixed seed: a table of force sensors and a drilling log, for docs/examples/tables.md.

    scripts/example-rows.py [DIR]        docs/examples otherwise

Force sensors: three resistive sensors of one kind with a 10 kOhm divider and a 10-bit converter. Conductance grows with force and its
square, gain differs by 4 % between sensors and falls with temperature; raw readings have 2 counts of noise. Drilling: 42 holes with
three drills; wear grows with the holes drilled, thrust with feed and wear, roughness with feed and, weakly, wear.
"""
import csv
import math
import pathlib
import random
import sys


def force_sensors(rng):
    yield "sensor", "raw", "temperature_c", "force_n"
    for sensor in "ABC":
        gain = 1 + rng.gauss(0, 0.04)
        for _ in range(80):
            force, temperature = rng.uniform(2, 70), rng.uniform(15, 40)
            conductance = gain * (1 - 0.003 * (temperature - 25)) * (4.0 * force + 0.06 * force**2) * 1e-6
            raw = 1023 * conductance * 1e4 / (1 + conductance * 1e4) + rng.gauss(0, 2)
            yield sensor, round(raw), round(temperature, 1), round(force, 2)


def drilling(rng):
    yield "drill", "hole", "feed_mm_rev", "speed_rpm", "thrust_n", "wear_mm", "roughness_um"
    for drill in (1, 2, 3):
        wear = 0.02
        for hole in range(1, 15):
            feed, speed = rng.choice((0.08, 0.12, 0.16, 0.2)), rng.choice((800, 1000, 1200))
            wear += rng.uniform(0.008, 0.02) * (speed / 1000)
            thrust = 2600 * feed**0.8 * (1 + 1.5 * wear) * math.exp(rng.gauss(0, 0.03))
            roughness = 0.8 + 9 * feed + 2.5 * wear + rng.gauss(0, 0.25)
            yield drill, hole, feed, speed, round(thrust), round(wear, 3), round(roughness, 2)


folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent / "docs/examples")
for name, rows in (("force-sensors.csv", force_sensors), ("drilling.csv", drilling)):
    with open(folder / name, "w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows(rows(random.Random(59)))
