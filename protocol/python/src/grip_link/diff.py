"""Lines on stdin, what this peer makes of them on stdout: for comparing peers byte by byte.

``python -m grip_link.diff decode``: ``ROLE SESSION[:SEQ]|- HEX`` in; the verdicts, with type and CRC of good payloads,
the gap count and the garbage count out.
``python -m grip_link.diff device``: a script of ticks and bytes in, all that a device does out. One command a line, the
tick second: ready T | rx T HEX | tx T MOST | drive T | i16 T values | f32 T hex bits | fault T HEX | estop T |
travel T UM | force T MN | alive T | log T LEVEL HEX | new T [passive] (another gripper,
whose ESTOP takes the torque off).
"""

from __future__ import annotations

import struct
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Union

from .crc import crc32c
from .decoder import Decoder, Role, Verdict
from .device import Cleared, Command, Configured, DeviceEvent, DeviceLink, Linked, Rejected, RowError
from .mcu import default_ident
from .messages import Channel, ChannelKind, Heartbeat, Ident, LogLevel, SampleFormat, Unit


def reference_ident() -> Ident:
    """The gripper that all peers play in a comparison."""
    ident = default_ident(0xB007)
    taxels = Channel(ChannelKind.PRESSURE_ARRAY, Unit.PASCAL, 3, 4, 10.0)
    return replace(ident, uid=b"grip-link-test-1", channels=(*ident.channels, taxels), firmware=(1, 2, 3))


def decode_line(line: str) -> str:
    """The answer to one line of the mode ``decode``."""
    role, session, text = line.split(" ")
    decoder = Decoder(Role(role))
    if session != "-":
        number, _, seq = session.partition(":")
        decoder.open_session(int(number, 16), int(seq) if seq else None)
    words = []
    for block in decoder.feed(bytes.fromhex(text)):
        word = block.verdict.value
        if block.verdict is Verdict.OK and block.frame is not None:
            word += f":{block.frame.header.kind:02x}:{crc32c(block.frame.payload):08x}"
        words.append(word)
    counters = decoder.counters
    return f"{','.join(words) or '-'} gap={counters.gap} garbage={counters.garbage_bytes}"


def _event_words(event: DeviceEvent) -> str:
    if isinstance(event, Linked):
        return f"linked {event.session:04x}"
    if isinstance(event, Configured):
        c = event.config
        return (
            f"configured {c.sample_rate_hz} {c.batch} {c.format:d} {c.ttl_ms} {c.channel_mask} {c.force_max_mn}"
            f" {c.slew_mn_s} {c.hold_cap_mn} {c.loss_after_ms} {c.loss_action:d}"
        )
    if isinstance(event, (Command, Rejected)):
        g = event.grip
        name = type(event).__name__.lower()
        return f"{name} {g.cmd_id} {g.mode} {g.flags} {g.ttl_ms} {g.force_mn} {g.slew_mn_s} {g.cause_sample}"
    if isinstance(event, Heartbeat):
        return f"heartbeat {event.turns} {event.longest_us} {event.late} {event.flags}"
    if isinstance(event, Cleared):
        return f"cleared {event.fault:04x}"
    return {"Started": "started", "Stopped": "stopped", "Estopped": "estop"}[type(event).__name__]


def _push(link: DeviceLink, tick: int, words: Sequence[str], floats: bool) -> str:
    row: list[Union[int, float]]
    if floats:
        row = [struct.unpack(">f", bytes.fromhex(word))[0] for word in words]
    else:
        row = [int(word) for word in words]
    try:
        link.push(tick, row, SampleFormat.F32 if floats else SampleFormat.I16)
    except RowError as error:
        return f"row {error.reason}"
    return "row taken"


def device_line(link: DeviceLink, line: str) -> Iterator[str]:
    """The answers to one line of the mode ``device``."""
    name, *words = line.split()
    tick = int(words[0])
    first = words[1] if len(words) > 1 else ""
    if name == "ready":
        link.ready(tick)
    elif name == "rx":
        yield from map(_event_words, link.receive(tick, bytes.fromhex(first)))
    elif name == "tx":
        for _ in range(int(first)):
            wire = link.poll_transmit(tick)
            if wire is None:
                break
            yield f"frame {wire.hex()}"
    elif name == "drive":
        drive = link.drive(tick)
        yield f"drive {drive.kind.value} {drive.force_mn} state {link.state:d} fault {link.fault:04x}"
    elif name in ("i16", "f32"):
        yield _push(link, tick, words[1:], name == "f32")
    elif name == "fault":
        link.raise_fault(tick, int(first, 16))
    elif name == "estop":
        link.latch_estop(tick)
    elif name == "travel":
        link.report_travel(int(first))
    elif name == "force":
        link.report_force(int(first))
    elif name == "motion":
        link.report_motion(tick, first == "1")
    elif name == "alive":
        yield f"alive {link.take_alive():d}"
    elif name == "log":
        text = bytes.fromhex(words[2]) if len(words) > 2 else b""
        yield f"log {(link.log(tick, LogLevel(int(first)), text) or b'').hex()}"
    else:
        raise ValueError(f"no such command: {name}")


def main() -> int:
    """The command; its exit code."""
    if sys.argv[1:] not in (["decode"], ["device"]):
        print(__doc__, file=sys.stderr)
        return 2
    link = DeviceLink(reference_ident())
    for line in (line.rstrip("\r\n") for line in sys.stdin):
        if sys.argv[1] == "decode":
            print(decode_line(line))
        elif line.startswith("new"):
            link = DeviceLink(reference_ident(), estop_releases=line.endswith(" passive"))
        else:
            for answer in device_line(link, line):
                print(answer)
    return 0


if __name__ == "__main__":
    sys.exit(main())
