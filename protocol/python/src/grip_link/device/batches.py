"""Rows in, SAMPLES payloads out; when nothing can be sent the oldest whole batch goes and is counted."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Optional

from ..frame import MAX_PAYLOAD
from ..messages import Config, SampleFormat, Samples
from ..messages.samples import HEADER

KEPT_BATCHES = 4
_MASK = 0xFFFFFFFF


@dataclass
class _Open:
    first_index: int = 0
    t0_tick: int = 0
    rows: int = 0
    data: bytearray = field(default_factory=bytearray)


class Batches:
    """At most four closed batches and one open one."""

    def __init__(self) -> None:
        self.format = SampleFormat.I16
        self.elements = 0
        self.dropped_rows = 0
        self.dropped_batches = 0
        self._closed: deque[_Open] = deque()
        self._open = _Open()
        self._next_index = 0
        self._rows_a_batch = 1
        self._dt_ticks = 1
        self._longest_ticks = 1

    def configure(self, config: Config, elements: int, tick_hz: int) -> None:
        """Starts with empty batches; row numbers and drop counts go on."""
        self._closed.clear()
        self._open = _Open()
        self.format = config.format
        self.elements = elements
        row_bytes = elements * config.format.size
        fitting = (MAX_PAYLOAD - HEADER.size) // row_bytes if row_bytes else 1
        self._rows_a_batch = max(min(config.batch, fitting), 1)
        self._dt_ticks = min(tick_hz // max(config.sample_rate_hz, 1), 0xFFFF)
        self._longest_ticks = tick_hz // 1000

    def push(self, tick: int, row: bytes) -> None:
        """Appends a row of exactly ``elements`` elements."""
        self.close_old(tick)
        batch = self._open
        if batch.rows == 0:
            batch.first_index, batch.t0_tick = self._next_index, tick
        self._next_index = (self._next_index + 1) & _MASK
        batch.data += row
        batch.rows += 1
        if batch.rows >= self._rows_a_batch:
            self._close()

    def close_old(self, tick: int) -> None:
        """Ends the open batch when its first row is 1 ms old."""
        if self._open.rows and max(tick - self._open.t0_tick, 0) >= self._longest_ticks:
            self._close()

    def _close(self) -> None:
        self._closed.append(self._open)
        self._open = _Open()
        if len(self._closed) > KEPT_BATCHES:
            lost = self._closed.popleft()
            self.dropped_rows = (self.dropped_rows + lost.rows) & _MASK
            self.dropped_batches = min(self.dropped_batches + 1, _MASK)

    def __len__(self) -> int:
        return len(self._closed)

    def take(self) -> Optional[bytes]:
        """Payload of the oldest closed batch, with the drops so far in its header."""
        if not self._closed:
            return None
        batch = self._closed.popleft()
        return Samples(
            batch.first_index,
            batch.t0_tick,
            self._dt_ticks,
            self.format,
            self.dropped_rows,
            self.elements,
            bytes(batch.data),
        ).pack()
