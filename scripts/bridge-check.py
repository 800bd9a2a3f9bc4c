#!/usr/bin/env python3
"""A made-up gripper on a pseudo-terminal, and docs/examples/bridge.py between it and gripd: it shakes each second, and must be
ordered to press harder.

    PATH=target/release:$PATH scripts/bridge-check.py
"""

import os
import pty
import random
import subprocess
import sys
import time
import tty
from pathlib import Path

BRIDGE = Path(__file__).parent.parent / "docs/examples/bridge.py"
ours, theirs = pty.openpty()
tty.setraw(theirs)
os.set_blocking(ours, False)
command = [sys.executable, BRIDGE, os.ttyname(theirs), "--listen", "off"]
bridge = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
time.sleep(1)  # what comes before the line is set up is gone
chance, begin, row = random.Random(1), time.monotonic(), 0
force_n, trial_n, quiet, came = 0.0, 0.0, None, b""
# A gripper says who it is when it starts, and may answer to commands: no rows.
said = b"GRIPPER 1.2\r\nready\r\nF=0.000 boot\r\n"
while time.monotonic() < begin + 60 and not (trial_n and force_n > 1.2 * trial_n):
    out, said = said, b""
    while row < 1000 * (time.monotonic() - begin):
        # Still until the fingers have been closed for a second and a half.
        loud = quiet is not None and row > quiet and row % 1000 < 100
        out += f"A={chance.gauss(0, 0.1 if loud else 0.01):.4f} F={force_n:.3f}\n".encode()
        trial_n = trial_n or (force_n if loud else 0.0)
        row += 1
    try:
        os.write(ours, out)
        came += os.read(ours, 4096)
    except BlockingIOError:
        pass
    *lines, came = came.split(b"\n")
    for line in lines:
        if line.startswith(b"SET "):
            force_n = float(line.split()[1])
            said += b"OK " + line + b"\n"
            quiet = quiet or row + 1500
    time.sleep(0.002)
bridge.terminate()
out, err = bridge.communicate(timeout=20)
assert trial_n and force_n > 1.2 * trial_n, (trial_n, force_n, out, err)
assert b"slip at" in out, (out, err)
print(f"bridge-check: {trial_n:.2f} N, after a slip {force_n:.2f} N, {time.monotonic() - begin:.1f} s from the start")
