#!/usr/bin/env python3
"""Runs the Python blocks of a page, one after the other in one namespace: PAGE FOLDER, in which the blocks write their files.
A block that fails is named by its line."""

import os
import re
import sys
from pathlib import Path

page, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
text = page.read_text(encoding="utf-8")
os.chdir(folder)
blocks, space = 0, {"__name__": "__main__"}
for found in re.finditer(r"^```python\n(.*?)^```$", text, re.M | re.S):
    line = text[: found.start()].count("\n") + 1
    # Errors show the lines of the page.
    exec(compile("\n" * line + found[1], str(page), "exec"), space)
    blocks += 1
print(f"{page.name}: {blocks} blocks")
sys.exit(blocks == 0)
