"""``python -m mujoco_gripper``: grasps with gripd in MuJoCo, a table by class of object and a line of JSON for each grasp."""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from . import table
from .items import CLASSES
from .loop import SENSOR_SETS
from .runs import Job, prepare, rows as rows_of


def _options(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m mujoco_gripper", description="Grasps with gripd in the contact physics of MuJoCo, in real time.")
    parser.add_argument("--gripd", type=Path, required=True, help="the daemon, such as target/release/gripd")
    parser.add_argument("--grasps", type=int, default=16, help="objects, each grasped once with each sensor set (%(default)s)")
    parser.add_argument("--first", type=int, default=0, help="number of the first object (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the objects (%(default)s)")
    parser.add_argument("--classes", default=",".join(CLASSES), help="classes of objects, in turn (%(default)s)")
    parser.add_argument("--sensors", default="travel,stylus", help=f"sensor sets of {', '.join(SENSOR_SETS)} (%(default)s)")
    parser.add_argument("--sink", type=float, default=0.0, help="um that the pads let the stylus in for a newton; 0: it has a skid (%(default)s)")
    parser.add_argument("--oracle", action="store_true", help="also hold each object with 1.25 times what it needs")
    parser.add_argument("--jobs", type=int, default=1, help="processes that compute needed forces; grasps run one at a time (%(default)s)")
    parser.add_argument("--late-ms", type=float, default=20.0, help="repeat a grasp that was later than this (%(default)s)")
    parser.add_argument("--realtime", action="store_true", help="ask the system to run the grasps before everything else (Linux, root)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write a line for each grasp to FILE")
    parser.add_argument("--trace", type=Path, metavar="DIR", help="draw force, slip and events of each grasp into DIR")
    options = parser.parse_args(words)
    options.classes, options.sensors = options.classes.split(","), options.sensors.split(",")
    for names, known, what in ((options.classes, CLASSES, "class"), (options.sensors, tuple(SENSOR_SETS), "sensor set")):
        for name in names:
            if name not in known:
                parser.error(f"no {what} {name!r}; there are {', '.join(known)}")
    if not options.gripd.is_file():
        parser.error(f"no program {options.gripd}")
    options.gripd = options.gripd.resolve()
    if options.grasps < 1 or options.jobs < 1 or options.first < 0 or options.seed < 0 or options.sink < 0.0:
        parser.error("--grasps and --jobs begin at 1, --first, --seed and --sink at 0")
    return options


def main(words: Sequence[str] | None = None) -> int:
    """The command; its exit code: 0 done, 1 a grasp failed to run, 2 wrong arguments, 3 some grasps were late to the end."""
    options = _options(words)
    numbers = range(options.first, options.first + options.grasps)
    jobs = [Job(number, options.classes[number % len(options.classes)], options) for number in numbers]
    rows: list[dict[str, Any]] = []
    out = options.json.open("w") if options.json is not None else None
    with ProcessPoolExecutor(options.jobs, multiprocessing.get_context("spawn")) as pool:
        try:
            for prepared in pool.map(prepare, jobs):
                done = rows_of(prepared, options)
                for row in done:
                    if out is not None:
                        print(json.dumps(row), file=out, flush=True)
                    if "error" in row:
                        print(f"mujoco_gripper: {row['class']} {row['number']}, {row['way']}: {row['error']}", file=sys.stderr)
                rows += done
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)
            print("mujoco_gripper: interrupted; the table is of what was done", file=sys.stderr)
    if out is not None:
        out.close()
    print("\n".join(table.lines(rows, [*options.sensors, *(["oracle"] if options.oracle else [])])))
    if any("error" in row for row in rows):
        return 1
    return 3 if any(row.get("too_late") for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
