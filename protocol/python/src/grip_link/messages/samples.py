"""SAMPLES payloads and a channel layout in, rows of numbers out, and back."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Optional, Union

from .codes import ChannelKind, SampleFormat, Unit
from .ident import Channel
from .wire import BadValue, PayloadError, ShortPayload, closed, pack, unpack

HEADER = struct.Struct("<IQHBBI")
NO_READING = -32768


@dataclass(frozen=True)
class Column:
    """Place of one channel in a row."""

    kind: ChannelKind
    unit: Unit
    scale: float
    first: int
    count: int


class Layout:
    """The columns of a row: the channels of a mask, in the order of IDENT."""

    def __init__(self, channels: Sequence[Channel] = (), mask: int = 0) -> None:
        columns: list[Column] = []
        first = 0
        for bit, channel in enumerate(channels[:16]):
            if mask >> bit & 1:
                columns.append(Column(channel.kind, channel.unit, channel.scale, first, channel.count))
                first += channel.count
        self.columns = tuple(columns)
        self.elements = first
        """Elements of a row."""
        self._scales = tuple(column.scale for column in columns for _ in range(column.count))

    def column(self, kind: int) -> Optional[Column]:
        """The first column of a kind."""
        return next((column for column in self.columns if column.kind == kind), None)

    def row_bytes(self, sample_format: SampleFormat) -> int:
        """Bytes of a row."""
        return self.elements * sample_format.size

    def scaled(self, row: Sequence[Union[int, float]], sample_format: SampleFormat) -> tuple[float, ...]:
        """Values of a row in their units; NaN where a channel had no reading."""
        if sample_format is SampleFormat.F32:
            return tuple(row)
        return tuple(math.nan if raw == NO_READING else raw * scale for raw, scale in zip(row, self._scales))

    def raw(self, values: Sequence[float]) -> tuple[int, ...]:
        """The i16 steps of values in their units: saturating, and -32768 for NaN."""
        steps = []
        for value, scale in zip(values, self._scales):
            near = value / scale
            steps.append(NO_READING if math.isnan(near) else round(max(-32767.0, min(32767.0, near))))
        return tuple(steps)


@dataclass(frozen=True)
class Samples:
    """SAMPLES (90), MCU to host: u32 number of the first row, u64 its tick, u16 ticks from row to row, u8 rows,
    u8 format, u32 rows dropped since the start, the rows."""

    first_index: int
    t0_tick: int
    dt_ticks: int
    format: SampleFormat
    dropped_total: int
    elements: int
    """Elements of a row."""
    data: bytes
    """The rows as on the wire."""

    def __len__(self) -> int:
        return len(self.data) // (self.elements * self.format.size)

    @property
    def rows(self) -> list[tuple[Union[int, float], ...]]:
        """The rows: i16 steps or f32 values."""
        code = "h" if self.format is SampleFormat.I16 else "f"
        return list(struct.iter_unpack(f"<{self.elements}{code}", self.data))

    @classmethod
    def parse(cls, payload: bytes, elements: int) -> Samples:
        """Reads a payload whose rows have this many elements; raises PayloadError."""
        first, t0, dt, count, fmt, dropped = unpack(HEADER, payload)
        if count == 0:
            raise BadValue(14, count)
        sample_format = closed(SampleFormat, fmt, 15)
        if elements == 0:
            raise BadValue(HEADER.size, 0)
        end = HEADER.size + count * elements * sample_format.size
        if len(payload) < end:
            raise ShortPayload(end, len(payload))
        return cls(first, t0, dt, sample_format, dropped, elements, payload[HEADER.size : end])

    def pack(self) -> bytes:
        """The payload; raises PayloadError when there is no row or the rows are not whole."""
        if self.elements < 1 or not self.data or len(self.data) % (self.elements * self.format.size):
            raise PayloadError(f"{len(self.data)} bytes are no rows of {self.elements} elements")
        head = (self.first_index, self.t0_tick, self.dt_ticks, len(self), self.format, self.dropped_total)
        return pack(HEADER, *head) + self.data


def pack_rows(rows: Sequence[Sequence[Union[int, float]]], sample_format: SampleFormat) -> bytes:
    """Bytes of rows of i16 steps or f32 values."""
    code = "h" if sample_format is SampleFormat.I16 else "f"
    return b"".join(pack(struct.Struct(f"<{len(row)}{code}"), *row) for row in rows)
