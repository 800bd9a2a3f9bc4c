"""Payloads in, numbered frames of one direction out."""

from __future__ import annotations

from typing import Optional

from . import frame
from .frame import Header


class Sender:
    """Counts and addresses outgoing frames."""

    def __init__(self, to_host: bool) -> None:
        self.session = 0
        self.sent = 0
        self.next_seq = 0
        self._to_host = to_host

    def send(self, kind: int, payload: bytes = b"", *, ack_req: bool = False, session: Optional[int] = None) -> bytes:
        """The wire bytes of the next frame; ``session`` other than the present one holds for this frame only."""
        address = self.session if session is None else session
        wire = frame.encode(Header(kind, self.next_seq, address, self._to_host, ack_req), payload)
        self.next_seq = (self.next_seq + 1) & 0xFFFF
        self.sent = min(self.sent + 1, 0xFFFFFFFF)
        return wire
