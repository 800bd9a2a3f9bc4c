"""Bytes, samples and ticks in; frames to send and the force for the actuator out: the microcontroller's side.

BOOT -> IDLE -> LINKED -> ARMED -> ACTIVE <-> HOLD -> LOSS_ACTION, any -> FAULT or ESTOP (latched). A firmware calls, as
often as it can: :meth:`DeviceLink.receive`, :meth:`DeviceLink.push`, :meth:`DeviceLink.drive` and, whenever the port
is free, :meth:`DeviceLink.poll_transmit`. Time is a tick count. A software ESTOP is not a safety function.
"""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Callable, Optional, Union

from ..decoder import Block, Counters, Decoder, Role, Verdict
from ..frame import Frame, Header
from ..messages import (
    Ack,
    ClearFault,
    Config,
    ConfigAck,
    DeviceState,
    Event,
    EventKind,
    FaultCode,
    Grip,
    Heartbeat,
    Hello,
    Ident,
    Kind,
    Layout,
    Log,
    LogLevel,
    Nack,
    NackReason,
    PayloadError,
    Ping,
    Pong,
    SampleFormat,
    Stats,
    Status,
    StatusFlags,
)
from ..messages.link import TTL_MAX_MS, TTL_MIN_MS
from ..messages.ident import common_version
from ..sender import Sender
from .batches import Batches
from .events import (
    Cleared,
    Command,
    Configured,
    DeviceEvent,
    Estopped,
    Linked,
    Rejected,
    RowError,
    Started,
    Stopped,
    check_ident,
)
from .force import Drive, DriveKind, ForceGuard, Phase, Taken

_RING = 8
_U32_MAX = 0xFFFFFFFF


