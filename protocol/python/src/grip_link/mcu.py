"""A port, a sensor and an actuator function in; a gripper that follows the rules of the link out.

For tests without hardware, and as a picture of what a firmware does. :class:`VirtualMcu` joins the sans-IO
:class:`~grip_link.device.DeviceLink` to a port and a clock.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Sequence
from dataclasses import replace
from typing import Callable, Optional

from .device import DeviceEvent, DeviceLink, Drive, Started
from .messages import Channel, ChannelKind, Ident, Limits, ResetReason, SampleFormat
from .stream import ByteStream, FdStream, Outgoing, monotonic_us

Sensor = Callable[[float], Sequence[float]]
"""Seconds since the start in, one value in SI units for each element of all channels of IDENT out."""
Actuator = Callable[[float, Drive], None]
"""Seconds since the start and what the actuator is to do."""

_CATCH_UP_S = 0.05


def default_ident(boot_id: Optional[int] = None) -> Ident:
    """A gripper with a stylus (10 nm a step) and a normal force (1 mN a step), up to 20 N and 20 kHz."""
    return Ident(
        uid=b"virtual-gripper\0",
        boot_id=secrets.randbits(32) if boot_id is None else boot_id,
        tick_hz=1_000_000,
        limits=Limits(20_000, 20_000, 400_000, 15_000, 0, 50_000),
        channels=(Channel.single(ChannelKind.STYLUS, 1e-8), Channel.single(ChannelKind.NORMAL_FORCE, 1e-3)),
        firmware=(0, 1, 0),
        reset=ResetReason.POWER_ON,
    )


class VirtualMcu:
    """A gripper at one end of a port."""

    def __init__(
        self,
        stream: ByteStream,
        sensor: Sensor,
        actuator: Optional[Actuator] = None,
        *,
        ident: Optional[Ident] = None,
        clock_us: Callable[[], int] = monotonic_us,
    ) -> None:
        self.ident = ident or default_ident()
        self.drive: Drive
        """What the actuator was told last."""
        self._stream = stream
        self._outgoing = Outgoing(stream)
        self._sensor = sensor
        self._actuator = actuator
        self._clock_us = clock_us
        self._boot()

    def _boot(self) -> None:
        self._start_us = self._clock_us()
        self._row = 0
        self._first_row_tick = 0
        self.link = DeviceLink(self.ident)
        self.link.ready(0)
        self.drive = self.link.drive(0)

    def reboot(self) -> None:
        """Starts anew, as after a reset: another boot_id, torque off, no session."""
        boot_id = (self.ident.boot_id + 1) & 0xFFFFFFFF
        self.ident = replace(self.ident, boot_id=boot_id, reset=ResetReason.WATCHDOG)
        self._boot()

    @property
    def tick(self) -> int:
        """Ticks since the start."""
        return (self._clock_us() - self._start_us) * self.ident.tick_hz // 1_000_000

    def step(self, timeout_s: float = 0.0) -> list[DeviceEvent]:
        """One turn of the firmware: receive, sample, drive, transmit. Raises StreamClosed."""
        data = self._stream.read(timeout_s)
        events = self.link.receive(self.tick, data)
        if any(isinstance(event, Started) for event in events):
            self._row, self._first_row_tick = 0, self.tick
        self._sample()
        tick = self.tick
        self.drive = self.link.drive(tick)
        if self._actuator is not None:
            self._actuator(tick / self.ident.tick_hz, self.drive)
        while self._outgoing.is_free:
            wire = self.link.poll_transmit(self.tick)
            if wire is None:
                break
            self._outgoing.send(wire)
        return events

    def run(self, duration_s: Optional[float] = None) -> None:
        """Turns until the time is over, or for good; raises StreamClosed when the port goes."""
        start_us = self._clock_us()
        while duration_s is None or (self._clock_us() - start_us) / 1e6 < duration_s:
            self.step(0.001)

    def _sample(self) -> None:
        config = self.link.in_force
        if config is None or not self.link.sampling:
            return
        period = self.ident.tick_hz / config.sample_rate_hz
        now = self.tick
        late_rows = int((now - self._first_row_tick - _CATCH_UP_S * self.ident.tick_hz) / period)
        self._row = max(self._row, late_rows)
        while self._first_row_tick + round(self._row * period) <= now:
            tick = self._first_row_tick + round(self._row * period)
            values = self._chosen(self._sensor(tick / self.ident.tick_hz), config.channel_mask)
            raw = config.format is SampleFormat.I16
            self.link.push(tick, self.link.layout.raw(values) if raw else values)
            self._row += 1

    def _chosen(self, values: Sequence[float], mask: int) -> Sequence[float]:
        chosen: list[float] = []
        at = 0
        for bit, channel in enumerate(self.ident.channels):
            if mask >> bit & 1:
                chosen += values[at : at + channel.count]
            at += channel.count
        if at != len(values):
            raise ValueError(f"the sensor gave {len(values)} values, the channels have {at} elements")
        return chosen


class Pty:
    """A pseudo-terminal: a gripper behind ``stream``, a host at ``path``."""

    def __init__(self, link: Optional[str] = None) -> None:
        """With ``link``, a symbolic link of this name leads to the pseudo-terminal. Raises OSError."""
        import tty

        master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.stream = FdStream(master)
        self.path = os.ttyname(self._slave)
        self._link = link
        if link is not None:
            try:
                os.symlink(self.path, link)
            except OSError:
                self._link = None
                self.close()
                raise

    def close(self) -> None:
        """Hangs up, and removes the symbolic link."""
        self.stream.close()
        os.close(self._slave)
        if self._link is not None and os.path.islink(self._link):
            os.unlink(self._link)

    def __enter__(self) -> Pty:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()
