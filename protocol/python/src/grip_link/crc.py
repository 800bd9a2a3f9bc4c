"""Bytes in, their CRC-32C (Castagnoli) out.

Reflected polynomial 82F63B78, initial value and final xor FFFFFFFF; the check value of ``123456789`` is E3069283.
"""

from __future__ import annotations

_POLYNOMIAL = 0x82F63B78


def _table() -> tuple[int, ...]:
    entries = []
    for crc in range(256):
        for _ in range(8):
            crc = crc >> 1 ^ (_POLYNOMIAL if crc & 1 else 0)
        entries.append(crc)
    return tuple(entries)


_TABLE = _table()


def crc32c(data: bytes, crc: int = 0) -> int:
    """Checksum of ``data``; pass the checksum of what went before to continue it."""
    table = _TABLE
    state = crc ^ 0xFFFFFFFF
    for byte in data:
        state = table[(state ^ byte) & 0xFF] ^ state >> 8
    return state ^ 0xFFFFFFFF
