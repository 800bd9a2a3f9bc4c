"""Bytes and time in; gripper events and frames to send out: the computer's side, without IO and clock.

CLOSED -> OPEN -> HELLO -> CONFIG -> STREAM <-> DEGRADED -> CLOSED. A driver calls :meth:`HostLink.receive` with what
the port gave (also with nothing, when only time went on), then :meth:`HostLink.poll_transmit` until None, and writes
each frame with one write. Time is a monotonic host time in microseconds.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Optional

from ..clock import ClockSync, PongVerdict
from ..decoder import Counters, Decoder, Role, Verdict
from ..frame import Frame
from ..messages import (
    Ack,
    ClearFault,
    Config,
    ConfigAck,
    DeviceState,
    Event,
    FaultCode,
    Grip,
    GripMode,
    Heartbeat,
    Hello,
    Ident,
    Kind,
    Layout,
    Log,
    Nack,
    NackReason,
    PayloadError,
    Ping,
    Pong,
    Samples,
    Stats,
    Status,
)
from ..messages.grip import ANSWERS_SLIP
from ..messages.ident import common_version, parse_versions
from ..sender import Sender
from .events import (
    Batch,
    ClockUpdated,
    Closed,
    CloseReason,
    Configured,
    Done,
    GripCommand,
    HostConfig,
    HostEvent,
    HostState,
    Identified,
    Rebooted,
    Refused,
    StateChanged,
)
from .loss import LossCount, RowCount
from .request import Request

PREAMBLE = bytes(8)
HELLO_EVERY_US = 100_000
QUICK_PINGS = 8
QUICK_PING_US = 50_000
PING_US = 1_000_000

_LINKED = (HostState.CONFIG, HostState.STREAM, HostState.DEGRADED)
_STREAMING = (HostState.STREAM, HostState.DEGRADED)


def _is_text(data: bytes) -> bool:
    """Whether they are printable lines."""
    return len(data) > 3 and all(byte in b"\r\n\t" or 32 <= byte < 127 for byte in data)


class HostLink:
    """The computer's end of the link."""

    def __init__(self, config: Optional[HostConfig] = None) -> None:
        """A closed link; raises ValueError for a configuration that cannot be."""
        self.config = config or HostConfig()
        self.config.check()
        self.state = HostState.CLOSED
        self.session = 0
        self.ident: Optional[Ident] = None
        self.in_force: Optional[Config] = None
        self.layout = Layout()
        self.clock: Optional[ClockSync] = None
        self.last_grip: Optional[Grip] = None
        """The GRIP sent last, as clamped."""
        self.malformed = 0
        """Good frames with a malformed payload."""
        self.unexpected = 0
        """Good frames that nothing waited for: answers to no request, IDENT after the first, SAMPLES outside of STREAM
        and DEGRADED."""
        self._decoder = Decoder(Role.HOST)
        self._sender = Sender(to_host=False)
        self._announced = HostState.CLOSED
        self._events: list[HostEvent] = []
        self._request: Optional[Request] = None
        self._rows = RowCount()
        self._greet_again = False
        self._hello_since_us = self._hello_due_us = self._hellos = 0
        self._bytes, self._last = 0, b""
        self._at_open = Counters()
        self._pings = self._ping_due_us = 0
        self._samples_us = self._frame_us = 0
        self._force_sent_mn: Optional[int] = None
        self._cmd_id = 0
        self._failures = 0

    # --- what the caller asks for

    def open(self, now_us: int, session: int) -> None:
        """The port is open: 00 x 8 and HELLO go out next. ``session`` is a fresh random number, 1..65535."""
        if not 1 <= session <= 0xFFFF:
            raise ValueError(f"session {session}: expected 1..65535")
        self._decoder.restart()
        self._at_open = replace(self._decoder.counters)
        self._bytes, self._last = 0, b""
        self._rows = RowCount()
        self._events.clear()
        self.state = HostState.OPEN
        self._greet(now_us, session)

    def close(self) -> None:
        """The port is gone or no longer wanted."""
        if self.state is not HostState.CLOSED:
            self._close(CloseReason("requested", "closed by the caller"))

    def grip(self, now_us: int, command: GripCommand) -> Optional[bytes]:
        """A GRIP frame; None unless samples flow (STREAM or DEGRADED), and for a negative force.

        Force is clamped to F_max and, while DEGRADED, to the force sent before in this session; before the first one
        DEGRADED gives None, because the gripper may hold what a force of 0 drops. See :attr:`last_grip`.
        """
        self._tick(now_us)
        config = self.in_force
        if config is None or self.state not in _STREAMING or command.force_mn < 0:
            return None
        most_mn = config.force_max_mn
        if self.state is HostState.DEGRADED and command.mode is GripMode.FORCE:
            if self._force_sent_mn is None:
                return None
            most_mn = min(most_mn, self._force_sent_mn)
        grip = Grip(
            (self._cmd_id + 1) & 0xFFFFFFFF,
            command.mode,
            ANSWERS_SLIP if command.answers_slip else 0,
            command.ttl_ms,
            min(command.force_mn, most_mn),
            command.slew_mn_s,
            command.cause_sample,
        )
        wire = self._sender.send(Kind.GRIP, grip.pack())
        self._cmd_id = grip.cmd_id
        self._force_sent_mn = grip.force_mn if command.mode is GripMode.FORCE else 0
        self.last_grip = grip
        return wire

    def heartbeat(self, heartbeat: Heartbeat) -> Optional[bytes]:
        """A HEARTBEAT frame; None without a session."""
        return self._sender.send(Kind.HEARTBEAT, heartbeat.pack()) if self.state in _LINKED else None

    def estop(self) -> bytes:
        """An ESTOP frame, with session 0 so that it is taken in any session. Repeat it until Done or STATUS says so."""
        return self._sender.send(Kind.ESTOP, ack_req=True, session=0)

    def reconfigure(self, now_us: int, config: Config) -> None:
        """Asks for other limits or another sampling: CONFIG and START go out next. Ignored when closed."""
        wanted = replace(self.config, config=config)
        wanted.check()
        self.config = wanted
        if self.state in _LINKED:
            self._configure(now_us)

    def start(self, now_us: int) -> None:
        """Asks for samples again after :meth:`stop`."""
        if self.in_force is not None:
            self._request = Request(Kind.START, b"", now_us)

    def stop(self, now_us: int) -> None:
        """Asks for no more samples; the state goes back to CONFIG."""
        if self.in_force is not None:
            self._request = Request(Kind.STOP, b"", now_us)

    def clear_fault(self, now_us: int, fault: int) -> None:
        """Asks to clear the fault that STATUS or IDENT told; CONFIG follows by itself when it is cleared."""
        if self.state in _LINKED:
            self._request = Request(Kind.CLEAR_FAULT, ClearFault(FaultCode(fault)).pack(), now_us)

    # --- what the caller may look at

    @property
    def counters(self) -> Counters:
        """What the decoder counted since the link was made."""
        return self._decoder.counters

    @property
    def loss(self) -> LossCount:
        """Rows received and lost since the link opened."""
        return self._rows.count

    @property
    def reopen_after_us(self) -> int:
        """How long to wait before opening again [us]: 0, then 50 ms doubling to 2 s with each failure in a row."""
        return min(25_000 << min(self._failures, 7), 2_000_000) if self._failures else 0

    # --- bytes in

    def receive(self, now_us: int, data: bytes = b"") -> list[HostEvent]:
        """Takes bytes and the time; what came of them."""
        self._bytes += len(data)
        if self.state is HostState.HELLO:
            self._last = (self._last + data)[-64:]
        self._announce()
        for block in self._decoder.feed(data):
            if block.verdict is Verdict.OK and block.frame is not None and self.state is not HostState.CLOSED:
                self._frame_us = now_us
                try:
                    self._on_frame(now_us, block.frame)
                except PayloadError:
                    self.malformed += 1
                self._announce()
        self._tick(now_us)
        self._announce()
        events, self._events = self._events, []
        return events

    def _announce(self) -> None:
        if self._announced is not self.state:
            self._events.append(StateChanged(self._announced, self.state))
            self._announced = self.state

    def _on_frame(self, now_us: int, frame: Frame) -> None:
        kind, payload = frame.header.kind, frame.payload
        if kind == Kind.IDENT:
            if frame.header.session == 0:
                self._on_announcement(now_us, payload)
            else:
                self._on_ident(now_us, payload)
        elif kind == Kind.CONFIG_ACK:
            self._on_config_ack(now_us, ConfigAck.parse(payload))
        elif kind == Kind.ACK:
            self._on_ack(now_us, Ack.parse(payload))
        elif kind == Kind.NACK:
            self._on_nack(Nack.parse(payload))
        elif kind == Kind.PONG:
            pong = Pong.parse(payload)
            if self.clock is not None:
                verdict = self.clock.push(pong, now_us)
                if verdict is PongVerdict.OUTLIER:
                    self._pings, self._ping_due_us = 0, min(self._ping_due_us, now_us + QUICK_PING_US)
                self._events.append(ClockUpdated(verdict))
        elif kind == Kind.SAMPLES:
            self._on_samples(now_us, payload)
        elif kind == Kind.STATUS:
            self._on_status(now_us, Status.parse(payload))
        elif kind in _REPORTS:
            self._events.append(_REPORTS[kind].parse(payload))

    def _on_announcement(self, now_us: int, payload: bytes) -> None:
        now = Ident.parse(payload).boot_id
        if self.state in _LINKED:
            self._events.append(Rebooted(self.ident.boot_id if self.ident else 0, now))
            self.state = HostState.HELLO
            self._greet(now_us, max((self.session + 1) & 0xFFFF, 1))

    def _on_ident(self, now_us: int, payload: bytes) -> None:
        if self.state is not HostState.HELLO:
            self.unexpected += 1
            return
        low, high = parse_versions(payload)
        if common_version(low, high) is None:
            self._close(CloseReason("version_mismatch", f"the gripper speaks protocol {low} to {high}"))
            return
        try:
            ident = Ident.parse(payload)
        except PayloadError as error:
            self._close(CloseReason("bad_ident", str(error)))
            return
        if not ident.shows_slips:
            self._close(CloseReason("no_stylus", f"none of the {len(ident.channels)} channels shows a slip"))
            return
        old = self.ident
        rebooted = old is not None and (old.uid, old.boot_id) != (ident.uid, ident.boot_id)
        if rebooted or self.clock is None:
            self.clock = ClockSync(ident.tick_hz, ident.boot_id)
        self.ident = ident
        self._pings, self._ping_due_us = 0, now_us
        self._events.append(Identified(ident, rebooted))
        self._configure(now_us)

    def _on_config_ack(self, now_us: int, ack: ConfigAck) -> None:
        if self._answered(Kind.CONFIG, ack.request_seq) and self.ident is not None:
            self.in_force = ack.config
            self.layout = Layout(self.ident.channels, ack.config.channel_mask)
            self._rows.restart()
            self._events.append(Configured(ack.config, ack.clamped))
            self._request = Request(Kind.START, b"", now_us)

    def _on_ack(self, now_us: int, ack: Ack) -> None:
        if ack.kind != Kind.ESTOP and not self._answered(ack.kind, ack.request_seq):
            return
        self._events.append(Done(ack.kind))
        if ack.kind == Kind.START:
            self._stream(now_us)
        elif ack.kind == Kind.STOP:
            self.state = HostState.CONFIG
        elif ack.kind == Kind.CLEAR_FAULT:
            self._configure(now_us)

    def _on_nack(self, nack: Nack) -> None:
        if not self._answered(nack.kind, nack.request_seq):
            return
        if nack.kind in (Kind.CONFIG, Kind.START) and nack.reason != NackReason.LATCHED:
            self._close(CloseReason("refused", f"{nack.kind.name}: {nack.reason.name.lower()}"))
        else:
            self._events.append(Refused(nack))

    def _on_samples(self, now_us: int, payload: bytes) -> None:
        # CONFIG stopped the sampling before: samples now mean that START arrived and its ACK did not.
        began = self._request is not None and self._request.kind == Kind.START and self._request.tries > 0
        if began:
            self._request = None
            self._stream(now_us)
        try:
            self._take_samples(now_us, payload)
        finally:
            if began:
                self._events.append(Done(Kind.START))

    def _take_samples(self, now_us: int, payload: bytes) -> None:
        if self.state not in _STREAMING:
            self.unexpected += 1
            return
        samples = Samples.parse(payload, self.layout.elements)
        loss = self._rows.take(samples)
        self._samples_us = now_us
        self.state = HostState.STREAM if loss.is_contiguous else HostState.DEGRADED
        self._events.append(Batch(samples, loss))

    def _on_status(self, now_us: int, status: Status) -> None:
        # A gripper that streamed and says LINKED has lost its CONFIG, as a repeated HELLO of this session makes it.
        if self.state in _STREAMING and self._request is None and status.state == DeviceState.LINKED:
            self._configure(now_us)
        self._events.append(status)

    def _answered(self, kind: int, seq: int) -> bool:
        answered = self._request is not None and self._request.answered_by(kind, seq)
        if answered:
            self._request = None
        else:
            self.unexpected += 1
        return answered

    def _stream(self, now_us: int) -> None:
        self.state = HostState.STREAM
        self._samples_us = now_us
        self._failures = 0
        self._rows.restart()

    def _configure(self, now_us: int) -> None:
        self.state = HostState.CONFIG
        self.in_force = None
        self._request = Request(Kind.CONFIG, self.config.config.pack(), now_us)

    def _greet(self, now_us: int, session: int) -> None:
        self.session = self._sender.session = session
        self._decoder.open_session(session)
        self._hello_since_us = self._hello_due_us = self._frame_us = now_us
        self._hellos = 0
        self.in_force = self._request = None
        self._force_sent_mn = None

    def _close(self, reason: CloseReason) -> None:
        self.state = HostState.CLOSED
        self._request = self.in_force = None
        self._failures += reason.code != "requested"
        self._decoder.close_session()
        self._events.append(Closed(reason))

    # --- time in

    def _tick(self, now_us: int) -> None:
        silent_us = now_us - self._frame_us
        if self.state is HostState.HELLO:
            if now_us - self._hello_since_us >= self.config.hello_for_us:
                self._close(self._no_answer())
        elif self.state in _LINKED:
            if self._request is not None and self._request.is_given_up(now_us):
                self._close(CloseReason("unanswered", f"no answer to three {self._request.kind.name}"))
            elif silent_us > self.config.lost_us:
                self._close(CloseReason("lost", f"no frame for {silent_us} us"))
            elif self.state is HostState.STREAM and now_us - self._samples_us > self._stale_us():
                self.state = HostState.DEGRADED

    def _stale_us(self) -> int:
        rate_hz = self.in_force.sample_rate_hz if self.in_force else 0
        return max(self.config.stale_us, 3_000_000 // rate_hz if rate_hz else 0)

    def _no_answer(self) -> CloseReason:
        now, before = self.counters, self._at_open
        others = sum(getattr(now, name) - getattr(before, name) for name in ("stale", "version", "unknown"))
        return CloseReason(
            "no_answer",
            f"{self._hellos} HELLOs written; {self._bytes} bytes came, {now.garbage_bytes - before.garbage_bytes} of"
            f" them in broken frames, {now.echo - before.echo} echoes, {others} third-party frames"
            + (f"; none is an answer, the last are {self._last!r}" if self._last else "")
            + ("; a device that sends text is read as rows: docs/rows.md" if _is_text(self._last) else ""),
        )

    def poll_transmit(self, now_us: int) -> Optional[bytes]:
        """The next bytes that are due, to be written with one write: the preamble, HELLO, a request or a PING."""
        self._tick(now_us)
        if self.state is HostState.OPEN:
            self.state = HostState.HELLO
            return PREAMBLE
        if self.state is HostState.HELLO and now_us >= self._hello_due_us:
            self._hello_due_us = now_us + HELLO_EVERY_US
            self._hellos += 1
            return self._sender.send(Kind.HELLO, Hello(now_us).pack(), ack_req=True)
        if self.state in _LINKED:
            return self._send_request(now_us) or self._send_ping(now_us)
        return None

    def _send_request(self, now_us: int) -> Optional[bytes]:
        request = self._request
        if request is None or not request.is_due(now_us):
            return None
        request.sent(self._sender.next_seq, now_us)
        return self._sender.send(request.kind, request.payload, ack_req=True)

    def _send_ping(self, now_us: int) -> Optional[bytes]:
        if now_us < self._ping_due_us:
            return None
        self._pings += 1
        self._ping_due_us = now_us + (QUICK_PING_US if self._pings < QUICK_PINGS else PING_US)
        return self._sender.send(Kind.PING, Ping(now_us).pack())


_REPORTS: dict[int, type[Stats] | type[Event] | type[Log]] = {
    Kind.STATS: Stats,
    Kind.EVENT: Event,
    Kind.LOG: Log,
}
