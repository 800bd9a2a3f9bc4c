"""Whether this computer gives its programs time: for how long each of its processors ran none of them."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections import deque

NOTICED_S = 0.005
_WATCH = f"""
import os, sys, time
os.sched_setaffinity(0, {{int(sys.argv[1])}})
before = time.monotonic()
while True:
    time.sleep(0.002)
    now = time.monotonic()
    if now - before > {NOTICED_S}:
        print(before, now, flush=True)
    before = now
"""


class Computer:
    """Watches every processor by a program that sleeps 2 ms again and again: what it oversleeps, gripd may have waited too."""

    def __init__(self) -> None:
        self._stood: deque[tuple[float, float]] = deque(maxlen=100_000)
        self._watchers = [
            subprocess.Popen([sys.executable, "-c", _WATCH, str(processor)], stdout=subprocess.PIPE, text=True)
            for processor in sorted(os.sched_getaffinity(0))
        ]
        for watcher in self._watchers:
            threading.Thread(target=self._read, args=(watcher,), daemon=True).start()

    def _read(self, watcher: subprocess.Popen[str]) -> None:
        assert watcher.stdout is not None
        for line in watcher.stdout:
            begin, end = line.split()
            self._stood.append((float(begin), float(end)))

    def stood_s(self, since: float) -> float:
        """The longest time in which a processor stood still, of those that ended after ``since`` (time.monotonic())."""
        # A processor that stands still now reports it when it goes on.
        time.sleep(2 * NOTICED_S)
        return max((end - begin for begin, end in list(self._stood) if end >= since), default=0.0)

    def close(self) -> None:
        """Ends the programs that watch."""
        for watcher in self._watchers:
            watcher.kill()
            watcher.wait()