class DeviceLink:
    """The microcontroller's end of the link, without IO and clock."""

    def __init__(self, ident: Ident, *, estop_releases: bool = False) -> None:
        """A link in state BOOT: passive, and deaf until :meth:`ready`. An ESTOP holds, or takes the torque off."""
        check_ident(ident)
        self.ident = ident
        self.state = DeviceState.BOOT
        self.in_force: Optional[Config] = None
        self.layout = Layout()
        self.sampling = False
        self.malformed = 0
        self.rejected = 0
        self.old = self.refused = self.unanswered = 0
        self._estop_releases = estop_releases
        self._decoder = Decoder(Role.DEVICE)
        self._sender = Sender(to_host=True)
        self._guard = ForceGuard(ident.tick_hz, ident.limits)
        self._batches = Batches()
        self._replies: deque[Callable[[int], bytes]] = deque(maxlen=_RING)
        self._events: deque[Event] = deque()
        self._events_dropped = 0
        self._estop = False
        self._fault = FaultCode.NONE
        self._cleared = FaultCode.NONE
        self._ran: set[str] = set()
        self._measured_mn: Optional[int] = None
        self._moving: Optional[bool] = None
        self._status_due = self._stats_due = self._announce_due = 0
        self._samples_next = False
        self._dropped_seen = 0

    # --- what the firmware tells

    def ready(self, tick: int) -> None:
        """Self-tests are over: BOOT -> IDLE."""
        if self.state == DeviceState.BOOT:
            self._enter(tick, DeviceState.IDLE)

    def raise_fault(self, tick: int, fault: int) -> None:
        """Latches a fault: minor ones hold, all others take the torque off (R6 to R8)."""
        code = FaultCode(fault)
        if code in (FaultCode.NONE, FaultCode.ESTOP):
            return
        if self._fault == FaultCode.NONE or (self._fault.holds and not code.holds):
            self._fault = code
        self._cleared = FaultCode.NONE
        self._react(code.holds)
        before = self.state
        self._enter(tick, self._latched() or before)
        self._note(tick, EventKind.FAULT, before, code)

    def latch_estop(self, tick: int) -> None:
        """Latches a stop, as ESTOP of the host does."""
        self._estop = True
        self._cleared = FaultCode.NONE
        self._react(not self._estop_releases)
        self._enter(tick, DeviceState.ESTOP)

    def report_travel(self, position_um: int) -> None:
        """Finger position [um]: outside the travel of IDENT the force does not rise."""
        limits = self.ident.limits
        self._guard.at_travel_end = not limits.travel_min_um <= position_um <= limits.travel_max_um

    def report_force(self, force_mn: int) -> None:
        """Measured grip force [mN] for STATUS; without it STATUS tells the force set."""
        self._measured_mn = force_mn

    def report_motion(self, tick: int, moving: bool) -> None:
        """Whether the fingers travel freely or the arm is known to move, for STATUS; until then STATUS says nothing of motion.

        Fingers that press on something do not move, however the force changes: a host hears less well in motion.
        """
        if self._moving is not moving:
            self._status_due = tick
        self._moving = moving

    def push(self, tick: int, row: Sequence[Union[int, float]], sample_format: Optional[SampleFormat] = None) -> None:
        """Appends a row: i16 steps (-32768 = no reading) or, if CONFIG asked for f32, values in their units.

        Raises :class:`RowError` when rows are not wanted like this, or not in this format where one is given.
        """
        self._ran.add("sampling")
        if not self.sampling:
            raise RowError("not sampling", "wait for START")
        if sample_format not in (None, self.format):
            raise RowError("format", f"rows are wanted as {self.format.name}")
        if len(row) != self._batches.elements:
            raise RowError("elements", f"row of {len(row)}, {self._batches.elements} are needed")
        code = "h" if self._batches.format is SampleFormat.I16 else "f"
        try:
            data = struct.pack(f"<{len(row)}{code}", *row)
        except (struct.error, OverflowError) as error:
            raise RowError("value", str(error)) from None
        self._batches.push(tick, data)

    def drive(self, tick: int) -> Drive:
        """What the actuator is to do at this tick."""
        self._ran.add("control")
        return self._step(tick)

    def take_alive(self) -> bool:
        """Whether control, link and (while started) sampling all ran since the last time: feed the watchdog then (R9)."""
        needed = {"control", "link"} | ({"sampling"} if self.sampling else set())
        alive = needed <= self._ran
        if alive:
            self._ran.clear()
        return alive

    # --- what the firmware may look at

    @property
    def fault(self) -> FaultCode:
        """Latched fault; ESTOP comes first."""
        return FaultCode.ESTOP if self._estop else self._fault

    @property
    def session(self) -> int:
        """Session of the host, 0 = none."""
        return self._sender.session

    @property
    def counters(self) -> Counters:
        """What the decoder counted."""
        return self._decoder.counters

    @property
    def format(self) -> SampleFormat:
        """Format in which rows are wanted."""
        return self._batches.format

    @property
    def dropped_rows(self) -> int:
        """Rows dropped since the start because nothing could be sent."""
        return self._batches.dropped_rows

    # --- bytes in

    def receive(self, tick: int, data: bytes) -> list[DeviceEvent]:
        """Takes bytes; what they asked for has been done already."""
        self._ran.add("link")
        self._step(tick)
        events = []
        for block in self._decoder.feed(data):
            event = None if self.state == DeviceState.BOOT else self._on_block(tick, block)
            if event is not None:
                events.append(event)
                self._step(tick)
        return events

    def _on_block(self, tick: int, block: Block) -> Optional[DeviceEvent]:
        if block.frame is None:
            return None
        header = block.frame.header
        if block.verdict is Verdict.UNKNOWN:
            self._refuse(header, NackReason.UNKNOWN_TYPE)
        elif block.verdict is Verdict.STALE and self._sender.session == 0 and tick >= self._announce_due:
            self._announce_due = tick + self._ticks(100)
            self._answer(lambda _now: self._ident_frame(0))
        elif block.verdict is Verdict.OK:
            try:
                return self._on_frame(tick, block.frame)
            except PayloadError:
                self._count_malformed()
                self._refuse(header, NackReason.MALFORMED)
        return None

    def _on_frame(self, tick: int, frame: Frame) -> Optional[DeviceEvent]:
        header, payload = frame.header, frame.payload
        kind = header.kind
        if kind == Kind.GRIP:
            return self._on_grip(tick, Grip.parse(payload))
        if kind == Kind.PING:
            ping = Ping.parse(payload)
            self._answer(lambda now: self._sender.send(Kind.PONG, Pong(ping.t1_us, tick, now).pack()))
            return None
        if kind == Kind.HEARTBEAT:
            return Heartbeat.parse(payload)
        if kind == Kind.HELLO:
            return self._on_hello(tick, header, Hello.parse(payload))
        if kind == Kind.CONFIG:
            return self._on_config(tick, header, Config.parse(payload))
        if kind == Kind.START:
            return self._on_start(header)
        if kind == Kind.STOP:
            self.sampling = False
            self._agree(header)
            return Stopped()
        if kind == Kind.ESTOP:
            self.latch_estop(tick)
            self._agree(header)
            return Estopped()
        return self._on_clear(tick, header, ClearFault.parse(payload).fault)

    def _agree(self, header: Header) -> None:
        if header.ack_req:
            payload = Ack(Kind(header.kind), header.seq).pack()
            self._answer(lambda _now: self._sender.send(Kind.ACK, payload))

    def _refuse(self, header: Header, reason: NackReason) -> None:
        if header.ack_req:
            payload = Nack(Kind(header.kind), reason, header.seq).pack()
            self._answer(lambda _now: self._sender.send(Kind.NACK, payload))

    def _decline(self, header: Header, reason: NackReason) -> None:
        """A good request that cannot be carried out now."""
        self.refused = min(self.refused + 1, _U32_MAX)
        self._refuse(header, reason)

    def _answer(self, frame: Callable[[int], bytes]) -> None:
        if len(self._replies) == _RING:
            self.unanswered = min(self.unanswered + 1, _U32_MAX)
        self._replies.append(frame)

    def _ident_frame(self, session: int) -> bytes:
        ident = replace(self.ident, state=self.state, fault=self.fault)
        return self._sender.send(Kind.IDENT, ident.pack(), session=session)

    def _on_hello(self, tick: int, header: Header, hello: Hello) -> Optional[DeviceEvent]:
        session = header.session
        if session == 0:
            self._count_malformed()
            return None
        self._answer(lambda _now: self._ident_frame(session))
        if common_version(hello.version_min, hello.version_max) is None:
            return None
        self._decoder.open_session(session, header.seq)
        self._sender.session = session
        self._disarm(tick)
        return Linked(session)

    def _disarm(self, tick: int) -> None:
        self._guard.hold(tick)
        self.in_force = None
        self.sampling = False
        self._enter(tick, self._latched() or DeviceState.LINKED)

    def _on_config(self, tick: int, header: Header, asked: Config) -> Optional[DeviceEvent]:
        if self._latched() is not None:
            self._decline(header, NackReason.LATCHED)
            return None
        config = self._clamped(asked)
        if config.channel_mask == 0:
            self._decline(header, NackReason.MALFORMED)
            return None
        self._guard.arm(config)
        self._guard.hold(tick)
        self.layout = Layout(self.ident.channels, config.channel_mask)
        self._batches.configure(config, self.layout.elements, self.ident.tick_hz)
        self.in_force = config
        self.sampling = False
        self._enter(tick, DeviceState.ARMED)
        payload = ConfigAck(header.seq, asked.changed(config), config).pack()
        self._answer(lambda _now: self._sender.send(Kind.CONFIG_ACK, payload))
        return Configured(config)

    def _clamped(self, asked: Config) -> Config:
        limits = self.ident.limits
        slowest = min(-(-self.ident.tick_hz // 0xFFFF), limits.rate_max_hz)
        force_max_mn = min(asked.force_max_mn, limits.force_max_mn)
        return replace(
            asked,
            sample_rate_hz=min(max(asked.sample_rate_hz, slowest), limits.rate_max_hz),
            channel_mask=asked.channel_mask & self.ident.available(asked.format),
            force_max_mn=force_max_mn,
            slew_mn_s=min(asked.slew_mn_s, limits.slew_max_mn_s),
            ttl_ms=min(max(asked.ttl_ms, TTL_MIN_MS), TTL_MAX_MS),
            hold_cap_mn=min(asked.hold_cap_mn, limits.hold_cap_mn, force_max_mn),
            loss_after_ms=min(max(asked.loss_after_ms, 100), 60_000),
        )

    def _on_start(self, header: Header) -> Optional[DeviceEvent]:
        if self.in_force is None:
            self._decline(header, NackReason.WRONG_STATE)
            return None
        self._agree(header)
        began, self.sampling = not self.sampling, True
        return Started() if began else None

    def _on_grip(self, tick: int, grip: Grip) -> Optional[DeviceEvent]:
        self._status_due = tick
        armed = self.state in (DeviceState.ARMED, DeviceState.ACTIVE, DeviceState.HOLD)
        taken = self._guard.command(tick, grip) if armed else Taken.REJECTED
        if taken is Taken.ACCEPTED:
            self._enter(tick, DeviceState.ACTIVE)
            return Command(grip)
        if taken is Taken.OLD:
            self.old = min(self.old + 1, _U32_MAX)
            return None
        self._guard.reject()
        self.rejected = (self.rejected + 1) & 0xFFFF
        self._note(tick, EventKind.COMMAND_REJECTED, self.state, grip.force_mn)
        return Rejected(grip)

    def _on_clear(self, tick: int, header: Header, fault: FaultCode) -> Optional[DeviceEvent]:
        if fault == FaultCode.NONE or self.fault != fault:
            # A repeated request whose first answer was lost: the fault is gone already.
            if fault != FaultCode.NONE and self._cleared == fault:
                self._agree(header)
            else:
                self._decline(header, NackReason.OTHER_FAULT)
            return None
        if self._estop:
            self._estop = False
        else:
            self._fault = FaultCode.NONE
        self._cleared = fault
        self._agree(header)
        before = self.state
        self._disarm(tick)
        self._note(tick, EventKind.FAULT_CLEARED, before, fault)
        return Cleared(fault)

    def _count_malformed(self) -> None:
        self.malformed = min(self.malformed + 1, _U32_MAX)

    # --- time in

    def _ticks(self, ms: int) -> int:
        return self.ident.tick_hz * ms // 1000

    def _latched(self) -> Optional[DeviceState]:
        if self._estop:
            return DeviceState.ESTOP
        return None if self._fault == FaultCode.NONE else DeviceState.FAULT

    def _react(self, holds: bool) -> None:
        if holds:
            self._guard.freeze()
        else:
            self._guard.release()

    def _step(self, tick: int) -> Drive:
        drive = self._guard.advance(tick)
        phase = self._guard.phase
        if phase is Phase.HOLD and self.state == DeviceState.ACTIVE:
            self._enter(tick, DeviceState.HOLD)
        elif phase is Phase.LOST and self.state in (
            DeviceState.ACTIVE, DeviceState.HOLD, DeviceState.ARMED, DeviceState.LINKED,
        ):  # fmt: skip
            self._enter(tick, DeviceState.LOSS_ACTION)
            self._guard.settle()
        return drive

    def _enter(self, tick: int, state: DeviceState) -> None:
        before = self.state
        if before != state:
            self.state = state
            self._status_due = tick
            self._note(tick, EventKind.STATE, before, 0)

    def _note(self, tick: int, kind: EventKind, before: DeviceState, value: int) -> None:
        if len(self._events) == _RING:
            self._events.popleft()
            self._events_dropped = (self._events_dropped + 1) & 0xFFFF
        self._events.append(Event(tick, kind, before, self.state, self.fault, 0, value))

    # --- frames out

    def poll_transmit(self, tick: int) -> Optional[bytes]:
        """The next frame that is due, or None. Call it whenever the port can take a frame."""
        self._step(tick)
        if self._replies:
            return self._replies.popleft()(tick)
        if self._sender.session == 0:
            return None
        if self._events:
            event = replace(self._events.popleft(), dropped=self._events_dropped)
            return self._sender.send(Kind.EVENT, event.pack())
        self._batches.close_old(tick)
        status = tick >= self._status_due
        if self.sampling and len(self._batches) and (self._samples_next or not status):
            self._samples_next = False
            return self._sender.send(Kind.SAMPLES, self._batches.take() or b"")
        if status:
            self._status_due = tick + self._ticks(8)
            self._samples_next = True
            payload = self.status(tick).pack()
            self._dropped_seen = self._batches.dropped_rows
            return self._sender.send(Kind.STATUS, payload)
        if tick >= self._stats_due:
            self._stats_due = tick + self._ticks(1000)
            return self._sender.send(Kind.STATS, self.stats().pack())
        return None

    def log(self, tick: int, level: LogLevel, text: bytes) -> Optional[bytes]:
        """A LOG frame at once; None without a session or for a text over 255 bytes."""
        if self._sender.session == 0 or len(text) > 255:
            return None
        return self._sender.send(Kind.LOG, Log(tick, level, text).pack())

    def status(self, tick: int) -> Status:
        """STATUS as it would be sent now."""
        last, guard = self._guard.last, self._guard
        age_us = _U32_MAX if last is None else max(tick - last[1], 0) * 1_000_000 // self.ident.tick_hz
        flags = (
            (StatusFlags.SAMPLING if self.sampling else 0)
            | (StatusFlags.DROPPING if self._dropped_seen != self._batches.dropped_rows else 0)
            | (StatusFlags.PASSIVE if guard.goal.kind is DriveKind.PASSIVE else 0)
            | (StatusFlags.OPEN if guard.goal.kind is DriveKind.OPEN else 0)
            | (StatusFlags.NO_COMMAND if last is None else 0)
            | (StatusFlags.MOTION if self._moving is not None else 0)
            | (StatusFlags.MOVING if self._moving else 0)
        )
        return Status(
            last[0] if last else 0,
            self.state,
            guard.clamp,
            self.fault,
            guard.applied_mn if self._measured_mn is None else self._measured_mn,
            guard.goal.force_mn,
            min(age_us, _U32_MAX),
            StatusFlags(flags),
            self.rejected,
        )

    def stats(self) -> Stats:
        """STATS as it would be sent now."""
        batches = self._batches
        return Stats(
            **asdict(self.counters),
            sent=self._sender.sent,
            dropped_batches=batches.dropped_batches,
            dropped_rows=batches.dropped_rows,
            malformed=self.malformed,
            old=self.old,
            refused=self.refused,
            unanswered=self.unanswered,
        )
