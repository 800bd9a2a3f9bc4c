#!/usr/bin/env python3
"""Prints the blocks of PAGE as a script for bash: a file where the fence has a name, commands (sh), and what these print (text).
The script needs WORK, a folder for what was printed. A block of another kind is a fault. With `PAGE python` it prints the blocks of
Python alone, each line at its place in the page, which errors then name."""

import re
import shlex
import sys

page = open(sys.argv[1], encoding="utf-8").read()
if sys.argv[2:] == ["python"]:
    kind = None
    for line in page.splitlines():
        if line.startswith("```"):
            kind, line = line[3:] if kind is None else None, ""
        print(line if kind == "python" else "")
    sys.exit()
print("set -euo pipefail")
for info, body in re.findall(r"^```(.*?)\n(.*?)^```$", page, re.M | re.S):
    kind, _, name = info.partition(" ")
    if name:
        print(f"printf %s {shlex.quote(body)} >{shlex.quote(name)}")
    elif kind == "sh":
        # Not through a pipe: folder and variables are those of the next block.
        print(f"{{\n{body}}} >$WORK/said\ncat $WORK/said")
    elif kind == "text":
        print(f"printf %s {shlex.quote(body)} | diff - $WORK/said")
    else:
        sys.exit(f"{sys.argv[1]}: a block of kind {info!r} is not run")
