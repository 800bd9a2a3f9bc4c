"""A port, pseudo-terminal, socket or pyserial URL in; an object that reads and writes bytes out."""

from __future__ import annotations

import contextlib
import os
import select
import time
from typing import Any, Optional, Protocol


class StreamClosed(ConnectionError):
    """The other end is gone, or the port was unplugged."""


class ByteStream(Protocol):
    """What a link needs of a port."""

    def read(self, timeout_s: float) -> bytes:
        """Bytes that have come, waiting at most so long for the first; b"" when none came. Raises StreamClosed."""

    def write(self, data: bytes) -> int:
        """Bytes taken, 0..len(data), without waiting long. Raises StreamClosed."""

    def close(self) -> None:
        """Gives the port back."""


class FdStream:
    """A file descriptor that select knows: the end of a pseudo-terminal, a socket, a serial port of this system; or two pipes."""

    CHUNK = 65536

    def __init__(self, fd: int, *, owns: bool = True, out: Optional[int] = None, port: Any = None) -> None:
        """``out``: where bytes are written to, if not to ``fd``; ``port``: the open pyserial port that the descriptor belongs to."""
        self._fd, self._out, self._owns, self._port = fd, fd if out is None else out, owns, port
        os.set_blocking(fd, False)
        os.set_blocking(self._out, False)

    def read(self, timeout_s: float) -> bytes:
        """See :class:`ByteStream`."""
        try:
            if not select.select([self._fd], [], [], max(timeout_s, 0.0))[0]:
                return b""
            data = os.read(self._fd, self.CHUNK)
        except BlockingIOError:
            return b""
        except (OSError, ValueError) as error:
            raise StreamClosed(f"cannot read: {error}") from error
        if not data:
            raise StreamClosed("the other end closed the port")
        return data

    def write(self, data: bytes) -> int:
        """See :class:`ByteStream`."""
        try:
            return os.write(self._out, data)
        except BlockingIOError:
            return 0
        except OSError as error:
            raise StreamClosed(f"cannot write: {error}") from error

    def close(self) -> None:
        """See :class:`ByteStream`."""
        if self._port is not None:
            self._port.close()
        elif self._owns and self._fd >= 0:
            os.close(self._fd)
        self._fd = self._out = -1


class SerialStream:
    """A port that only pyserial can drive: loop://, rfc2217://, a port of Windows."""

    def __init__(self, port: Any) -> None:
        self._port = port

    def read(self, timeout_s: float) -> bytes:
        """See :class:`ByteStream`."""
        try:
            if self._port.timeout != timeout_s:
                self._port.timeout = timeout_s
            return bytes(self._port.read(max(self._port.in_waiting, 1)))
        except (OSError, TypeError) as error:
            raise StreamClosed(f"cannot read: {error}") from error

    def write(self, data: bytes) -> int:
        """See :class:`ByteStream`."""
        try:
            taken = self._port.write(data)
        except (OSError, TypeError) as error:
            raise StreamClosed(f"cannot write: {error}") from error
        return len(data) if taken is None else int(taken)

    def close(self) -> None:
        """See :class:`ByteStream`."""
        self._port.close()


def open_stream(url: str, baudrate: int = 115_200) -> ByteStream:
    """Opens a serial device, a pseudo-terminal or a pyserial URL such as socket://HOST:PORT.

    A device is opened for this process alone. USB ports ignore the baud rate; 1200 is refused, because it sends
    many boards to their boot loader. Raises ValueError for it, OSError when the port cannot be opened.
    """
    import serial

    if baudrate == 1200:
        raise ValueError("1200 baud sends many boards to their boot loader")
    port = serial.serial_for_url(url, baudrate=baudrate, timeout=0.0, write_timeout=0.5, do_not_open=True)
    if os.name != "posix" or ("://" in url and not url.startswith("socket://")):
        port.open()
        return SerialStream(port)
    if "://" not in url:
        port.exclusive = True
    port.open()
    if "://" not in url:
        _prepare_device(port)
    return FdStream(port.fileno(), port=port)


def _prepare_device(port: Any) -> None:
    """Keeps the modem lines at closing, so that a board does not reset, and asks for bytes without delay."""
    import termios

    attributes = termios.tcgetattr(port.fd)
    attributes[2] &= ~termios.HUPCL
    termios.tcsetattr(port.fd, termios.TCSANOW, attributes)
    # Only drivers that hold bytes back (FTDI: 16 ms) know this mode; the others refuse it and need none.
    with contextlib.suppress(ValueError, OSError, NotImplementedError):
        port.set_low_latency_mode(True)


def monotonic_us() -> int:
    """Host time [us] of a clock that no time service slews, where the system has one."""
    raw = getattr(time, "CLOCK_MONOTONIC_RAW", None)
    now_ns = time.monotonic_ns() if raw is None else time.clock_gettime_ns(raw)
    return now_ns // 1000


class Outgoing:
    """Writes frames whole: what a port did not take is written before the next frame."""

    def __init__(self, stream: ByteStream) -> None:
        self._stream = stream
        self._rest = b""

    @property
    def is_free(self) -> bool:
        """Whether the next frame can go out, after writing what is left of the one before."""
        if self._rest:
            self._rest = self._rest[self._stream.write(self._rest) :]
        return not self._rest

    def send(self, wire: bytes) -> bool:
        """Writes a frame; False, and nothing of it written, while the one before is not out."""
        if not self.is_free:
            return False
        self._rest = wire[self._stream.write(wire) :]
        return True
