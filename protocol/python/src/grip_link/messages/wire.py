"""Messages as tables: a layout gives each field its place; reading, writing and named errors follow from it."""

from __future__ import annotations

import math
import re
import struct
import sys
from collections.abc import Sequence
from dataclasses import fields
from functools import lru_cache
from typing import Any, ClassVar, Optional, TypeVar, get_args, get_type_hints

from .codes import Kind

_Number = TypeVar("_Number", bound=int)
_Message = TypeVar("_Message", bound="Message")


class PayloadError(ValueError):
    """A payload that cannot be read or written."""


class ShortPayload(PayloadError):
    """The payload ends before a field."""

    def __init__(self, need: int, have: int) -> None:
        super().__init__(f"payload of {have} bytes ends before byte {need}")
        self.need = need
        self.have = have


class BadValue(PayloadError):
    """A field holds a value that has no meaning."""

    def __init__(self, at: int, value: float) -> None:
        super().__init__(f"byte {at} holds {value}, which is outside its range")
        self.at = at
        self.value = value


def unpack(layout: struct.Struct, payload: bytes, at: int = 0) -> tuple[Any, ...]:
    """Fields of ``layout`` at offset ``at``; what follows them is ignored."""
    if len(payload) < at + layout.size:
        raise ShortPayload(at + layout.size, len(payload))
    return layout.unpack_from(payload, at)


def pack(layout: struct.Struct, *values: Any) -> bytes:
    """Bytes of the fields; raises :class:`PayloadError` for a value that its field cannot hold."""
    try:
        return layout.pack(*values)
    except (struct.error, OverflowError) as error:
        raise PayloadError(str(error)) from None


def closed(codes: type[_Number], value: int, at: int) -> _Number:
    """The code with this number, or the number itself; raises :class:`BadValue` for one that is no code."""
    try:
        return codes(value)
    except ValueError:
        raise BadValue(at, value) from None


@lru_cache(maxsize=None)
def _types(message: type) -> list[Any]:
    """The type of each field, without None."""
    hints = [get_type_hints(message)[field.name] for field in fields(message)]
    return [get_args(hint)[0] if type(None) in get_args(hint) else hint for hint in hints]


class Message:
    """A payload with a dataclass field for each place of ``layout``, written as for :mod:`struct`, little-endian: ``x`` is reserved, ``24Q``
    a tuple, ``t`` at the end a text of at most 255 bytes behind its length. Each group of ``appended`` is None where an older program does not
    send it. A code that is not open, an infinite number, and what is outside of ``RANGES`` is refused in what is read."""

    RANGES: ClassVar[dict[str, tuple[int, float]]] = {}
    _text: ClassVar[bool]
    _base: ClassVar[struct.Struct]
    _places: ClassVar[list[tuple[int, struct.Struct, int]]]
    """Offset of a field, its bytes, and where its group ends."""

    def __init_subclass__(cls, layout: str = "", appended: Sequence[str] = (), kind: Optional[Kind] = None) -> None:
        cls._text = layout.endswith("t")
        cls._base = struct.Struct("<" + layout.replace("t", "B"))
        cls._places, at = [], 0
        for group in (layout.rstrip("t"), *appended):
            end = at + struct.calcsize("<" + group)
            for code in re.findall(r"\d*[a-zA-Z]", group):
                one = struct.Struct("<" + code)
                if code[-1] != "x":
                    cls._places.append((at, one, end))
                at += one.size
        if kind is not None:
            MESSAGES[kind] = cls

    @classmethod
    def parse(cls: type[_Message], payload: bytes) -> _Message:
        """Reads a payload; raises PayloadError."""
        unpack(cls._base, payload)
        values: list[Any] = []
        for (at, place, end), kind, field in zip(cls._places, _types(cls), fields(cls)):  # type: ignore[arg-type]
            if len(payload) < end:
                break
            read = place.unpack_from(payload, at)
            value = read[0] if len(read) == 1 else read
            low, high = cls.RANGES.get(field.name, (-sys.float_info.max, sys.float_info.max))
            if isinstance(value, (int, float)) and not (low <= value <= high or math.isnan(value)):
                raise BadValue(at, value)
            values.append(closed(kind, value, at) if isinstance(value, int) else value)
        if cls._text:
            end = cls._base.size + payload[cls._base.size - 1]
            if len(payload) < end:
                raise ShortPayload(end, len(payload))
            values.append(payload[cls._base.size : end])
        return cls(*values)

    def pack(self) -> bytes:
        """The payload; raises PayloadError."""
        values = [getattr(self, field.name) for field in fields(self)]  # type: ignore[arg-type]
        tail = b""
        if self._text:
            tail = values.pop()
            values.append(len(tail))
        count = len([1 for at, _, _ in self._places if at < self._base.size]) + self._text
        head = pack(self._base, *(n for value in values[:count] for n in (value if isinstance(value, tuple) else (value,))))
        later = values[count:]
        while later and later[-1] is None:
            later.pop()
        for (_, place, _), value in zip(self._places[count:], later):
            missing = math.nan if place.format == "<f" else 0
            head += pack(place, *(value if isinstance(value, tuple) else (missing if value is None else value,)))
        return head + tail


MESSAGES: dict[int, Any] = {}
"""Each message by its type; LOAD and SHADOW are one."""
