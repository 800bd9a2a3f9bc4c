#!/usr/bin/env python3
"""A made-up gripper on a pseudo-terminal, and docs/examples/bridge.py between it and gripd: it shakes each second, and is to be told
to press harder.

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
chance, begin, row = random.Random(1), time.monotonic(), 0
force_n, forces, came = 0.0, [], b""
while time.monotonic() < begin + 60 and not (forces and max(forces) > 1.2 * forces[0]):
    out = b""
    while row < 1000 * (time.monotonic() - begin):
        loud = row > 1500 and row % 1000 < 100
        out += f"A={chance.gauss(0, 0.1 if loud else 0.01):.4f} F={force_n:.3f}\n".encode()
        row += 1
    try:
        os.write(ours, out)
        came += os.read(ours, 4096)
    except BlockingIOError:
        pass
    *lines, came = came.split(b"\n")
    forces += [float(line.split()[1]) for line in lines if line.startswith(b"SET ")]
    force_n = forces[-1] if forces else 0.0
    time.sleep(0.002)
bridge.terminate()
out, err = bridge.communicate(timeout=20)
assert forces and max(forces) > 1.2 * forces[0], (forces[-5:], out, err)
assert b"slip at" in out, (out, err)
print(f"bridge-check: {forces[0]:.2f} N, after a slip {max(forces):.2f} N, {time.monotonic() - begin:.1f} s from the start")
