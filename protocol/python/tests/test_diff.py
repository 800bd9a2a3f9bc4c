"""The comparison modes, as other peers call them."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

from grip_link.decoder import Decoder, Role
from grip_link.frame import encode

from vectors import INVALID, VALID


def answers(text: str, *words: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-m", "grip_link.diff", *words], input=text, capture_output=True, text=True, timeout=60, check=True
    )
    return done.stdout.splitlines()


def test_decode() -> None:
    text = "".join(f"{case.role} {'beef:0' if case.session == 'beef' else '-'} {case.wire}\n" for case in INVALID)
    lines = answers(text, "decode")
    assert len(lines) == len(INVALID)
    for case, line in zip(INVALID, lines):
        verdicts, gap, garbage = line.split(" ")
        assert ",".join(word.split(":")[0] for word in verdicts.split(",")) == case.verdicts
        assert gap.startswith("gap=") and garbage.startswith("garbage=")
    assert answers("device - \n", "decode") == ["- gap=0 garbage=0"]


def test_device() -> None:
    wire = {case.name: bytes.fromhex(case.wire) for case in VALID}

    def numbered(name: str, seq: int) -> str:
        (block,) = opened().feed(wire[name])
        assert block.frame is not None
        return encode(replace(block.frame.header, seq=seq), block.frame.payload).hex()

    script = f"""ready 0
rx 1000 {numbered("hello_reference", 0)}
tx 1000 1
rx 2000 {numbered("config", 1)}
i16 2000 1 2
rx 2000 {numbered("start", 2)}
rx 2500 {numbered("heartbeat", 3)}
i16 3000 1 2
i16 3000 1
f32 3000 3f800000 40000000
drive 4000
alive 4000
log 4000 2 6869
travel 60000 60000
force 0 7
fault 5000 0201
drive 5000
rx 6000 {numbered("clear_fault", 4)}
estop 7000
drive 7000
"""
    lines = answers(script, "device")
    assert lines[0] == "linked beef" and lines[1].startswith("frame 00")
    assert lines[2] == "configured 5000 5 0 50 3 10000 200000 8000 1000 0"
    assert lines[11].startswith("log 00") and lines.pop(11)
    assert lines[3:] == [
        "row not sampling", "started", "heartbeat 5 900 2 1", "row taken", "row elements", "row format",
        "drive passive 0 state 3 fault 0000", "alive 1", "drive passive 0 state 7 fault 0201", "cleared 0201",
        "drive passive 0 state 8 fault 0001",
    ]  # fmt: skip


def opened() -> Decoder:
    """A device's decoder in the session of the vectors."""
    decoder = Decoder(Role.DEVICE)
    decoder.open_session(0xBEEF)
    return decoder
