#!/usr/bin/env python3
"""gripd's time from frame to command beside gripfleet and without it, for fleet/docs/results.md.

Usage: scripts/latency.py GRIPD GRIPFLEET [ROUNDS] [strict]: runs of 15 s in turn.
"strict" asks for SCHED_FIFO. Everything is on loopback and ends by itself.
"""

import collections
import pathlib
import re
import socket
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request

BUCKET = re.compile(r'^gripd_latency_seconds_bucket\{[^}]*le="([0-9.e+-]+)"[^}]*\} (\S+)$', re.M)
SECONDS = 15


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def quantile(counts, share):
    """In us, on a straight line between the ends of its bucket."""
    wanted, below, low = share * sum(counts.values()), 0, 0.0
    for high in sorted(counts):
        if below + counts[high] >= wanted:
            return 1e6 * (low + (high - low) * (wanted - below) / counts[high])
        below += counts[high]
        low = high
    raise SystemExit("no latencies")


def run(gripd, config, folder):
    port = free_port()
    command = [gripd, "--port", "sim", "--duration", str(SECONDS), "--json", "--config", config]
    command += ["--listen", f"unix:{folder}/gripd.sock", "--metrics", f"127.0.0.1:{port}"]
    with open(folder / "gripd.log", "a") as log:
        daemon = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=log)
    try:
        time.sleep(SECONDS - 1)
        page = urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=5).read().decode()
    finally:
        daemon.wait(timeout=60)
    counts, before = collections.Counter(), 0
    for high, count in sorted((float(high), int(float(count))) for high, count in BUCKET.findall(page)):
        counts[high], before = count - before, count
    return counts


def main(gripd, gripfleet, rounds="12", mode="off"):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        router = f"tcp/127.0.0.1:{free_port()}"
        base = f'listen = "unix:{folder}/gripd.sock"\n[link]\nsample_rate_hz = 10000\n[realtime]\nmode = "{mode}"\n'
        fleet = f'[fleet]\nsite = "hall"\nrouter = "{router}"\n'
        (folder / "off.toml").write_text(base)
        (folder / "on.toml").write_text(base + fleet)
        beside = [subprocess.Popen([gripfleet, "router", "--listen", router], stdout=subprocess.DEVNULL)]
        try:
            time.sleep(1)
            events = [gripfleet, "events", "--router", router, "--all", "--json"]
            beside.append(subprocess.Popen(events, stdout=subprocess.DEVNULL))
            beside_gripd = [gripfleet, "--config", folder / "on.toml", "--log-level", "error"]
            runs = {"off": [], "on": []}
            for turn in range(int(rounds)):
                for which in ["off", "on"] if turn % 2 == 0 else ["on", "off"]:
                    fleet = subprocess.Popen(beside_gripd) if which == "on" else None
                    runs[which].append(run(gripd, folder / f"{which}.toml", folder))
                    if fleet:
                        fleet.terminate()
                        fleet.wait()
        finally:
            for process in beside:
                process.terminate()
                process.wait()
    p99 = {}
    for which, each in runs.items():
        every = sum(each, collections.Counter())
        p99[which] = quantile(every, 0.99)
        median = statistics.median(quantile(one, 0.99) for one in each)
        above = {high: sum(n for at, n in every.items() if at > high) for high in sorted(every)}
        shares = [f"{100 * n / sum(every.values()):.4f} % above {1e6 * high:.1f} us" for high, n in above.items() if 3e-5 < high < 3e-4]
        print(f"fleet {which}: p99 {p99[which]:.1f} us of {sum(every.values())} frames, median of the runs {median:.1f} us; {', '.join(shares)}")
    print(f"on / off: {p99['on'] / p99['off']:.2f}")


if __name__ == "__main__":
    if not 3 <= len(sys.argv) <= 5:
        raise SystemExit(__doc__)
    main(*sys.argv[1:])
