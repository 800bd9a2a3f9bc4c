#!/usr/bin/env python3
"""Time from a row to the slip event it led to: GRIPD [SECONDS] in, a table of p50, p99 and the longest (ms) out.

Rows at 1.6 kHz go to gripd over standard input, TCP, a socket file and UDP, one row a write. Every 0.4 s the vibration
is loud for 50 ms. The time counts from before the write of the row whose `t_s` the event names to when its line was
read, so it holds what this script and the system take, too."""

import json
import random
import socket
import subprocess
import sys
import tempfile
import threading
import time

RATE = 1600
program, seconds = sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else 60.0


def value(n):
    return random.gauss(0, 0.1 if n % 640 >= 560 and n > 800 else 0.01)


def connect(family, address):
    for _ in range(500):
        line = socket.socket(family, socket.SOCK_STREAM)
        try:
            line.connect(address)
            return line
        except OSError:
            line.close()
            time.sleep(0.01)
    sys.exit(f"nobody listens at {address}")


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def run(kind, folder):
    port = free_port()
    place = {"stdin": "-", "tcp": f"tcp:127.0.0.1:{port}", "unix": f"unix:{folder}/rows", "udp": f"udp:127.0.0.1:{port}"}
    command = [program, "--sensor", f"rows:{place[kind]}", "--listen", "off", "--json"]
    gripd = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    sent, taken = [], []

    def listen(lines):
        for line in lines:
            now = time.perf_counter()
            event = json.loads(line)
            if event["type"] == "slip":
                taken.append(now - sent[round(event["t_s"] * RATE)])

    if kind == "stdin":
        write, end, lines = (lambda data: (gripd.stdin.write(data), gripd.stdin.flush())), gripd.stdin.close, gripd.stdout
    elif kind == "udp":
        line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        line.connect(("127.0.0.1", port))
        time.sleep(0.5)
        write, end = line.send, lambda: line.send(b"")
        lines = iter(lambda: line.recv(4096), None)
    else:
        line = connect(socket.AF_UNIX, f"{folder}/rows") if kind == "unix" else connect(socket.AF_INET, ("127.0.0.1", port))
        if kind == "tcp":
            line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        write, end, lines = line.sendall, (lambda: line.shutdown(socket.SHUT_WR)), line.makefile("rb")
    threading.Thread(target=listen, args=(lines,), daemon=True).start()
    if kind != "stdin":
        threading.Thread(target=gripd.stdout.read, daemon=True).start()
    write(f"t_s,vibration,rate={RATE}\n".encode())
    random.seed(1)
    start = time.perf_counter()
    for n in range(int(seconds * RATE)):
        time.sleep(max(0, start + n / RATE - time.perf_counter()))
        row = f"{n / RATE:.6f},{value(n):.6f}\n".encode()
        sent.append(time.perf_counter())
        write(row)
    time.sleep(0.2)
    end()
    code = gripd.wait(20)
    taken.sort()
    at = lambda share: 1e3 * taken[min(len(taken) - 1, int(share * len(taken)))]
    print(f"| {kind} | {len(taken)} | {at(0.5):.2f} | {at(0.99):.2f} | {at(1):.2f} | {code} |", flush=True)


print("| rows over | slips | p50 (ms) | p99 (ms) | longest (ms) | exit code |\n|---|---|---|---|---|---|")
with tempfile.TemporaryDirectory() as folder:
    for kind in ["stdin", "tcp", "unix", "udp"]:
        run(kind, folder)
