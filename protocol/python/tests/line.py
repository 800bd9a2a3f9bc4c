"""A host and a device on one line in simulated time: bytes pass through functions that tests may replace."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Callable, Optional, TypeVar

from grip_link.decoder import Decoder, Role
from grip_link.device import DeviceLink, Drive
from grip_link.diff import reference_ident
from grip_link.frame import Frame
from grip_link.host import GripCommand, HostConfig, HostEvent, HostLink, HostState, StateChanged
from grip_link.messages import Config, Ident, Kind, SampleFormat, Status

T = TypeVar("T")
Wire = Callable[[bytes], bytes]

WANTED = Config(sample_rate_hz=1000, batch=1, channel_mask=3, force_max_mn=10_000, slew_mn_s=200_000, hold_cap_mn=8_000)


def ident(boot_id: int = 1) -> Ident:
    """The reference gripper in a given boot."""
    from dataclasses import replace

    return replace(reference_ident(), boot_id=boot_id)


def unchanged(data: bytes) -> bytes:
    """A line without faults."""
    return data


def frames_in(data: bytes) -> Iterator[Frame]:
    """All good frames of either direction, without judging session and sequence."""
    for role in (Role.TAP, Role.DEVICE):
        for block in Decoder(role).feed(data):
            if block.frame is not None and (block.frame.header.to_host == (role is Role.TAP)):
                yield block.frame


def kinds_in(data: bytes) -> list[int]:
    """Types of all good frames."""
    return [frame.header.kind for frame in frames_in(data)]


class Line:
    """One line; each step lasts 500 us. ``force_n`` is what the host's controller wants, None = it sends no GRIP."""

    STEP_US = 500

    def __init__(self, config: Config = WANTED) -> None:
        self.now_us = 1_000_000
        self.host = HostLink(HostConfig(config))
        self.device = DeviceLink(ident())
        self.boot_us = self.now_us
        self.events: list[HostEvent] = []
        self.drives: list[tuple[int, Drive]] = []
        self.force_n: Optional[float] = None
        self.host_runs = True
        self.to_device: Wire = unchanged
        self.to_host: Wire = unchanged
        self._rows = 0
        self.device.ready(0)

    @property
    def tick(self) -> int:
        """Time of the device."""
        return self.now_us - self.boot_us

    def open(self, session: int = 0xBEEF) -> None:
        """Opens the link and lets it run until samples flow."""
        self.host.open(self.now_us, session)
        self.run(200)
        assert self.host.state is HostState.STREAM, self.events

    def reboot(self) -> None:
        """The device starts anew with the next boot_id."""
        self.boot_us = self.now_us
        self.device = DeviceLink(ident(self.device.ident.boot_id + 1))
        self.device.ready(0)
        self._rows = 0

    def run(self, for_ms: float) -> None:
        """Lets time go on."""
        for _ in range(round(for_ms * 1000 / self.STEP_US)):
            self.now_us += self.STEP_US
            self._device_turn(self.to_device(self._host_turn() if self.host_runs else b""))

    def _host_turn(self) -> bytes:
        out = b""
        while True:
            wire = self.host.poll_transmit(self.now_us)
            if wire is None:
                break
            out += wire
        if self.force_n is not None and self.now_us % 1000 == 0:
            out += self.host.grip(self.now_us, GripCommand.newtons(self.force_n)) or b""
        return out

    def _device_turn(self, data: bytes) -> None:
        self.device.receive(self.tick, data)
        if self.tick // 1000 > self._rows:
            self._rows = self.tick // 1000
            if self.device.sampling:
                values = (1e-6 * math.sin(self._rows / 10), 2.5)
                raw = self.device.format is SampleFormat.I16
                self.device.push(self.tick, self.device.layout.raw(values) if raw else values)
        self.drives.append((self.now_us, self.device.drive(self.tick)))
        out = b""
        while True:
            wire = self.device.poll_transmit(self.tick)
            if wire is None:
                break
            out += wire
        data = self.to_host(out)
        if self.host_runs:
            self.events += self.host.receive(self.now_us, data)

    def told(self, kind: type[T]) -> list[T]:
        """Events of one type."""
        return [event for event in self.events if isinstance(event, kind)]

    @property
    def status(self) -> Status:
        """The newest STATUS."""
        return self.told(Status)[-1]

    @property
    def states(self) -> list[HostState]:
        """States the host went through."""
        return [event.after for event in self.told(StateChanged)]

    @property
    def force_mn(self) -> int:
        """Force at the actuator now."""
        return self.drives[-1][1].force_mn

    def most_mn_since(self, now_us: int) -> int:
        """Largest force at the actuator since a time."""
        return max(drive.force_mn for at_us, drive in self.drives if at_us >= now_us)


def without(kind: Kind, most: int = 1_000_000) -> Wire:
    """A line that loses the first ``most`` frames of a type."""
    left = most

    def lose(data: bytes) -> bytes:
        nonlocal left
        kept = b""
        for wire in data.split(b"\0\0"):
            wire = b"\0" + wire.strip(b"\0") + b"\0"
            if left > 0 and kind in kinds_in(wire):
                left -= 1
            else:
                kept += wire
        return kept

    return lose
