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

from grip_link.host import Batch, HostConfig, HostLink  # noqa: E402
from grip_link.messages import Config, SampleFormat  # noqa: E402
from grip_link.stream import FdStream  # noqa: E402

SECONDS, RATE_HZ, LEAST_ROWS = 3, 500, 1200
CHANNELS = {"piezo": 1, "accelerometer": 1, "loadcell": 2}


def conversation(process, sample_format, clock):
    """Batches and link. Time is that of the emulated board, whatever pace this computer has."""
    stream = FdStream(process.stdout.fileno(), owns=False)
    config = Config(sample_rate_hz=RATE_HZ, batch=10, format=sample_format, force_max_mn=0, slew_mn_s=100_000, hold_cap_mn=0)
    link = HostLink(HostConfig(config=config, stale_us=1_000_000, lost_us=5_000_000, hello_for_us=5_000_000))
    now = lambda: int.from_bytes(clock.read_bytes(), "little") + 1
    link.open(now(), 0xBEE5)
    batches = []
    begin = time.monotonic()
    while time.monotonic() - begin < 120:
        try:
            data = stream.read(0.002)
        except ConnectionError:
            break
        batches += [event for event in link.receive(now(), data) if isinstance(event, Batch)]
        while frame := link.poll_transmit(now()):
            try:
                process.stdin.write(frame)
                process.stdin.flush()
            except BrokenPipeError:
                break
    return batches, link


def check(sketch, batches, link):
    """What is wrong."""
    if link.ident is None or link.in_force is None:
        yield "no answer to HELLO or CONFIG"
        return
    rows = [row for batch in batches for row in batch.samples.rows]
    # The handshake takes 0.1 s; this program may have to wait for its turn meanwhile.
    if len(rows) < LEAST_ROWS:
        yield f"{len(rows)} rows"
        return
    if any(len(row) != CHANNELS[sketch] for row in rows):
        yield f"rows of {len(rows[0])} elements"
    gaps = sum(batch.samples.first_index != before.samples.first_index + len(before.samples) for before, batch in zip(batches, batches[1:]))
    if gaps or batches[-1].samples.dropped_total:
        yield f"{gaps} gaps, {batches[-1].samples.dropped_total} rows dropped"
    raw = batches[0].samples.format is SampleFormat.I16
    step = 1 if raw else link.ident.channels[0].scale
    first = [row[0] / step for row in rows if row[0] == row[0] and row[0] != -32768]
    # The emulated accelerometer is without power for 20 ms: the rows of that time have no reading, and some after it may be damaged.
    if len(rows) - len(first) > 20:
        yield f"{len(rows) - len(first)} rows without a reading"
    # The converter sees 1.5 to 3.5 V of 5 V: -205 to 205 about the middle, every 10 ms.
    if not (-215 <= min(first) <= -180 and 180 <= max(first) <= 215):
        yield f"readings from {min(first)} to {max(first)}"
    # 100,000 steps of 2.3e-5 N, 80 times a second; in i16 a step is 1 mN.
    if sketch == "loadcell":
        unit = 1 if raw else 1000
        forces = [row[1] * unit for row in rows if row[1] == row[1] and row[1] != -32768]
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
            batches, link = conversation(process, sample_format, clock)
        finally:
            if process.poll() is None:
                process.kill()
            process.wait()
        faults = list(check(sketch, batches, link))
        count = sum(len(batch.samples.rows) for batch in batches)
        print(f"{sketch} on the emulated board, {sample_format.name}: {count} rows{'' if not faults else ', ' + '; '.join(faults)}")
        failed |= bool(faults)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
