"""Lines of what a host is asked in, all that it does out: the mode ``host`` of :mod:`grip_link.diff`.

One call a line, the host's time in microseconds second: new T (another host) | open T SESSION | close T | rx T HEX |
tx T | grip T MODE FLAGS TTL FORCE SLEW CAUSE | beat T TURNS LONGEST LATE FLAGS | estop T | config T and the fields of
CONFIG | start T | stop T | clear T FAULT. After the answers a line that starts with ``=`` says how the host stands.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Optional, Union

from .decoder import Counters
from .host import (
    Batch,
    ClockUpdated,
    Closed,
    CloseReason,
    Configured,
    Done,
    GripCommand,
    HostConfig,
    HostEvent,
    HostLink,
    Identified,
    LossCount,
    Rebooted,
    Refused,
    StateChanged,
)
from .messages import Config, Event, Grip, GripMode, Heartbeat, Kind, Log, LossAction, NackReason, SampleFormat, Stats, Status

REFERENCE = Config(
    sample_rate_hz=5000, batch=5, format=SampleFormat.I16, ttl_ms=50, channel_mask=3, force_max_mn=10_000,
    slew_mn_s=200_000, hold_cap_mn=8000, loss_after_ms=1000, loss_action=LossAction.HOLD,
)  # fmt: skip
"""What all hosts want in a comparison."""


def _joined(values: Sequence[Union[int, str]]) -> str:
    return " ".join(value if isinstance(value, str) else str(int(value)) for value in values)


def _values(of: Union[Counters, Grip, LossCount, Stats]) -> Sequence[int]:
    """The fields in their order."""
    return list(vars(of).values())


def _config_words(c: Config) -> str:
    return _joined(
        (
            c.sample_rate_hz, c.batch, c.format, c.ttl_ms, c.channel_mask, c.force_max_mn, c.slew_mn_s, c.hold_cap_mn,
            c.loss_after_ms, c.loss_action,
        )
    )  # fmt: skip


def _batch_words(batch: Batch) -> str:
    s, loss = batch.samples, batch.loss
    head = (s.first_index, s.t0_tick, s.dt_ticks, len(s), s.format, s.dropped_total)
    size = s.format.size
    cells = [s.data[at : at + size] for at in range(0, len(s.data), size)]
    if s.format is SampleFormat.I16:
        values = [str(int.from_bytes(cell, "little", signed=True)) for cell in cells]
    else:
        values = [cell[::-1].hex() for cell in cells]
    return f"samples {_joined(head)} {' '.join(values)} lost {loss.rows} {loss.dropped_by_mcu} {loss.restarted:d}"


def _reason_words(reason: CloseReason) -> str:
    numbers = re.findall(r"\d+", reason.detail)
    if reason.code in ("no_answer", "version_mismatch", "lost"):
        return " ".join([reason.code, *numbers[:5]])
    if reason.code == "unanswered":
        return f"unanswered {Kind[reason.detail.split()[-1]]:02x}"
    if reason.code == "refused":
        kind, why = reason.detail.split(": ")
        later = re.fullmatch(r"other_(\d+)", why)
        return f"refused {Kind[kind]:02x} {int(later[1]) if later else NackReason[why.upper()]:d}"
    return reason.code


def event_words(event: HostEvent) -> str:
    """An event in the words of all peers."""
    if isinstance(event, StateChanged):
        return f"state {event.before.value} {event.after.value}"
    if isinstance(event, Identified):
        return f"identified {event.rebooted:d}"
    if isinstance(event, Rebooted):
        return f"rebooted {event.before} {event.now}"
    if isinstance(event, Configured):
        return f"configured {event.clamped:d}"
    if isinstance(event, Batch):
        return _batch_words(event)
    if isinstance(event, Status):
        s = event
        rest = (s.applied_mn, s.target_mn, s.age_us, s.flags, s.rejected)
        return f"status {s.last_cmd_id} {s.state:d} {s.clamp:d} {s.fault:04x} {_joined(rest)}"
    if isinstance(event, Stats):
        return f"stats {_joined(_values(event))}"
    if isinstance(event, Event):
        e = event
        return f"event {e.tick} {e.kind:d} {e.before:d} {e.after:d} {e.fault:04x} {e.dropped} {e.value}"
    return _answer_words(event)


def _answer_words(event: Union[Log, ClockUpdated, Done, Refused, Closed]) -> str:
    if isinstance(event, Log):
        return f"log {event.tick} {event.level:d} {event.text.hex()}"
    if isinstance(event, ClockUpdated):
        return f"clock {event.verdict.value}"
    if isinstance(event, Done):
        return f"done {event.kind:02x}"
    if isinstance(event, Refused):
        return f"refused {event.nack.kind:02x} {event.nack.reason:d} {event.nack.request_seq}"
    return f"closed {_reason_words(event.reason)}"


def state_words(link: HostLink) -> str:
    """How a host stands: state, session, back-off, rows, counters, gripper, CONFIG in force, last GRIP, clock."""
    loss, counters, grip, clock = link.loss, link.counters, link.last_grip, link.clock
    return (
        f"= {link.state.value} {link.session:04x} reopen {link.reopen_after_us} rows {_joined(_values(loss))}"
        f" malformed {link.malformed} unexpected {link.unexpected} counters {_joined(_values(counters))}"
        f" gripper {f'{link.ident.uid.hex()} {link.ident.boot_id}' if link.ident else '-'}"
        f" config {_config_words(link.in_force) if link.in_force else '-'}"
        f" grip {_joined(_values(grip)) if grip else '-'}"
        f" clock {f'{clock.boot_id} {clock.points} {clock.uncertainty_us:.3f}' if clock else '-'}"
    )


class HostPlayer:
    """A host that follows a script."""

    def __init__(self) -> None:
        self._link = HostLink(HostConfig(REFERENCE))

    def obey(self, line: str) -> Iterator[str]:
        """The answers to one line."""
        name, *words = line.split()
        now_us, rest = int(words[0]), words[1:]
        if name == "new":
            self._link = HostLink(HostConfig(REFERENCE))
        elif name == "rx":
            yield from map(event_words, self._link.receive(now_us, bytes.fromhex(rest[0] if rest else "")))
        elif name == "tx":
            wire = self._link.poll_transmit(now_us)
            while wire is not None:
                yield f"frame {wire.hex()}"
                wire = self._link.poll_transmit(now_us)
        elif name in ("grip", "beat", "estop"):
            written = self._written(name, now_us, [int(word) for word in rest])
            yield "none" if written is None else f"frame {written.hex()}"
        else:
            try:
                self._asked(name, now_us, rest)
            except ValueError:
                yield "refused"
        yield state_words(self._link)

    def _written(self, name: str, now_us: int, numbers: Sequence[int]) -> Optional[bytes]:
        if name == "grip":
            mode, flags, ttl_ms, force_mn, slew_mn_s, cause = numbers
            return self._link.grip(now_us, GripCommand(force_mn, GripMode(mode), flags == 1, ttl_ms, slew_mn_s, cause))
        if name == "beat":
            return self._link.heartbeat(Heartbeat(*numbers))
        return self._link.estop()

    def _asked(self, name: str, now_us: int, words: Sequence[str]) -> None:
        if name == "open":
            self._link.open(now_us, int(words[0], 16))
        elif name == "close":
            self._link.close()
        elif name == "config":
            self._link.reconfigure(now_us, _config(words))
        elif name == "start":
            self._link.start(now_us)
        elif name == "stop":
            self._link.stop(now_us)
        elif name == "clear":
            self._link.clear_fault(now_us, int(words[0], 16))
        else:
            raise RuntimeError(f"no such command: {name}")


def _config(words: Sequence[str]) -> Config:
    rate, batch, fmt, ttl, mask, force_max, slew, hold_cap, after, action = map(int, words)
    return Config(
        sample_rate_hz=rate, batch=batch, format=SampleFormat(fmt), ttl_ms=ttl, channel_mask=mask, force_max_mn=force_max,
        slew_mn_s=slew, hold_cap_mn=hold_cap, loss_after_ms=after, loss_action=LossAction(action),
    )  # fmt: skip
