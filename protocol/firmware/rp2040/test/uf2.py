#!/usr/bin/env python3
"""An ELF file for the RP2040 in, the UF2 file that its boot loader takes out.

  uf2.py FIRMWARE.elf FIRMWARE.uf2

The segments with bytes in the file are laid at their load addresses, in blocks of 256 bytes. The boot loader needs the
first 256 bytes of the flash to end with their CRC; a file without a good one is refused."""

import struct
import sys
from pathlib import Path

FLASH, RAM, BLOCK, FAMILY = 0x10000000, 0x20000000, 256, 0xE48BFF56


def crc32(data):
    """CRC-32/MPEG-2, that of the boot ROM."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte << 24
        for _ in range(8):
            crc = (crc << 1 ^ 0x04C11DB7 if crc & 0x80000000 else crc << 1) & 0xFFFFFFFF
    return crc


def image(elf):
    """What lies in flash, from its first byte on; its bytes without gaps, and those of static RAM."""
    if elf[:6] != b"\x7fELF\x01\x01":
        raise ValueError("no 32-bit little-endian ELF file")
    (table,), (size, count) = struct.unpack_from("<I", elf, 28), struct.unpack_from("<HH", elf, 42)
    flash, used, ram = bytearray(), 0, 0
    for k in range(count):
        kind, offset, place, address, length, memory = struct.unpack_from("<6I", elf, table + k * size)
        ram += memory if kind == 1 and place >= RAM else 0
        if kind != 1 or length == 0:
            continue
        used += length
        at = address - FLASH
        if not 0 <= at < 2**21:
            raise ValueError(f"a segment lies at {address:#x}, outside of the flash")
        flash.extend(bytes(max(0, at + length - len(flash))))
        flash[at : at + length] = elf[offset : offset + length]
    if struct.unpack_from("<I", flash, 252)[0] != crc32(flash[:252]):
        raise ValueError("the first 256 bytes do not end with their CRC")
    return bytes(flash), used, ram


def uf2(flash):
    """Blocks of 512 bytes, each with its place."""
    total = -(-len(flash) // BLOCK)
    for k in range(total):
        data = flash[k * BLOCK : (k + 1) * BLOCK].ljust(476, b"\0")
        head = struct.pack("<8I", 0x0A324655, 0x9E5D5157, 0x2000, FLASH + k * BLOCK, BLOCK, k, total, FAMILY)
        yield head + data + struct.pack("<I", 0x0AB16F30)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    try:
        flash, used, ram = image(Path(sys.argv[1]).read_bytes())
        Path(sys.argv[2]).write_bytes(b"".join(uf2(flash)))
        print(f"{sys.argv[2]}: flash {used} bytes, static RAM {ram} bytes")
    except (OSError, ValueError, struct.error) as error:
        sys.exit(f"uf2.py: {sys.argv[1]}: {error}")


if __name__ == "__main__":
    main()
