"""The address of a gripd in; its messages and samples out, and commands to it where they are allowed."""

from __future__ import annotations

import secrets
import time
from collections.abc import Iterator
from typing import Optional, Union

from .decoder import Counters, Decoder, Role, Verdict
from .messages import MESSAGES, Ack, Kind, Nack, PayloadError
from .messages.daemon import (
    Command,
    Gripper,
    Health,
    Notice,
    NoticeKind,
    Object,
    Rows,
    Setup,
    Slip,
    State,
    Subscribe,
    Welcome,
)
from .sender import Sender
from .stream import ByteStream, StreamClosed, open_stream

DEFAULT_URL = "socket://127.0.0.1:7747"
Message = Union[Welcome, Slip, State, Health, Gripper, Rows, Notice, Setup, Ack, Nack]


class DaemonError(ConnectionError):
    """The daemon does not answer, speaks another protocol version, or has closed the connection."""


class DaemonLink:
    """One client's side of the protocol without a socket: bytes in, messages out, and requests as bytes."""

    def __init__(self, nonce: int) -> None:
        self.decoder = Decoder(Role.CLIENT)
        self.decoder.open_session(nonce)
        self.malformed = 0
        self._sender = Sender(to_host=False)
        self._sender.session = nonce

    def request(self, kind: Kind, payload: bytes = b"") -> tuple[int, bytes]:
        """Number and bytes of a request that wants an answer."""
        seq = self._sender.next_seq
        return seq, self._sender.send(kind, payload, ack_req=True)

    def receive(self, data: bytes) -> Iterator[Message]:
        """Messages that the bytes complete; bad frames and payloads are counted."""
        for block in self.decoder.feed(data):
            if block.verdict is not Verdict.OK or block.frame is None:
                continue
            try:
                message: Message = MESSAGES[block.frame.header.kind].parse(block.frame.payload)
            except PayloadError:
                self.malformed += 1
                continue
            yield message


class Daemon:
    """A connection to a gripd: ``socket://HOST:PORT``, or any stream."""

    def __init__(self, stream: ByteStream, wanted: Subscribe, *, patience_s: float = 3.0) -> None:
        self._stream = stream
        self._link = DaemonLink(secrets.randbelow(65535) + 1)
        self._waiting: list[Message] = []
        self.dropped = 0
        """Frames that the daemon dropped because this program read too slowly."""
        self._send(Kind.SUBSCRIBE, wanted.pack())
        self.welcome: Welcome = self._greeting(patience_s)

    @classmethod
    def open(cls, url: str = DEFAULT_URL, wanted: Optional[Subscribe] = None) -> Daemon:
        """Connects and subscribes; raises DaemonError or OSError."""
        stream = open_stream(url)
        try:
            return cls(stream, Subscribe() if wanted is None else wanted)
        except BaseException:
            stream.close()
            raise

    @property
    def counters(self) -> Counters:
        """What was received."""
        return self._link.decoder.counters

    def messages(self, duration_s: Optional[float] = None) -> Iterator[Message]:
        """Messages as they come, for so long or until the daemon closes (DaemonError)."""
        end = None if duration_s is None else time.monotonic() + duration_s
        while end is None or time.monotonic() < end:
            left = 0.1 if end is None else max(0.0, min(0.1, end - time.monotonic()))
            yield from self._take(left)

    def query(self, patience_s: float = 3.0) -> list[Message]:
        """Everything known now."""
        seq = self._send(Kind.QUERY)
        return self._until(Kind.QUERY, seq, patience_s)

    def command(self, command: Command, patience_s: float = 3.0) -> None:
        """Hands a command to the control loop; raises PermissionError where it is refused."""
        seq = self._send(Kind.COMMAND, command.pack())
        self._waiting += self._until(Kind.COMMAND, seq, patience_s)

    def name_object(self, name: str, patience_s: float = 3.0) -> None:
        """Names the object that is grasped next, with what the memory of the daemon knows of it; an empty name is none. Raises
        PermissionError where that is refused."""
        seq = self._send(Kind.OBJECT, Object(name.encode()).pack())
        self._waiting += self._until(Kind.OBJECT, seq, patience_s)

    def close(self) -> None:
        """Closes the connection."""
        self._stream.close()

    def __enter__(self) -> Daemon:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def _send(self, kind: Kind, payload: bytes = b"") -> int:
        seq, data = self._link.request(kind, payload)
        while data:
            try:
                data = data[self._stream.write(data) :]
            except StreamClosed as error:
                raise DaemonError(str(error)) from error
        return seq

    def _take(self, timeout_s: float) -> Iterator[Message]:
        if self._waiting:
            timeout_s = 0.0
        while self._waiting:
            yield self._waiting.pop(0)
        try:
            data = self._stream.read(timeout_s)
        except StreamClosed as error:
            raise DaemonError(str(error)) from error
        for message in self._link.receive(data):
            if isinstance(message, Notice) and message.kind is NoticeKind.DROPPED:
                self.dropped += message.count
            if isinstance(message, Notice) and message.kind is NoticeKind.GOODBYE:
                raise DaemonError(f"gripd closes the connection: {message.message}")
            yield message

    def _greeting(self, patience_s: float) -> Welcome:
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            for message in self._take(0.1):
                if isinstance(message, Welcome):
                    return message
        bad = self.counters.bad_blocks
        raise DaemonError(f"no gripd answers, {bad} blocks came that are no frames" if bad else "no gripd answers")

    def _until(self, kind: Kind, seq: int, patience_s: float) -> list[Message]:
        end = time.monotonic() + patience_s
        found: list[Message] = []
        while time.monotonic() < end:
            for message in self._take(0.1):
                if not isinstance(message, (Ack, Nack)) or (message.kind, message.request_seq) != (kind, seq):
                    found.append(message)
                elif isinstance(message, Nack):
                    raise PermissionError(f"gripd refuses {kind.name}: {message.reason.name.lower()}")
                else:
                    return found
        raise DaemonError(f"no answer to {kind.name}")
