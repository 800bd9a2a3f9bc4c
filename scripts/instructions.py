#!/usr/bin/env python3
"""Counts the instructions of hot functions and compares them with benches/instructions.toml.

scripts/instructions.sh calls it:

scripts/instructions.py            fails where a count is more than 3 % above the one that is written down
scripts/instructions.py --write    writes the counts down

Needs valgrind and the programs of scripts/release-build.sh. Counts depend on the compiler and on the vector instructions of the processor, and not on
what else runs.
"""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BASELINE = ROOT / "benches/instructions.toml"
MOST = 1.03
HEAD = "# Instructions a sample, frame, pass or epoch: scripts/instructions.sh --write\n"


def count(program, case):
    """Instructions of one item of a case."""
    tool = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", "--toggle-collect=instructions::measured*"]
    run = subprocess.run([*tool, program, case], capture_output=True, text=True, check=False)
    collected = re.search(r"Collected : (\d+)", run.stderr)
    if run.returncode or not collected or not int(collected[1]):
        sys.exit(f"instructions: {case}: {run.stderr}")
    return int(collected[1]) / int(run.stdout)


def main():
    program = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release/instructions"
    cases = subprocess.run([program], capture_output=True, text=True, check=True).stdout.splitlines()
    counts = {case: count(program, case) for case in cases}
    if sys.argv[1:] == ["--write"]:
        BASELINE.write_text(HEAD + "".join(f'"{case}" = {n:.1f}\n' for case, n in counts.items()))
        return 0
    before = tomllib.loads(BASELINE.read_text())
    worse = set(before) ^ set(counts)
    for case, n in counts.items():
        ratio = n / before[case] if case in before else float("nan")
        print(f"{case:28} {n:12.1f} {ratio:7.3f}")
        if not ratio <= MOST:
            worse.add(case)
    if worse:
        print(f"instructions: beyond {MOST} of {BASELINE.relative_to(ROOT)}: {', '.join(sorted(worse))}", file=sys.stderr)
    return 1 if worse else 0


if __name__ == "__main__":
    sys.exit(main())
