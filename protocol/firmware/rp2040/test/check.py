#!/usr/bin/env python3
"""The firmware in an emulator of the RP2040: recordings on its sensor, its slips over USB against those of the host.

  check.py --modules NODE_MODULES --uf2 FIRMWARE.uf2 --host PROGRAM --work FOLDER [--adxl345] [--recordings FOLDER --most N]

Simulated slips always; --recordings adds N fingertip recordings (biotac_slide). PROGRAM is examples/host.rs. Each signal
goes to the converter of the emulated chip as codes of 12 bits, or to an emulated ADXL345 on its SPI as steps, with faults
of that sensor too. The Python peer opens the link over the emulated USB
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
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[2] / "python" / "src"))
sys.dont_write_bytecode = True

from grip_link import Config, GripLink, LinkClosed, SampleFormat  # noqa: E402
from grip_link.messages import Event, EventKind, Log  # noqa: E402
from grip_link.stream import FdStream  # noqa: E402

CLOCK_HZ, LEARN_S = 125e6, 0.25


@dataclass(frozen=True)
class Sensor:
    rate_hz: int
    readings_a_sample: int
    middle: int
    most: int
    # Steps of a reading: the lowest bit of an ADXL345 is 0 at 3200 Hz.
    step: int
    arguments: tuple

    def code(self, value):
        whole = round(value / self.step) * self.step
        return min(max(self.middle + whole, 0 if self.middle else -self.most), self.most)


PIEZO = Sensor(10_000, 8, 2048, 4095, 1, ())
ADXL345 = Sensor(3200, 2, 0, 4094, 2, ("adxl345",))
# Fault of the emulated sensor, from, to (ms), and how the line about it begins.
FAULTS = {
    "wrong identity": ("id", 0, 300, "sensor: identity 0xE4"),
    "only zeros": ("zeros", 400, 500, "sensor: identity 0x00"),
    "only ones": ("ones", 400, 500, "sensor: identity 0xFF"),
    "power lost": ("power", 400, 410, "sensor: no readings"),
    "overrun": ("stall", 400, 425, "sensor: "),
}
SENSOR_DEAD = 0x0101


def simulated(sensor, seed, noise, slip, onset_s, seconds):
    """Codes of a white signal that is `slip` steps loud for 0.25 s from the onset on, `noise` steps otherwise."""
    dice = random.Random(seed)
    codes = []
    for i in range(int(seconds * sensor.rate_hz)):
        t = i / sensor.rate_hz
        loud = onset_s <= t < onset_s + 0.25
        codes.append(sensor.code(dice.gauss(0, slip if loud else noise)))
    return codes


def recorded(sensor, folder, most, seconds):
    """Some recordings of 2200 Hz, each reading held until the next one. They are rectified. Their rest before the onset is
    shorter than the floor takes to learn, so it is repeated for 0.3 s."""
    with (folder / "labels.csv").open(encoding="utf-8", newline="") as lines:
        onsets = [(row["recording"], float(row["onset_s"])) for row in csv.DictReader(lines) if row["kind"] == "onset"]
    for name, onset_s in onsets[:: max(1, len(onsets) // most)][:most]:
        with (folder / f"{name}.csv").open(encoding="utf-8", newline="") as lines:
            rows = [(float(row["t_s"]), float(row["vibration"])) for row in csv.DictReader(lines)]
        # The object begins to shear up to 50 ms before the onset.
        rest_s, codes, k = max(0.01, onset_s - 0.05), [], 0
        for i in range(int(seconds * sensor.rate_hz)):
            t = i / sensor.rate_hz
            at = t % rest_s if t < 0.3 else rest_s + t - 0.3
            k = 0 if at < rows[k][0] else k
            while k + 1 < len(rows) and rows[k + 1][0] <= at:
                k += 1
            codes.append(sensor.code(rows[k][1]))
        yield name, codes


class Board:
    """An emulated board with codes for its converter; all that it sends is kept."""

    def __init__(self, args, sensor, name, codes, fault=()):
        name = name.replace(" ", "-")
        self.sensor = sensor
        self.lines, self.faults, self.rows, self.missing = [], [], 0, 0
        file = args.work / f"{name}.codes"
        file.write_bytes(struct.pack(f"<{len(codes)}{'h' if sensor is ADXL345 else 'H'}", *codes))
        self.codes, self.summary = file, args.work / f"{name}.json"
        self.log = (args.work / f"{name}.txt").open("wb")
        self.time = args.work / f"{name}.time"
        self.time.write_bytes(bytes(8))
        command = ["node", HERE / "emulator.mjs", args.modules, args.uf2, file, self.summary, self.time]
        command += [*sensor.arguments, *map(str, fault)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.log)

    def listen(self, timeout_s):
        """Lines of LOG, faults and rows of SAMPLES until the emulator ends. Time is that of the emulated board, whatever pace this computer has."""
        stream = FdStream(self.process.stdout.fileno(), owns=False, out=self.process.stdin.fileno())
        config = Config(sample_rate_hz=self.sensor.rate_hz, batch=10, format=SampleFormat.I16, force_max_mn=0, slew_mn_s=100_000, hold_cap_mn=0)
        now = lambda: int.from_bytes(self.time.read_bytes(), "little") + 1
        link = GripLink(stream, config, clock_us=now, silence_s=5.0)
        begin = time.monotonic()
        try:
            try:
                link.connect()
            except LinkClosed as closed:
                # A sensor that is dead from the start on is a fault before anybody listens.
                if not (closed.code == "refused" and link.ident and link.ident.fault):
                    raise
                link.clear_fault(link.ident.fault)
            while time.monotonic() - begin < timeout_s:
                link.poll(0.005)
        except LinkClosed:
            pass
        self.rows, self.missing = link.loss.received, link.loss.lost
        for report in link.reports:
            if isinstance(report, Log):
                self.lines.append(report.message)
            elif isinstance(report, Event) and report.kind is EventKind.FAULT:
                self.faults.append(report.value)
        code = self.process.wait(10)
        if code != 0:
            raise SystemExit(f"check.py: the emulator ended with {code}: {self.log.name}")


def end(process):
    if process.poll() is None:
        process.kill()
        process.wait()


def run(args, sensor, name, codes, fault=()):
    board = Board(args, sensor, name, codes, fault)
    try:
        board.listen(120)
    finally:
        end(board.process)
    return board


def with_faults(args):
    """A slip 0.9 s after the sensor starts, and a fault before it: it is reported, and the slip is found all the same."""
    codes = simulated(ADXL345, 1, 6, 60, 0.9, 1.3)
    for name, (kind, begin, end_ms, words) in FAULTS.items():
        board = run(args, ADXL345, name, codes, (kind, begin, end_ms))
        summary = json.loads(board.summary.read_text(encoding="utf-8"))
        about = [line for line in board.lines if line.startswith("sensor")]
        blinks = sum(1 for on, at in summary["led"] if on and begin <= at < end_ms + 300)
        print(f"{name}: {about}, faults {board.faults}, {summary['lost']} readings lost in the sensor, {board.missing} rows missing, LED on {blinks} times")
        if not about or not about[0].startswith(words):
            yield f"{name}: lines {board.lines}"
        if kind == "stall":
            reported = int(about[0].split()[1]) if about else 0
            if abs(reported - summary["lost"]) > 2 or abs(board.missing - summary["lost"]) > 2 or board.faults:
                yield f"{name}: {summary['lost']} readings were lost, {reported} reported, {board.missing} rows missing, faults {board.faults}"
        elif SENSOR_DEAD not in board.faults or about[-1:] != ["sensor: found again"] or blinks == 0:
            yield f"{name}: faults {board.faults}, lines {about}, LED {summary['led']}"
        if not any(line.startswith("slip") for line in board.lines):
            yield f"{name}: no slip after it"


def main():
    parser = argparse.ArgumentParser()
    for name in ("modules", "uf2", "host", "work"):
        parser.add_argument(f"--{name}", type=Path, required=True)
    parser.add_argument("--adxl345", action="store_true", help="that sensor in place of the piezo")
    parser.add_argument("--recordings", type=Path)
    parser.add_argument("--most", type=int, default=3)
    args = parser.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)
    sensor = ADXL345 if args.adxl345 else PIEZO

    signals = {
        "loud": simulated(sensor, 1, 3, 60, 0.4, 0.9),
        "weak": simulated(sensor, 2, 20, 50, 0.4, 0.9),
        "rest": simulated(sensor, 3, 10, 10, 0.0, 0.9),
    }
    if args.recordings:
        signals |= recorded(sensor, args.recordings, args.most, 0.9)

    failed, kinds = [], {"learning": [], "quiet": [], "slip": []}
    stack = 0
    for name, codes in signals.items():
        board = run(args, sensor, name, codes)
        lines = board.lines
        host = subprocess.run([args.host, *(f"--{word}" for word in sensor.arguments), board.codes], capture_output=True, text=True, check=True).stdout.splitlines()[:-1]
        summary = json.loads(board.summary.read_text(encoding="utf-8"))
        lit = [at for on, at in summary["led"] if on]
        print(f"{name}: board {len(lines)} lines, host {len(host)}, {board.rows} rows, LED on {len(lit)} times"
              f"{', first ' + host[0] if host else ''}")
        faults = []
        if lines != host:
            faults.append(f"board {lines}, host {host}")
        if board.rows == 0:
            faults.append("no samples came over the link")
        if bool(lit) != any("slip" in line for line in host):
            faults.append(f"the LED does not show it: {summary['led']}")
        late = len(codes) - sensor.readings_a_sample * len(summary["samples"])
        if late > sensor.rate_hz // 100:
            faults.append(f"{late} readings were not looked at")
        failed += [f"{name}: {fault}" for fault in faults]
        stack = max(stack, summary["stack_bytes"])
        onset = next((int(line.split()[3]) for line in host), None)
        for k, cycles in enumerate(summary["samples"]):
            t_us = k * sensor.readings_a_sample * 1e6 / sensor.rate_hz
            slips = onset is not None and onset <= t_us < onset + 150_000
            kinds["learning" if t_us < LEARN_S * 1e6 else "slip" if slips else "quiet"].append(cycles)

    for kind, cycles in kinds.items():
        if cycles:
            mean = sum(cycles) / len(cycles)
            share = mean * sensor.rate_hz / sensor.readings_a_sample / CLOCK_HZ
            print(f"{kind}: mean {mean:.0f}, most {max(cycles)} cycles a sample, {100 * share:.0f} % of the core, {len(cycles)} samples")
    print(f"deepest stack {stack} bytes")
    if not kinds["slip"]:
        failed.append("no slip was found in any signal")
    if args.adxl345:
        failed += with_faults(args)
    for fault in failed:
        print(f"check.py: {fault}", file=sys.stderr)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
