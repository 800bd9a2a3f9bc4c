"""ROWS: samples as the pipeline got them."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

from ..codes import Kind
from ..wire import MESSAGES, BadValue, PayloadError, ShortPayload, pack, unpack
from .codes import RowSet

_HEADER = struct.Struct("<IQHHBBH")


@dataclass(frozen=True)
class Row:
    """All channels at one time."""

    index: int
    t_us: int
    values: dict[RowSet, float]
    """NaN where a channel had no reading."""
    taxels: tuple[float, ...]


@dataclass(frozen=True)
class Rows:
    """ROWS (A5): u32 number of the first row, u64 its time [us], u16 step from number to number, u16 channels, u8 rows,
    u8 taxels, u16 reserved; each row is a u32, its time after the first [us], and an f32 for each channel and taxel."""

    first_index: int
    t0_us: int
    every_nth: int
    channels: RowSet
    taxels: int
    data: bytes
    """The rows as on the wire."""

    @property
    def row_bytes(self) -> int:
        """Bytes of a row."""
        return 4 + 4 * (bin(self.channels).count("1") + self.taxels)

    def __len__(self) -> int:
        return len(self.data) // self.row_bytes

    @property
    def raw(self) -> list[tuple[float, ...]]:
        """Time after the first row [us] and values, of each row."""
        return list(struct.iter_unpack(f"<I{self.row_bytes // 4 - 1}f", self.data))

    def __iter__(self) -> Iterator[Row]:
        bits = [RowSet(1 << bit) for bit in range(16) if self.channels >> bit & 1]
        for k, (after, *values) in enumerate(self.raw):
            index = (self.first_index + k * self.every_nth) & 0xFFFFFFFF
            named = dict(zip(bits, values))
            yield Row(index, self.t0_us + int(after), named, tuple(values[len(bits) :]))

    @classmethod
    def parse(cls, payload: bytes) -> Rows:
        """Reads a payload; raises PayloadError."""
        first, t0_us, every_nth, channels, count, taxels, _ = unpack(_HEADER, payload)
        for at, value in ((12, every_nth), (14, channels), (16, count)):
            if value == 0:
                raise BadValue(at, 0)
        rows = cls(first, t0_us, every_nth, RowSet(channels), taxels, b"")
        end = _HEADER.size + count * rows.row_bytes
        if len(payload) < end:
            raise ShortPayload(end, len(payload))
        return cls(first, t0_us, every_nth, RowSet(channels), taxels, payload[_HEADER.size : end])

    def pack(self) -> bytes:
        """The payload; raises PayloadError when there is no row or the rows are not whole."""
        if not self.data or len(self.data) % self.row_bytes:
            raise PayloadError(f"{len(self.data)} bytes are no rows of {self.row_bytes} bytes")
        head = (self.first_index, self.t0_us, self.every_nth, self.channels, len(self), self.taxels, 0)
        return pack(_HEADER, *head) + self.data


MESSAGES[Kind.ROWS] = Rows
