"""A port in, samples in SI units and force commands out: a small host of the link, of one thread that waits where it has to.

It greets the gripper, configures it and starts the samples once. What ends that (a reset, silence, the port) raises
:class:`LinkClosed`, and the caller opens another link; gripd and the Rust ``HostLink`` go on by themselves.
"""

from __future__ import annotations

import math
import secrets
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Callable, Optional, Union

from .decoder import Counters, Decoder, Role, Verdict
from .frame import Frame
from .messages import (
    MESSAGES,
    Ack,
    ClearFault,
    Config,
    ConfigAck,
    DeviceState,
    Event,
    FaultCode,
    Grip,
    GripMode,
    Hello,
    Ident,
    Kind,
    Layout,
    Log,
    Nack,
    PayloadError,
    Ping,
    Samples,
    Stats,
    Status,
)
from .messages.link import ANSWERS_SLIP
from .messages.ident import common_version, parse_versions
from .sender import Sender
from .stream import ByteStream, Outgoing, StreamClosed, monotonic_us, open_stream

PREAMBLE = bytes(8)
HELLO_S, RETRY_S, GIVE_UP_S = 0.1, 0.05, 1.0
STALE_US, PING_US = 5_000, 500_000
DRIFT = 200e-6  # two crystals of 100 ppm

Report = Union[Status, Stats, Event, Log]


class LinkClosed(ConnectionError):
    """The link closed. ``code`` is no_answer, version_mismatch, no_stylus, unanswered, refused, rebooted, unarmed, lost, port or
    requested; ``reason`` says more."""

    def __init__(self, code: str, detail: str) -> None:
        super().__init__(f"{code}: {detail}")
        self.code, self.reason = code, f"{code}: {detail}"


@dataclass(frozen=True)
class Sample:
    """One row: all channels at one time."""

    index: int
    """Number of the row since the gripper started, wrapping at 2^32."""
    tick: int
    """Time of the row [ticks of the gripper]."""
    host_s: float
    """Time of the row [s of the host's clock], late by what the fastest frame so far took: a faster one sets it back."""
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


@dataclass
class LossCount:
    """Rows since the link opened."""

    received: int = 0
    lost: int = 0
    dropped_by_mcu: int = 0
    """Of the lost ones, those that the gripper dropped; the wire lost the others."""


