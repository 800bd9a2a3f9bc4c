"""The client protocol of gripd: vectors, and a client at a real socket of a daemon made of the same pieces."""

from __future__ import annotations

import math
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any, Optional

import pytest
from grip_link import Daemon, DaemonError, frame
from grip_link.decoder import TO_CLIENT, TO_DAEMON, Decoder, Role, Verdict
from grip_link.messages import MESSAGES, Ack, BadValue, Kind, Nack, NackReason, ShortPayload
from grip_link.messages.daemon import (
    Command,
    Estimates,
    Gripper,
    Health,
    Load,
    Notice,
    NoticeKind,
    Object,
    Operation,
    RealTime,
    Rows,
    RowSet,
    Setup,
    Slip,
    State,
    Subscribe,
    Topics,
    Welcome,
    WelcomeFlags,
)
from grip_link.sender import Sender

from vectors import BAD_CLIENTS, CLIENTS, Invalid, Valid, words

LISTEN = Path(__file__).resolve().parents[1] / "examples" / "listen.py"


def bits(value: float) -> str:
    return struct.pack(">f", value).hex()


def shown(message: Any) -> dict[str, str]:
    """The fields of a message as the vectors write them."""
    if message is None:
        return {}
    values = {field.name: getattr(message, field.name) for field in fields(message)}
    for old, new in (("version_min", "min"), ("version_max", "max")):
        if old in values:
            values[new] = values.pop(old)
    if isinstance(message, Rows):
        del values["data"]
        values["n"] = len(message)
        values["rows"] = ";".join(",".join([str(after), *map(bits, row)]) for after, *row in message.raw)
    words = {}
    for name, value in values.items():
        if value is None:
            continue
        if isinstance(value, str):
            words[name] = value
        elif isinstance(value, tuple):
            words[name] = ",".join(map(str, value))
        elif isinstance(value, bytes):
            words[name] = value.hex()
        else:
            words[name] = bits(value) if isinstance(value, float) else str(int(value))
    return words


@pytest.mark.parametrize("case", CLIENTS, ids=lambda case: case.name)
def test_valid_frame(case: Valid) -> None:
    wire, wanted = bytes.fromhex(case.wire), words(case.header)
    decoder = Decoder(Role.DAEMON if case.direction == "to_daemon" else Role.CLIENT)
    decoder.open_session(int(wanted["session"]))
    (block,) = decoder.feed(wire)
    assert block.verdict is Verdict.OK and block.frame is not None
    header = block.frame.header
    assert (header.kind, header.seq, header.ack_req) == (Kind[case.type], int(wanted["seq"]), wanted["ack_req"] == "1")
    message = MESSAGES[header.kind].parse(block.frame.payload) if header.kind in MESSAGES else None
    assert shown(message) == words(case.fields)
    again = frame.encode(header, message.pack() if message else b"")
    assert (again == wire) == (case.use == "both")


def error_word(last: Any) -> str:
    if last.verdict is not Verdict.OK or last.frame.header.kind not in MESSAGES:
        return "-"
    try:
        MESSAGES[last.frame.header.kind].parse(last.frame.payload)
    except ShortPayload:
        return "short"
    except BadValue as error:
        return f"value@{error.at}"
    return "-"


@pytest.mark.parametrize("case", BAD_CLIENTS, ids=lambda case: case.name)
def test_verdicts_of_bad_input(case: Invalid) -> None:
    decoder = Decoder(Role(case.role))
    if case.session == "beef":
        decoder.open_session(0xBEEF, 0)
    blocks = list(decoder.feed(bytes.fromhex(case.wire)))
    assert ",".join(block.verdict.value for block in blocks) == case.verdicts
    assert error_word(blocks[-1]) == case.error


