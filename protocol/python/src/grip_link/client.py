"""A port in, samples in SI units and force commands out: what a program on the computer uses."""

from __future__ import annotations

import math
import secrets
import threading
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from types import TracebackType
from typing import Callable, Optional

from .clock import ClockSync
from .decoder import Counters
from .host import (
    Batch,
    Closed,
    CloseReason,
    GripCommand,
    HostConfig,
    HostEvent,
    HostLink,
    HostState,
    LossCount,
    Rebooted,
)
from .messages import Config, FaultCode, Grip, Heartbeat, Ident, Kind, Layout, Samples, Stats, Status
from .stream import ByteStream, Outgoing, StreamClosed, monotonic_us, open_stream


class LinkClosed(ConnectionError):
    """The link closed; ``reason`` says why."""

    def __init__(self, reason: CloseReason) -> None:
        super().__init__(str(reason))
        self.reason = reason


@dataclass(frozen=True)
class Sample:
    """One row: all channels at one time."""

    index: int
    """Number of the row since the gripper started, wrapping at 2^32."""
    tick: int
    """Time of the row [ticks of the gripper]."""
    host_s: float
    """Time of the row [s of the host's clock]; NaN before the first PONG. Known to clock.uncertainty_us."""
    values: tuple[float, ...]
    """All elements in SI units, NaN where a channel had no reading."""
    layout: Layout

    def __getitem__(self, kind: int) -> float:
        """First element of the first channel of a kind; raises KeyError when the row has none."""
        return self.array(kind)[0]

    def array(self, kind: int) -> tuple[float, ...]:
        """All elements of the first channel of a kind; raises KeyError when the row has none."""
        column = self.layout.column(kind)
        if column is None:
            raise KeyError(kind)
        return self.values[column.first : column.first + column.count]


