"""Wire bytes in any chunking in, checked frames and counted faults out.

The checks come in this order, and a block that fails one is not looked at further: too long, COBS, length, CRC,
direction, version, session, sequence, type. One block of at most 494 bytes is kept; the memory does not grow.

A device takes HELLO of any other session and ESTOP of session 0, a host IDENT of session 0, a daemon SUBSCRIBE of any other
session, a client NOTICE of session 0; these skip the sequence check.
Every other frame must bear the open session. The first frame of a session sets the number; then one that lies
0..255 behind the newest is a duplicate, any other is taken and the numbers skipped are counted as a gap.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Optional

from . import cobs
from .frame import MAX_BLOCK, PROTOCOL, CrcError, Frame, Header, LengthError, from_body
from .messages.codes import Kind

DUPLICATE_WINDOW = 256
_U32_MAX = 0xFFFFFFFF


class Role(Enum):
    """Who is listening."""

    HOST = "host"
    DEVICE = "device"
    TAP = "tap"
    """A recording or a test: frames to the host of any session and any type."""
    DAEMON = "daemon"
    """The daemon, of one client: frames to the device of the session that the client opened."""
    CLIENT = "client"
    """A client of the daemon: frames to the host of its own session."""


class Verdict(str, Enum):
    """What became of a block; the value is the name of its counter."""

    OK = "ok"
    TOO_LONG = "too_long"
    COBS = "cobs"
    LENGTH = "length"
    CRC = "crc"
    ECHO = "echo"
    VERSION = "version"
    STALE = "stale"
    DUPLICATE = "duplicate"
    UNKNOWN = "unknown"


_NO_FRAME = frozenset((Verdict.TOO_LONG, Verdict.COBS, Verdict.LENGTH, Verdict.CRC))


@dataclass
class Counters:
    """Counts since the decoder was made; all saturate at 2^32 - 1."""

    ok: int = 0
    too_long: int = 0
    cobs: int = 0
    length: int = 0
    crc: int = 0
    echo: int = 0
    version: int = 0
    stale: int = 0
    duplicate: int = 0
    unknown: int = 0
    gap: int = 0
    garbage_bytes: int = 0

    @property
    def bad_blocks(self) -> int:
        """Blocks that were no frame at all."""
        return min(self.too_long + self.cobs + self.length + self.crc, _U32_MAX)

    def add(self, name: str, count: int = 1) -> None:
        """Raises one counter."""
        setattr(self, name, min(getattr(self, name) + count, _U32_MAX))


@dataclass(frozen=True)
class Block:
    """The bytes between two delimiters, judged. ``frame`` is there unless the block was no frame at all."""

    verdict: Verdict
    frame: Optional[Frame] = None


class Decoder:
    """Cuts a byte stream into frames.

    Without a session a device takes HELLO and ESTOP only, a host nothing but an IDENT of session 0.
    """

    def __init__(self, role: Role) -> None:
        self.counters = Counters()
        self._role = role
        self._session: Optional[int] = None
        self._last_seq: Optional[int] = None
        self._input = b""
        self._at = 0
        self._block = bytearray()
        self._size = 0

    def open_session(self, session: int, last_seq: Optional[int] = None) -> None:
        """Takes frames of ``session`` from now on; ``last_seq`` is the newest sequence number seen of it."""
        self._session, self._last_seq = session, last_seq

    def close_session(self) -> None:
        """Takes no session's frames any more."""
        self._session = self._last_seq = None

    def restart(self) -> None:
        """Forgets the bytes under way, as after reopening a port; counters and session stay."""
        self._input, self._at, self._size = b"", 0, 0
        self._block.clear()

    def feed(self, data: bytes) -> Iterator[Block]:
        """Takes bytes and gives the blocks they end. A session opened between two blocks holds for the second."""
        self._input = self._input[self._at :] + data
        self._at = 0
        return iter(self._next_block, None)

    def _next_block(self) -> Optional[Block]:
        while True:
            end = self._input.find(0, self._at)
            if end < 0:
                self._take(self._input[self._at :])
                self._input, self._at = b"", 0
                return None
            self._take(self._input[self._at : end])
            self._at = end + 1
            if self._size:
                return self._close_block()

    def _take(self, data: bytes) -> None:
        self._size += len(data)
        if self._size <= MAX_BLOCK:
            self._block += data

    def _close_block(self) -> Block:
        size, block = self._size, bytes(self._block)
        self._size = 0
        self._block.clear()
        judged = Block(Verdict.TOO_LONG) if size > MAX_BLOCK else self._judge(block)
        self.counters.add(judged.verdict.value)
        if judged.verdict in _NO_FRAME:
            self.counters.add("garbage_bytes", size)
        return judged

    def _judge(self, block: bytes) -> Block:
        try:
            frame = from_body(cobs.decode(block))
        except cobs.CobsError:
            return Block(Verdict.COBS)
        except LengthError:
            return Block(Verdict.LENGTH)
        except CrcError:
            return Block(Verdict.CRC)
        return Block(self._accept(frame.header), frame)

    def _accept(self, header: Header) -> Verdict:
        kind = header.kind
        if header.to_host == (self._role in (Role.DEVICE, Role.DAEMON)):
            return Verdict.ECHO
        if header.version != PROTOCOL and kind not in GREETINGS[self._role]:
            return Verdict.VERSION
        if self._outside_session(header):
            return Verdict.OK
        if self._role is not Role.TAP and header.session != self._session:
            return Verdict.STALE
        if not self._follow(header.seq):
            return Verdict.DUPLICATE
        known = self._role is Role.TAP or kind in KNOWN[self._role]
        return Verdict.OK if known else Verdict.UNKNOWN

    def _outside_session(self, header: Header) -> bool:
        if header.session == 0 and header.kind == OF_NO_SESSION.get(self._role):
            return True
        return header.session != self._session and header.kind == OPENS.get(self._role)

    def _follow(self, seq: int) -> bool:
        last = self._last_seq
        if last is not None:
            if (last - seq) & 0xFFFF < DUPLICATE_WINDOW:
                return False
            self.counters.add("gap", (seq - last - 1) & 0xFFFF)
        self._last_seq = seq
        return True


