"""A client of gripd at a real socket of a daemon made of the same pieces."""

from __future__ import annotations

import math
import socket
import struct
import threading
from collections.abc import Iterator
from typing import Optional

import pytest
from grip_link import Daemon, DaemonError, frame
from grip_link.decoder import Decoder, Role, Verdict
from grip_link.messages import Ack, Kind, Nack, NackReason
from grip_link.messages.daemon import (
    Command, Gripper, Notice, NoticeKind, Operation, RealTime, Rows, RowSet, Subscribe, Topics, Welcome, WelcomeFlags,
)  # fmt: skip
from grip_link.sender import Sender


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
