"""A configuration message and time in; when to send it again and whether an answer is its own, out."""

from __future__ import annotations

from dataclasses import dataclass

from ..messages import Kind

TRIES = 3
RETRY_US = 50_000


@dataclass
class Request:
    """What was asked and not answered yet."""

    kind: Kind
    payload: bytes
    next_us: int
    tries: int = 0
    first_seq: int = 0
    last_seq: int = 0

    def is_due(self, now_us: int) -> bool:
        """Whether it is to be sent now."""
        return now_us >= self.next_us and self.tries < TRIES

    def is_given_up(self, now_us: int) -> bool:
        """Whether all tries went unanswered."""
        return now_us >= self.next_us and self.tries >= TRIES

    def sent(self, seq: int, now_us: int) -> None:
        """Notes a try."""
        if self.tries == 0:
            self.first_seq = seq
        self.last_seq = seq
        self.tries += 1
        self.next_us = now_us + RETRY_US

    def answered_by(self, kind: int, seq: int) -> bool:
        """Whether an answer with this type and seq belongs to one of the tries."""
        since, span = (seq - self.first_seq) & 0xFFFF, (self.last_seq - self.first_seq) & 0xFFFF
        return kind == self.kind and self.tries > 0 and since <= span