TO_DEVICE = frozenset(
    (Kind.HELLO, Kind.CONFIG, Kind.START, Kind.STOP, Kind.PING, Kind.GRIP, Kind.HEARTBEAT, Kind.ESTOP, Kind.CLEAR_FAULT)
)
TO_HOST = frozenset(
    (
        Kind.IDENT, Kind.CONFIG_ACK, Kind.PONG, Kind.ACK, Kind.NACK,
        Kind.SAMPLES, Kind.STATUS, Kind.STATS, Kind.EVENT, Kind.LOG,
    )
)  # fmt: skip
TO_DAEMON = frozenset((Kind.SUBSCRIBE, Kind.COMMAND, Kind.QUERY, Kind.LOAD, Kind.OBJECT, Kind.SHADOW))
TO_CLIENT = frozenset(
    (
        Kind.WELCOME, Kind.SLIP, Kind.STATE, Kind.HEALTH, Kind.GRIPPER, Kind.ROWS, Kind.NOTICE,
        Kind.SETUP, Kind.ESTIMATES, Kind.ACK, Kind.NACK,
    )
)  # fmt: skip
KNOWN = {Role.HOST: TO_HOST, Role.DEVICE: TO_DEVICE, Role.DAEMON: TO_DAEMON, Role.CLIENT: TO_CLIENT}
OPENS = {Role.DEVICE: Kind.HELLO, Role.DAEMON: Kind.SUBSCRIBE}
OF_NO_SESSION = {Role.DEVICE: Kind.ESTOP, Role.HOST: Kind.IDENT, Role.CLIENT: Kind.NOTICE}
_OF_THE_LINE = frozenset((Kind.HELLO, Kind.IDENT))
GREETINGS = {
    Role.HOST: _OF_THE_LINE, Role.DEVICE: _OF_THE_LINE, Role.TAP: _OF_THE_LINE,
    Role.DAEMON: frozenset((Kind.SUBSCRIBE,)), Role.CLIENT: frozenset((Kind.WELCOME,)),
}  # fmt: skip
