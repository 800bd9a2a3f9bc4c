#!/usr/bin/env python3
"""The firmware in an emulator of the RP2040: recordings on its converter, its slips over USB against those of the host.

  check.py --modules NODE_MODULES --uf2 FIRMWARE.uf2 --host PROGRAM --work FOLDER [--recordings FOLDER --most N]

Simulated slips always; --recordings adds N fingertip recordings (biotac_slide). PROGRAM is examples/host.rs. Each signal
goes to the converter of the emulated chip as codes of 12 bits. The Python peer opens the link over the emulated USB
port, asks for samples and reads the LOGs. They must be the lines that the host prints for the same codes. Prints cycles
a sample. Exit code 1 where something differs."""

import argparse
import csv
import json
import random
import struct
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[2] / "python" / "src"))
sys.dont_write_bytecode = True

from grip_link.host import Batch, HostConfig, HostLink, HostState  # noqa: E402
from grip_link.messages import Config, Log, SampleFormat  # noqa: E402
from grip_link.stream import FdStream  # noqa: E402

RATE_HZ, READINGS_A_SAMPLE, MIDDLE, CLOCK_HZ = 10_000, 8, 2048, 125e6
LEARN_S = 0.25


def simulated(seed, noise, slip, onset_s, seconds):
    """Codes of a white signal that is `slip` steps loud for 0.25 s from the onset on, `noise` steps otherwise."""
    dice = random.Random(seed)
    codes = []
    for i in range(int(seconds * RATE_HZ)):
        t = i / RATE_HZ
        loud = onset_s <= t < onset_s + 0.25
        codes.append(round(MIDDLE + dice.gauss(0, slip if loud else noise)))
    return [min(max(code, 0), 4095) for code in codes]


