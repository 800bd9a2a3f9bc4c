"""Bytes in, the same bytes without zeros out (consistent overhead byte stuffing), and back.

A code byte c stands before c - 1 data bytes; a zero follows them unless c = 255 or the data end there. After a final
block of exactly 254 data bytes this encoder ends, and the decoder also takes the trailing 01 that others add.
"""

from __future__ import annotations

_FULL = 254


class CobsError(ValueError):
    """A code is 0 or points past the end of the block."""


def max_encoded(length: int) -> int:
    """Longest encoding of ``length`` bytes."""
    return 1 if length == 0 else length + -(-length // _FULL)


def encode(data: bytes) -> bytes:
    """Encodes ``data``, without delimiters."""
    out = bytearray()
    *inner, last = bytes(data).split(b"\0")
    for part in inner:
        while len(part) >= _FULL:
            out.append(255)
            out += part[:_FULL]
            part = part[_FULL:]
        out.append(len(part) + 1)
        out += part
    while len(last) > _FULL:
        out.append(255)
        out += last[:_FULL]
        last = last[_FULL:]
    out.append(len(last) + 1)
    out += last
    return bytes(out)


def decode(block: bytes) -> bytes:
    """Decodes a block without delimiters; raises :class:`CobsError`."""
    out = bytearray()
    at, end = 0, len(block)
    if end == 0:
        raise CobsError("an empty block")
    while at < end:
        code = block[at]
        following = at + code
        if code == 0 or following > end:
            raise CobsError(f"code {code} at byte {at} of {end}")
        out += block[at + 1 : following]
        at = following
        if code != 255 and at < end:
            out.append(0)
    return bytes(out)
