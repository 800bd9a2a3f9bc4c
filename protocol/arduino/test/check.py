#!/usr/bin/env python3
"""A sketch in simavr against the Python peer: check.py SKETCH BOARD FIRMWARE.elf

BOARD is the program of board.c. The peer opens the link, asks for 500 Hz and reads until three seconds are over. Rows must come at that
rate without a gap, with the triangle that the emulated converter sees, and the force of the emulated load cell in every sixth or so."""

import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python" / "src"))
sys.dont_write_bytecode = True

from grip_link import Config, GripLink, LinkClosed, SampleFormat  # noqa: E402
from grip_link.stream import FdStream  # noqa: E402

SECONDS, RATE_HZ, LEAST_ROWS = 3, 500, 1200
CHANNELS = {"piezo": 1, "accelerometer": 1, "loadcell": 2}


def conversation(process, sample_format, clock):
    """The link with its rows. Time is that of the emulated board, whatever pace this computer has."""
    stream = FdStream(process.stdout.fileno(), owns=False, out=process.stdin.fileno())
    config = Config(sample_rate_hz=RATE_HZ, batch=10, format=sample_format, force_max_mn=0, slew_mn_s=100_000, hold_cap_mn=0)
    link = GripLink(stream, config, clock_us=lambda: int.from_bytes(clock.read_bytes(), "little") + 1, silence_s=5.0)
    begin = time.monotonic()
    try:
        link.connect()
        while time.monotonic() - begin < 120:
            link.poll(0.002)
    except LinkClosed:
        pass
    return link


def check(sketch, link):
    """What is wrong."""
    if link.config is None:
        yield "no answer to HELLO or CONFIG"
        return
    rows = [sample.values for sample in link.rows]
    # The handshake takes 0.1 s; this program may have to wait for its turn meanwhile.
    if len(rows) < LEAST_ROWS:
        yield f"{len(rows)} rows"
        return
    if any(len(row) != CHANNELS[sketch] for row in rows):
        yield f"rows of {len(rows[0])} elements"
    if link.loss.lost:
        yield f"{link.loss}"
    step = link.ident.channels[0].scale
    first = [row[0] / step for row in rows if row[0] == row[0]]
    # The emulated accelerometer is without power for 20 ms: the rows of that time have no reading, and some after it may be damaged.
    if len(rows) - len(first) > 20:
        yield f"{len(rows) - len(first)} rows without a reading"
    # The converter sees 1.5 to 3.5 V of 5 V: -205 to 205 about the middle, every 10 ms.
    if not (-215 <= min(first) <= -180 and 180 <= max(first) <= 215):
        yield f"readings from {min(first)} to {max(first)}"
    # 100,000 steps of 2.3e-5 N, 80 times a second; in i16 a step is 1 mN.
    if sketch == "loadcell":
        forces = [row[1] * 1000 for row in rows if row[1] == row[1]]
        if not 0.12 <= len(forces) / len(rows) <= 0.2 or any(abs(force - 2300) > 1 for force in forces):
            yield f"{len(forces)} forces from {min(forces, default=0)} to {max(forces, default=0)} mN in {len(rows)} rows"
    turns = sum(1 for a, b in zip(first, first[1:]) if a < 0 <= b)
    if not 0.18 <= turns / len(first) <= 0.22:
        yield f"{turns} periods in {len(first)} rows"


def main():
    sketch, board, elf = sys.argv[1:]
    failed = False
    for sample_format in (SampleFormat.I16, SampleFormat.F32):
        clock = Path(elf).with_suffix(".clock")
        clock.write_bytes(bytes(8))
        process = subprocess.Popen([board, elf, str(SECONDS), clock], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        try:
            link = conversation(process, sample_format, clock)
        finally:
            if process.poll() is None:
                process.kill()
            process.wait()
        faults = list(check(sketch, link))
        print(f"{sketch} on the emulated board, {sample_format.name}: {link.loss.received} rows{'' if not faults else ', ' + '; '.join(faults)}")
        failed |= bool(faults)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