class GripLink:
    """A gripper at a port. Nothing runs by itself: call :meth:`samples`, :meth:`poll` or :meth:`wait` at least every 20 ms.

    Commands are never repeated: a controller that stops sending GRIP makes the gripper hold (that is the failsafe).
    """

    KEPT_ROWS = 100_000

    def __init__(
        self,
        stream: ByteStream,
        config: Optional[Config] = None,
        *,
        clock_us: Callable[[], int] = monotonic_us,
        session: Optional[int] = None,
        silence_s: float = 1.0,
    ) -> None:
        """A link over a stream; :meth:`connect` makes samples flow.

        ``clock_us`` is a monotonic host time [us]; ``session`` a fresh random number 1..65535, drawn when None; a gripper without
        a frame for ``silence_s`` is lost. Raises PayloadError for a configuration that cannot be.
        """
        self.wanted = config or Config()
        Config.parse(self.wanted.pack())
        self.ident: Optional[Ident] = None
        """The gripper, once it answered."""
        self.config: Optional[Config] = None
        """CONFIG in force, once accepted."""
        self.layout = Layout()
        self.status: Optional[Status] = None
        """The newest STATUS."""
        self.stats: Optional[Stats] = None
        """The newest STATS."""
        self.loss = LossCount()
        self.overflow = 0
        """Rows thrown away because nobody fetched them."""
        self.malformed_frames = 0
        """Good frames whose payload could not be read."""
        self.rows: deque[Sample] = deque()
        """Rows that came, for :meth:`samples` or the caller to take."""
        self.reports: deque[Report] = deque(maxlen=10_000)
        """STATUS, STATS, EVENT and LOG as they came, for the caller to take."""
        self._stream, self._outgoing, self._clock_us, self._silence_s = stream, Outgoing(stream), clock_us, silence_s
        self._decoder, self._sender = Decoder(Role.HOST), Sender(to_host=False)
        self._sender.session = session or secrets.randbelow(0xFFFF) + 1
        self._decoder.open_session(self._sender.session)
        self._closed: Optional[LinkClosed] = None
        self._answer: Any = None
        self._next: Optional[tuple[int, int]] = None
        self._gap = False
        self._ping_us = self._frame_us = self._samples_us = clock_us()
        self._offset_us = math.inf
        self._sent_mn: Optional[int] = None
        self._cmd_id = 0

    @classmethod
    def open(cls, url: str, config: Optional[Config] = None, *, baudrate: int = 115_200, timeout_s: float = 5.0) -> GripLink:
        """Opens a serial device, pseudo-terminal or pyserial URL and waits until samples flow.

        Raises OSError when the port cannot be opened, :class:`LinkClosed` when no gripper answers as it should.
        """
        link = cls(open_stream(url, baudrate), config)
        try:
            link.connect(timeout_s)
        except BaseException:
            link.close()
            raise
        return link

    def __enter__(self) -> GripLink:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    @property
    def counters(self) -> Counters:
        """What the decoder counted."""
        return self._decoder.counters

    @property
    def is_degraded(self) -> bool:
        """Whether samples have a gap, or did not come for 5 ms or three periods: no force is raised then."""
        rate_hz = self.config.sample_rate_hz if self.config else 1
        return self._gap or self._clock_us() - self._samples_us > max(STALE_US, 3_000_000 // rate_hz)

    def connect(self, timeout_s: float = 5.0) -> None:
        """Greets for so long, configures and starts; raises :class:`LinkClosed`."""
        self._write(lambda: PREAMBLE)
        ident = self._ask(Kind.HELLO, Hello(self._clock_us()).pack(), HELLO_S, timeout_s)
        if not ident.shows_slips:
            raise LinkClosed("no_stylus", f"none of the {len(ident.channels)} channels shows a slip")
        self.ident = ident
        self.reconfigure(self.wanted)

    def reconfigure(self, config: Config) -> None:
        """Other limits or another sampling; raises :class:`LinkClosed`, PayloadError for what cannot be."""
        Config.parse(config.pack())
        self.config, self._sent_mn = None, None
        ack = self._ask(Kind.CONFIG, config.pack())
        self.layout = Layout(self.ident.channels if self.ident else (), ack.config.channel_mask)
        self._next, self.config = None, ack.config
        self._ask(Kind.START)

    def clear_fault(self, fault: int) -> None:
        """Clears the latched fault that :attr:`status` or :attr:`ident` tells, and configures again; raises :class:`LinkClosed`."""
        self.config = None
        self._ask(Kind.CLEAR_FAULT, ClearFault(FaultCode(fault)).pack())
        self.reconfigure(self.wanted)

    def wait(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Lets the link run until the condition holds (True) or the time is over; raises :class:`LinkClosed`."""
        end_us = self._clock_us() + round(timeout_s * 1e6)
        while not condition():
            left_us = end_us - self._clock_us()
            if left_us <= 0:
                return False
            self.poll(min(left_us / 1e6, 0.005))
        return True

    def samples(self, duration_s: float = math.inf) -> Iterator[Sample]:
        """Rows in order, for ``duration_s`` of host time; raises :class:`LinkClosed`."""
        start_us = self._clock_us()
        while (self._clock_us() - start_us) / 1e6 < duration_s:
            if self.rows:
                yield self.rows.popleft()
            elif self.config is None:
                raise LinkClosed("unarmed", "no CONFIG is in force, so no rows come")
            else:
                self.poll(0.005)

    def grip(self, force_n: float, *, answers_slip: bool = False, cause_sample: int = 0) -> Optional[Grip]:
        """Sends a force command [N], which lives for ttl: send the next one before.

        Returns the GRIP as sent: clamped to F_max and, while samples are missing, to the force before. None: not sent, because no
        samples flow, or are missing before the first force, or the port takes no more bytes. Raises ValueError for NaN, a negative
        force or one over 2.1 MN, :class:`LinkClosed`.
        """
        if not (force_n >= 0.0 and force_n * 1000.0 <= 0x7FFFFFFF):
            raise ValueError(f"force {force_n} N: expected 0 or more, at most 2.1e6")
        if self._closed is not None:
            raise self._closed
        before_mn = self._sent_mn if self.is_degraded else 0x7FFFFFFF
        if self.config is None or before_mn is None:
            return None
        cmd_id = (self._cmd_id + 1) & 0xFFFFFFFF
        force_mn = min(math.floor(force_n * 1000.0 + 0.5), self.config.force_max_mn, before_mn)
        grip = Grip(cmd_id, GripMode.FORCE, ANSWERS_SLIP if answers_slip else 0, 0, force_mn, 0, cause_sample)
        if not self.send(Kind.GRIP, grip.pack()):
            return None
        self._cmd_id, self._sent_mn = cmd_id, force_mn
        return grip

    def estop(self, timeout_s: float = 0.5) -> bool:
        """Sends ESTOP every 20 ms until the gripper confirms it. Not a safety function."""
        end_us = self._clock_us() + round(timeout_s * 1e6)
        while self._clock_us() < end_us:
            self.send(Kind.ESTOP, ack_req=True, session=0)
            if self.wait(lambda: self.status is not None and self.status.fault == FaultCode.ESTOP, 0.02):
                return True
        return False

    def close(self) -> None:
        """Ends the samples and gives the port back. It never releases the object: the gripper holds when ttl is over."""
        if self._closed is None:
            self._closed = LinkClosed("requested", "closed by the caller")
            with suppress(LinkClosed):
                self.send(Kind.STOP, ack_req=True)
        self._stream.close()

    def send(self, kind: int, payload: bytes = b"", *, ack_req: bool = False, session: Optional[int] = None) -> bool:
        """Any frame, without a look at what it asks for; False where the port takes no more bytes. Raises :class:`LinkClosed`."""
        return self._write(lambda: self._sender.send(kind, payload, ack_req=ack_req, session=session))

    def _write(self, frame: Callable[[], bytes]) -> bool:
        try:
            return self._outgoing.is_free and self._outgoing.send(frame())
        except StreamClosed as error:
            raise self._fail("port", str(error)) from error

    def poll(self, timeout_s: float = 0.0) -> None:
        """Takes what has come, waiting at most so long for it; raises :class:`LinkClosed`."""
        if self._closed is not None:
            raise self._closed
        try:
            data = self._stream.read(timeout_s)
        except StreamClosed as error:
            raise self._fail("port", str(error)) from error
        now_us = self._clock_us()
        for block in self._decoder.feed(data):
            if block.verdict is Verdict.OK and block.frame is not None:
                self._frame_us = now_us
                try:
                    self._take(now_us, block.frame)
                except PayloadError:
                    self.malformed_frames += 1
        if self.ident is not None and now_us - self._frame_us > self._silence_s * 1e6:
            raise self._fail("lost", f"no frame for {now_us - self._frame_us} us")
        if self.ident is not None and now_us >= self._ping_us:
            # A gripper that was reset answers what it does not know.
            self._ping_us = now_us + PING_US
            self.send(Kind.PING, Ping(now_us).pack())

    def _fail(self, code: str, detail: str) -> LinkClosed:
        self._closed = self._closed or LinkClosed(code, detail)
        return self._closed

    def _ask(self, kind: Kind, payload: bytes = b"", every_s: float = RETRY_S, give_up_s: float = GIVE_UP_S) -> Any:
        """The answer to a request, which is repeated until it comes."""
        first, self._answer = self._sender.next_seq, None

        def answered() -> bool:
            answer = self._answer
            if answer is None or isinstance(answer, Ident):
                return answer is not None and kind is Kind.HELLO
            own = (answer.request_seq - first) & 0xFFFF < (self._sender.next_seq - first) & 0xFFFF
            return own and (kind is Kind.CONFIG if isinstance(answer, ConfigAck) else answer.kind == kind)

        end_us = self._clock_us() + round(give_up_s * 1e6)
        while self._clock_us() < end_us:
            self.send(kind, payload, ack_req=True)
            if self.wait(answered, every_s):
                if isinstance(self._answer, Nack):
                    raise LinkClosed("refused", f"{kind.name}: {self._answer.reason.name.lower()}")
                return self._answer
        code = "no_answer" if kind is Kind.HELLO else "unanswered"
        raise LinkClosed(code, f"no answer to {kind.name} within {give_up_s:g} s; {self.counters}")

    def _take(self, now_us: int, frame: Frame) -> None:
        kind, payload = frame.header.kind, frame.payload
        if kind == Kind.SAMPLES:
            if self.config is not None:
                self._take_samples(now_us, Samples.parse(payload, self.layout.elements))
            return
        if kind == Kind.IDENT and common_version(*parse_versions(payload)) is None:
            raise self._fail("version_mismatch", "the gripper speaks protocol {} to {}".format(*parse_versions(payload)))
        message = MESSAGES[kind].parse(payload)
        if isinstance(message, Ident) and frame.header.session == 0:
            if self.ident is not None:
                raise self._fail("rebooted", f"boot {self.ident.boot_id:08x} -> {message.boot_id:08x}")
        elif isinstance(message, Ident) or (isinstance(message, (ConfigAck, Ack, Nack)) and self.ident is not None):
            self._answer = message
        elif isinstance(message, Status) and message.state == DeviceState.LINKED and self.config is not None:
            raise self._fail("unarmed", "the gripper has lost its CONFIG")
        elif isinstance(message, (Status, Stats, Event, Log)):
            self.status = message if isinstance(message, Status) else self.status
            self.stats = message if isinstance(message, Stats) else self.stats
            self.reports.append(message)

    def _take_samples(self, now_us: int, samples: Samples) -> None:
        tick_hz, count = self.ident.tick_hz if self.ident else 1, len(samples)
        expected, dropped = self._next or (samples.first_index, samples.dropped_total)
        missing = (samples.first_index - expected) & 0xFFFFFFFF
        self._gap = missing > 0
        # Numbers that went back say nothing about loss.
        lost = missing if missing < 1 << 31 else 0
        self._next = ((samples.first_index + count) & 0xFFFFFFFF, samples.dropped_total)
        self.loss.received += count
        self.loss.lost += lost
        self.loss.dropped_by_mcu += min((samples.dropped_total - dropped) & 0xFFFFFFFF, lost)
        # The least delay that was ever seen, which crystals that drift apart may have made longer since.
        newest_us = (samples.t0_tick + samples.dt_ticks * (count - 1)) * 1e6 / tick_hz
        self._offset_us = min(self._offset_us + DRIFT * (now_us - self._samples_us), now_us - newest_us)
        self._samples_us = now_us
        for k, row in enumerate(samples.rows):
            tick = samples.t0_tick + samples.dt_ticks * k
            host_s = (tick * 1e6 / tick_hz + self._offset_us) / 1e6
            values = self.layout.scaled(row, samples.format)
            self.rows.append(Sample((samples.first_index + k) & 0xFFFFFFFF, tick, host_s, values, self.layout))
        while len(self.rows) > self.KEPT_ROWS:
            self.rows.popleft()
            self.overflow += 1
