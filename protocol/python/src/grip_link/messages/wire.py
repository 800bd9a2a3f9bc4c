"""Struct layouts and payload bytes in, field values or a named error out."""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import Any, TypeVar

_Closed = TypeVar("_Closed", bound=IntEnum)


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


def closed(codes: type[_Closed], value: int, at: int) -> _Closed:
    """The code with this number; raises :class:`BadValue` for a number that is none."""
    try:
        return codes(value)
    except ValueError:
        raise BadValue(at, value) from None