class GripLink:
    """A gripper at a port.

    One thread is enough: :meth:`samples`, :meth:`poll` and :meth:`wait` do the reading and writing; call one of them
    at least every 20 ms. With ``background=True`` a thread does it, and these only wait. Commands are never repeated
    by themselves: a controller that stops sending GRIP makes the gripper hold (that is the failsafe).
    """

    KEPT_ROWS = 100_000
    KEPT_EVENTS = 10_000

    def __init__(
        self,
        stream: ByteStream,
        config: Optional[Config] = None,
        *,
        clock_us: Callable[[], int] = monotonic_us,
        session: Optional[int] = None,
        background: bool = False,
    ) -> None:
        """A link that starts to say HELLO at the next :meth:`poll`; :meth:`connect` waits until samples flow.

        ``clock_us`` is a monotonic host time [us]; ``session`` a fresh random number 1..65535, drawn when None.
        """
        self.link = HostLink(HostConfig(config or Config()))
        self.status: Optional[Status] = None
        """The newest STATUS."""
        self.stats: Optional[Stats] = None
        """The newest STATS."""
        self.overflow = 0
        """Rows thrown away because nobody fetched them."""
        self._stream = stream
        self._outgoing = Outgoing(stream)
        self._clock_us = clock_us
        self._rows: deque[Sample] = deque()
        self._events: deque[HostEvent] = deque(maxlen=self.KEPT_EVENTS)
        self._reason: Optional[CloseReason] = None
        self._stopped = False
        self._changed = threading.Condition(threading.RLock())
        self._thread: Optional[threading.Thread] = None
        self.link.open(clock_us(), session or secrets.randbelow(0xFFFF) + 1)
        if background:
            self._thread = threading.Thread(target=self._run, name="grip-link", daemon=True)
            self._thread.start()

    @classmethod
    def open(
        cls,
        url: str,
        config: Optional[Config] = None,
        *,
        baudrate: int = 115_200,
        timeout_s: float = 5.0,
        background: bool = False,
    ) -> GripLink:
        """Opens a serial device, pseudo-terminal or pyserial URL and waits until samples flow.

        Raises OSError when the port cannot be opened, :class:`LinkClosed` when no gripper answers as it should.
        """
        link = cls(open_stream(url, baudrate), config, background=background)
        try:
            link.connect(timeout_s)
        except BaseException:
            link.close()
            raise
        return link

    def __enter__(self) -> GripLink:
        return self

    def __exit__(
        self, kind: Optional[type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    # --- what goes on

    @property
    def state(self) -> HostState:
        """State of the link."""
        return self.link.state

    @property
    def ident(self) -> Optional[Ident]:
        """The gripper, once it answered."""
        return self.link.ident

    @property
    def config(self) -> Optional[Config]:
        """CONFIG in force, once accepted."""
        return self.link.in_force

    @property
    def clock(self) -> Optional[ClockSync]:
        """Relation of the gripper's clock to the host's, once it answered."""
        return self.link.clock

    @property
    def loss(self) -> LossCount:
        """Rows received and lost since the link opened."""
        return self.link.loss

    @property
    def counters(self) -> Counters:
        """What the decoder counted."""
        return self.link.counters

    @property
    def malformed_frames(self) -> int:
        """Good frames whose payload could not be read."""
        return self.link.malformed

    def events(self) -> list[HostEvent]:
        """Everything but samples that happened since the last call, oldest first."""
        with self._changed:
            events = list(self._events)
            self._events.clear()
        return events

    # --- waiting

    def connect(self, timeout_s: float = 5.0) -> None:
        """Waits until samples flow; raises :class:`LinkClosed`, also when the time is over."""
        if not self.wait(lambda: self.state is HostState.STREAM, timeout_s):
            raise LinkClosed(CloseReason("no_answer", f"still {self.state.value} after {timeout_s} s"))

    def wait(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Lets the link run until the condition holds (True) or the time is over; raises :class:`LinkClosed`."""
        end_us = self._clock_us() + round(timeout_s * 1e6)
        while not condition():
            if self._reason is not None:
                raise LinkClosed(self._reason)
            left_us = end_us - self._clock_us()
            if left_us <= 0:
                return False
            self.poll(min(left_us / 1e6, 0.005))
        return True

    def poll(self, timeout_s: float = 0.0) -> None:
        """Writes what is due and takes what has come, waiting at most so long for it."""
        if self._thread is None:
            self._pump(timeout_s)
        else:
            with self._changed:
                self._changed.wait(timeout_s)

    def samples(self, duration_s: float = math.inf) -> Iterator[Sample]:
        """Rows in order, for ``duration_s`` of host time or until :meth:`stop`; raises :class:`LinkClosed`."""
        start_us = self._clock_us()
        while not self._stopped and (self._clock_us() - start_us) / 1e6 < duration_s:
            with self._changed:
                sample = self._rows.popleft() if self._rows else None
            if sample is not None:
                yield sample
            elif self._reason is not None:
                raise LinkClosed(self._reason)
            else:
                self.poll(0.005)

    # --- what the caller asks for

    def grip(self, force_n: float, *, answers_slip: bool = False, cause_sample: int = 0) -> Optional[Grip]:
        """Sends a force command [N], which lives for ttl: send the next one before.

        Returns the GRIP as sent: clamped to F_max and, while samples are missing, to the force before. None: not sent,
        because no samples flow now or the port takes no more bytes. Raises ValueError for NaN or a negative force, :class:`LinkClosed`.
        """
        return self.command(GripCommand.newtons(force_n, answers_slip=answers_slip, cause_sample=cause_sample))

    def command(self, command: GripCommand) -> Optional[Grip]:
        """As :meth:`grip`, with all that a command can say."""
        with self._changed:
            if self._reason is not None:
                raise LinkClosed(self._reason)
            if not self._free():
                return None
            wire = self.link.grip(self._clock_us(), command)
            if wire is None or not self._write(wire):
                return None
            return self.link.last_grip

    def heartbeat(self, heartbeat: Heartbeat) -> None:
        """Tells the gripper how the control loop is doing; it does not refresh a GRIP."""
        with self._changed:
            wire = self.link.heartbeat(heartbeat) if self._free() else None
            if wire is not None:
                self._write(wire)

    def estop(self, timeout_s: float = 0.5) -> bool:
        """Sends ESTOP every 20 ms until the gripper confirms it. Not a safety function."""
        end_us = self._clock_us() + round(timeout_s * 1e6)
        while self._clock_us() < end_us:
            with self._changed:
                if self._free():
                    self._write(self.link.estop())
            if self.wait(lambda: self.status is not None and self.status.fault == FaultCode.ESTOP, 0.02):
                return True
        return False

    def reconfigure(self, config: Config) -> None:
        """Asks for other limits or another sampling; :meth:`connect` waits for it."""
        with self._changed:
            self.link.reconfigure(self._clock_us(), config)

    def clear_fault(self, fault: int) -> None:
        """Asks to clear the latched fault that :attr:`status` tells; CONFIG follows by itself."""
        with self._changed:
            self.link.clear_fault(self._clock_us(), fault)

    def start(self) -> None:
        """Asks for samples again after :meth:`stop`."""
        with self._changed:
            self._stopped = False
            self.link.start(self._clock_us())

    def stop(self) -> None:
        """Asks for no more samples; :meth:`samples` ends. The gripper's force rules go on."""
        with self._changed:
            self._stopped = True
            self.link.stop(self._clock_us())

    def close(self) -> None:
        """Ends the samples and gives the port back. It never releases the object: the gripper holds when ttl is over."""
        with self._changed:
            if self._reason is None:
                self.link.stop(self._clock_us())
                self._transmit()
                self.link.close()
                self._take(self.link.receive(self._clock_us()))
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(1.0)
        self._stream.close()

    # --- reading and writing

    def _run(self) -> None:
        while self._reason is None:
            self._pump(0.005)

    def _pump(self, timeout_s: float) -> None:
        with self._changed:
            if self._reason is not None:
                return
            self._transmit()
        try:
            data = self._stream.read(timeout_s)
        except StreamClosed as error:
            self._lose(error)
            return
        with self._changed:
            now_us = self._clock_us()
            self._take(self.link.receive(now_us, data))
            self._changed.notify_all()

    def _transmit(self) -> None:
        while self._free():
            wire = self.link.poll_transmit(self._clock_us())
            if wire is None or not self._write(wire):
                return

    def _free(self) -> bool:
        try:
            return self._reason is None and self._outgoing.is_free
        except StreamClosed as error:
            self._lose(error)
            return False

    def _write(self, wire: bytes) -> bool:
        try:
            return self._outgoing.send(wire)
        except StreamClosed as error:
            self._lose(error)
            return False

    def _lose(self, error: StreamClosed) -> None:
        with self._changed:
            if self._reason is None:
                self._reason = CloseReason("port", str(error))
                self._events.append(Closed(self._reason))
                self.link.close()
            self._changed.notify_all()

    def _take(self, events: list[HostEvent]) -> None:
        for event in events:
            if isinstance(event, Batch):
                self._take_rows(event.samples)
                continue
            self._events.append(event)
            if isinstance(event, Status):
                self.status = event
            elif isinstance(event, Stats):
                self.stats = event
            elif isinstance(event, Rebooted):
                self.status = None
            elif isinstance(event, Closed):
                self._reason = event.reason

    def _take_rows(self, samples: Samples) -> None:
        layout, clock, ident = self.link.layout, self.link.clock, self.link.ident
        tick_s = 1.0 / ident.tick_hz if ident else math.nan
        first_us = clock.host_us(samples.t0_tick) if clock else None
        first_s = math.nan if first_us is None else first_us / 1e6
        for k, row in enumerate(samples.rows):
            since = samples.dt_ticks * k
            values = layout.scaled(row, samples.format)
            index = (samples.first_index + k) & 0xFFFFFFFF
            self._rows.append(Sample(index, samples.t0_tick + since, first_s + since * tick_s, values, layout))
        while len(self._rows) > self.KEPT_ROWS:
            self._rows.popleft()
            self.overflow += 1