def recorded(folder, most, seconds):
    """Some recordings of 2200 Hz, each reading held until the next one. They are rectified. Their rest before the onset is
    shorter than the floor takes to learn, so it is repeated for 0.3 s."""
    with (folder / "labels.csv").open(encoding="utf-8", newline="") as lines:
        onsets = [(row["recording"], float(row["onset_s"])) for row in csv.DictReader(lines) if row["kind"] == "onset"]
    for name, onset_s in onsets[:: max(1, len(onsets) // most)][:most]:
        with (folder / f"{name}.csv").open(encoding="utf-8", newline="") as lines:
            rows = [(float(row["t_s"]), float(row["vibration"])) for row in csv.DictReader(lines)]
        # The object begins to shear up to 50 ms before the onset.
        rest_s, codes, k = max(0.01, onset_s - 0.05), [], 0
        for i in range(int(seconds * RATE_HZ)):
            t = i / RATE_HZ
            at = t % rest_s if t < 0.3 else rest_s + t - 0.3
            k = 0 if at < rows[k][0] else k
            while k + 1 < len(rows) and rows[k + 1][0] <= at:
                k += 1
            codes.append(min(max(round(MIDDLE + rows[k][1]), 0), 4095))
        yield name, codes


class Board:
    """An emulated board with codes for its converter; all that it sends is kept."""

    def __init__(self, args, name, codes):
        file = args.work / f"{name}.codes"
        file.write_bytes(struct.pack(f"<{len(codes)}H", *codes))
        self.codes, self.summary = file, args.work / f"{name}.json"
        self.log = (args.work / f"{name}.txt").open("wb")
        self.time = args.work / f"{name}.time"
        self.time.write_bytes(bytes(8))
        command = ["node", HERE / "emulator.mjs", args.modules, args.uf2, file, self.summary, self.time]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.log)

    def listen(self, timeout_s):
        """Lines of LOG and rows of SAMPLES until the emulator ends."""
        stream = FdStream(self.process.stdout.fileno(), owns=False)
        config = Config(sample_rate_hz=RATE_HZ, batch=10, format=SampleFormat.I16, force_max_mn=0, slew_mn_s=100_000, hold_cap_mn=0)
        link = HostLink(HostConfig(config=config, stale_us=400_000, lost_us=5_000_000, hello_for_us=5_000_000))
        begin = time.monotonic()
        # Time is that of the emulated board, whatever pace this computer has.
        now = lambda: int.from_bytes(self.time.read_bytes(), "little") + 1
        link.open(now(), 0xBEE5)
        lines, batches, streamed = [], 0, False
        while time.monotonic() - begin < timeout_s:
            try:
                data = stream.read(0.005)
            except ConnectionError:
                break
            for event in link.receive(now(), data):
                if isinstance(event, Log):
                    lines.append(event.text.decode())
                elif isinstance(event, Batch):
                    batches += 1
            streamed |= link.state is HostState.STREAM
            while frame := link.poll_transmit(now()):
                try:
                    self.process.stdin.write(frame)
                    self.process.stdin.flush()
                except BrokenPipeError:
                    break
        code = self.process.wait(10)
        if code != 0:
            raise SystemExit(f"check.py: the emulator ended with {code}: {self.log.name}")
        return lines, batches, streamed


def end(process):
    if process.poll() is None:
        process.kill()
        process.wait()


def main():
    parser = argparse.ArgumentParser()
    for name in ("modules", "uf2", "host", "work"):
        parser.add_argument(f"--{name}", type=Path, required=True)
    parser.add_argument("--recordings", type=Path)
    parser.add_argument("--most", type=int, default=3)
    args = parser.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)

    signals = {
        "loud": simulated(1, 3, 60, 0.4, 0.9),
        "weak": simulated(2, 20, 50, 0.4, 0.9),
        "rest": simulated(3, 10, 10, 0.0, 0.9),
    }
    if args.recordings:
        signals |= recorded(args.recordings, args.most, 0.9)

    failed, kinds = [], {"learning": [], "quiet": [], "slip": []}
    stack = 0
    for name, codes in signals.items():
        board = Board(args, name, codes)
        try:
            lines, batches, streamed = board.listen(120)
        finally:
            end(board.process)
        host = subprocess.run([args.host, board.codes], capture_output=True, text=True, check=True).stdout.splitlines()[:-1]
        summary = json.loads(board.summary.read_text(encoding="utf-8"))
        lit = [at for on, at in summary["led"] if on]
        print(f"{name}: board {len(lines)} lines, host {len(host)}, {batches} batches, LED on {len(lit)} times"
              f"{', first ' + host[0] if host else ''}")
        faults = []
        if lines != host:
            faults.append(f"board {lines}, host {host}")
        if not streamed or batches == 0:
            faults.append("no samples came over the link")
        if bool(lit) != any("slip" in line for line in host):
            faults.append(f"the LED does not show it: {summary['led']}")
        late = len(codes) - READINGS_A_SAMPLE * len(summary["samples"])
        if late > RATE_HZ // 100:
            faults.append(f"{late} readings were not looked at")
        failed += [f"{name}: {fault}" for fault in faults]
        stack = max(stack, summary["stack_bytes"])
        onset = next((int(line.split()[3]) for line in host), None)
        for k, cycles in enumerate(summary["samples"]):
            t_us = k * READINGS_A_SAMPLE * 1e6 / RATE_HZ
            slips = onset is not None and onset <= t_us < onset + 150_000
            kinds["learning" if t_us < LEARN_S * 1e6 else "slip" if slips else "quiet"].append(cycles)

    for kind, cycles in kinds.items():
        if cycles:
            mean = sum(cycles) / len(cycles)
            share = mean * RATE_HZ / READINGS_A_SAMPLE / CLOCK_HZ
            print(f"{kind}: mean {mean:.0f}, most {max(cycles)} cycles a sample, {100 * share:.0f} % of the core, {len(cycles)} samples")
    print(f"deepest stack {stack} bytes")
    if not kinds["slip"]:
        failed.append("no slip was found in any signal")
    for fault in failed:
        print(f"check.py: {fault}", file=sys.stderr)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
