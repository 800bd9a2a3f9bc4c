"""Header and payload in, wire bytes ``00 | COBS(body) | 00`` out, and a checked body back.

Body, little-endian: u8 version << 4 | flags (b0 to host, b1 ACK_REQ), u8 type, u16 seq, u16 session, u16 len, payload
of 0..480 bytes, u32 CRC-32C of all before it.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from . import cobs
from .crc import crc32c

PROTOCOL = 1
MAX_PAYLOAD = 480
OVERHEAD = 12
MAX_BLOCK = cobs.max_encoded(MAX_PAYLOAD + OVERHEAD)
MAX_WIRE = MAX_BLOCK + 2

_HEADER = struct.Struct("<BBHHH")
_CRC = struct.Struct("<I")


@dataclass(frozen=True)
class Header:
    """The first eight bytes of a body, without the length."""

    kind: int
    seq: int
    session: int
    to_host: bool
    ack_req: bool = False
    version: int = PROTOCOL


@dataclass(frozen=True)
class Frame:
    """A header and 0..480 payload bytes."""

    header: Header
    payload: bytes


class BodyError(ValueError):
    """A decoded body that is no frame."""


class LengthError(BodyError):
    """The length field and the bytes disagree, or there are fewer bytes than header and CRC."""


class CrcError(BodyError):
    """The checksum disagrees."""


def encode(header: Header, payload: bytes = b"") -> bytes:
    """All bytes of a frame on the wire, both delimiters included.

    Raises ValueError for more than 480 payload bytes and for a header field outside its range.
    """
    if len(payload) > MAX_PAYLOAD:
        raise ValueError(f"payload of {len(payload)} bytes, at most {MAX_PAYLOAD} fit")
    if not 0 <= header.version <= 15:
        raise ValueError(f"version {header.version} does not fit four bits")
    first = header.version << 4 | int(header.to_host) | int(header.ack_req) << 1
    try:
        head = _HEADER.pack(first, header.kind, header.seq, header.session, len(payload))
    except struct.error as error:
        raise ValueError(f"{header}: {error}") from None
    covered = head + payload
    return b"\0" + cobs.encode(covered + _CRC.pack(crc32c(covered))) + b"\0"


def from_body(body: bytes) -> Frame:
    """Checks length, then CRC, of a decoded body; raises :class:`LengthError` or :class:`CrcError`."""
    if not OVERHEAD <= len(body) <= OVERHEAD + MAX_PAYLOAD:
        raise LengthError(f"body of {len(body)} bytes")
    first, kind, seq, session, length = _HEADER.unpack_from(body)
    if length != len(body) - OVERHEAD:
        raise LengthError(f"length field {length}, payload of {len(body) - OVERHEAD} bytes")
    covered = body[:-4]
    (found,) = _CRC.unpack_from(body, len(covered))
    computed = crc32c(covered)
    if found != computed:
        raise CrcError(f"checksum {found:08x} in the frame, {computed:08x} computed")
    header = Header(kind, seq, session, bool(first & 1), bool(first & 2), first >> 4)
    return Frame(header, covered[8:])