class FakeDaemon(threading.Thread):
    """Greets one client, answers QUERY with two messages and OBJECT, refuses COMMAND, sends rows; an odd greeting on request."""

    def __init__(self, greeting: Optional[bytes] = None) -> None:
        super().__init__(daemon=True)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._greeting = greeting
        self.url = "socket://127.0.0.1:%d" % self._listener.getsockname()[1]

    def run(self) -> None:
        with self._listener, self._listener.accept()[0] as client:
            client.settimeout(10.0)
            decoder, sender = Decoder(Role.DAEMON), Sender(to_host=True)
            while data := client.recv(4096):
                if self._greeting is not None:
                    client.sendall(self._greeting)
                for block in decoder.feed(data):
                    assert block.frame is not None and block.verdict is Verdict.OK
                    for wire in self._answers(decoder, sender, block.frame.header):
                        client.sendall(wire)

    def _answers(self, decoder: Decoder, sender: Sender, header: frame.Header) -> Iterator[bytes]:
        if header.kind == Kind.SUBSCRIBE and self._greeting is None:
            decoder.open_session(header.session, header.seq)
            sender.session = header.session
            flags = WelcomeFlags.DRY_RUN
            yield sender.send(Kind.WELCOME, Welcome(1, 1, 480, flags, 0, 9, 5, RealTime.GRANTED, b"gripd x").pack())
            values = struct.pack("<Iff", 0, 1e-6, math.nan) + struct.pack("<Iff", 100, 2e-6, 2.5)
            yield sender.send(Kind.ROWS, Rows(7, 1000, 1, RowSet.STYLUS | RowSet.NORMAL_FORCE, 0, values).pack())
        if header.kind == Kind.QUERY:
            yield sender.send(Kind.GRIPPER, Gripper(bytes(16), 1, 1000, math.nan, 4, 0).pack())
            yield sender.send(Kind.ACK, Ack(header.kind, header.seq).pack())
        if header.kind == Kind.COMMAND:
            yield sender.send(Kind.NACK, Nack(header.kind, NackReason.FORBIDDEN, header.seq).pack())
        if header.kind == Kind.OBJECT:
            known = Notice(NoticeKind.OBJECT, 0, 0, 3, 5, b"bottle: known").pack()
            yield sender.send(Kind.NOTICE, known)
            yield sender.send(Kind.ACK, Ack(header.kind, header.seq).pack())


@pytest.fixture
def fake() -> FakeDaemon:
    daemon = FakeDaemon()
    daemon.start()
    return daemon


def test_samples_query_and_refusal(fake: FakeDaemon) -> None:
    with Daemon.open(fake.url, Subscribe(topics=Topics(0), every_nth=1)) as daemon:
        assert daemon.welcome.daemon == "gripd x" and daemon.welcome.flags == WelcomeFlags.DRY_RUN
        known = daemon.query()
        (gripper,) = [message for message in known if isinstance(message, Gripper)]
        assert gripper.rate_hz == 1000
        (rows,) = [message for message in known if isinstance(message, Rows)]
        first, second = rows
        assert (first.index, second.index, second.t_us) == (7, 8, 1100)
        assert math.isnan(first.values[RowSet.NORMAL_FORCE]) and second.values[RowSet.NORMAL_FORCE] == 2.5
        with pytest.raises(PermissionError, match="forbidden"):
            daemon.command(Command(Operation.STOP))
        daemon.name_object("bottle")
        assert daemon.counters.gap == 0 and daemon.counters.bad_blocks == 0


def test_another_program_at_the_port_is_no_gripd() -> None:
    other = FakeDaemon(greeting=b"SSH-2.0-whatever\r\n\0\0")
    other.start()
    with pytest.raises(DaemonError, match="no frames"):
        Daemon.open(other.url)


def test_the_example_prints_samples(fake: FakeDaemon) -> None:
    ran = subprocess.run(
        [sys.executable, str(LISTEN), fake.url, "--every", "1", "--seconds", "0.5"],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert (ran.returncode, ran.stdout) == (0, "7,0.001000,9.99999997e-07\n8,0.001100,1.99999999e-06\n"), ran.stderr


def test_the_example_says_that_nobody_is_there() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    ran = subprocess.run(
        [sys.executable, str(LISTEN), f"socket://127.0.0.1:{port}"], capture_output=True, text=True, timeout=60, check=False
    )
    assert ran.returncode == 1 and "listen:" in ran.stderr and "Traceback" not in ran.stderr


def test_there_are_enough_vectors() -> None:
    assert {Kind[case.type] for case in CLIENTS} == TO_DAEMON | TO_CLIENT - {Kind.ACK, Kind.NACK}
    assert len(BAD_CLIENTS) >= 20
