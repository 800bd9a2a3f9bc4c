"""The bus of Feetech's STS servos: packets, and the two registers of a gripper. For an arm without LeRobot, and for the virtual one."""

from __future__ import annotations

import threading
import time
from typing import Iterator, Optional, Tuple

import serial

PING, READ, WRITE, SYNC_READ, SYNC_WRITE, EVERYBODY = 1, 2, 3, 0x82, 0x83, 0xFE
TORQUE_ENABLE, TORQUE_LIMIT, PRESENT_LOAD = 40, 48, 60
GRIPPER = 6
"""Number of the gripper's servo in an SO-100 or SO-101."""
SIGN = 1 << 10
"""Of a load: the bit of its direction."""


class BusError(OSError):
    """No answer, a damaged one, or one with an error of the servo."""


def packet(number: int, kind: int, data: bytes = b"") -> bytes:
    """An instruction, or an answer with its error in the place of the kind."""
    body = bytes([number, len(data) + 2, kind]) + data
    return b"\xff\xff" + body + bytes([~sum(body) & 0xFF])


def packets(buffer: bytearray) -> Iterator[Tuple[int, int, bytes]]:
    """Takes whole packets out of what was received: number, kind, data. What is damaged is skipped."""
    while len(buffer) >= 6:
        if buffer[:2] != b"\xff\xff" or buffer[2] == 0xFF:
            del buffer[0]
            continue
        end = buffer[3] + 4
        if buffer[3] < 2:
            del buffer[0]
        elif len(buffer) < end:
            return
        elif sum(buffer[2:end]) & 0xFF != 0xFF:
            del buffer[0]
        else:
            number, kind, data = buffer[2], buffer[4], bytes(buffer[5 : end - 1])
            del buffer[:end]
            yield number, kind, data


class Gripper:
    """The gripper's servo on a bus of its own. Threads may share it."""

    def __init__(self, port: str, number: int = GRIPPER, patience_s: float = 0.02) -> None:
        """Raises OSError where the port cannot be opened."""
        self.number, self._patience_s, self._lock = number, patience_s, threading.Lock()
        self._port = serial.Serial(port, 1_000_000, timeout=0.002)

    def limit(self, thousandths: int) -> None:
        """Writes the torque limit, in 0.1 % of the stall torque; raises BusError."""
        self.write(TORQUE_LIMIT, thousandths.to_bytes(2, "little"))

    def limited(self) -> int:
        """The torque limit as it stands, in 0.1 % of the stall torque; raises BusError."""
        return int.from_bytes(self._ask(READ, bytes([TORQUE_LIMIT, 2]), 2), "little")

    def load(self) -> int:
        """The present load, in 0.1 % of the stall torque, without its direction; raises BusError."""
        return int.from_bytes(self._ask(READ, bytes([PRESENT_LOAD, 2]), 2), "little") & (SIGN - 1)

    def powered(self) -> bool:
        """Whether the servo holds at all: not after it was reset. Raises BusError."""
        return bool(self._ask(READ, bytes([TORQUE_ENABLE, 1]), 1)[0])

    def write(self, register: int, data: bytes) -> None:
        """Writes registers; raises BusError."""
        self._ask(WRITE, bytes([register]) + data, 0)

    def close(self) -> None:
        self._port.close()

    def _ask(self, kind: int, data: bytes, expected: int) -> bytes:
        with self._lock:
            self._port.reset_input_buffer()
            self._port.write(packet(self.number, kind, data))
            received, end = bytearray(), time.monotonic() + self._patience_s
            while time.monotonic() < end:
                received += self._port.read(max(1, self._port.in_waiting))
                answer = self._answer(received, expected)
                if answer is not None:
                    return answer
        raise BusError(f"servo {self.number}: no answer")

    def _answer(self, received: bytearray, expected: int) -> Optional[bytes]:
        for number, error, data in packets(received):
            if number == self.number and len(data) == expected:
                # Bits of overload and overheating are no reason to stop listening: it has answered.
                return data
            if number == self.number and error:
                raise BusError(f"servo {number}: error {error:#x}")
        return None
