"""The failsafe rules of the device that the comparison with the Rust one (`grip_link.diff`) leaves out."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from typing import Optional

import pytest
from grip_link import frame
from grip_link.device import DeviceEvent, DeviceLink, Drive, DriveKind, Rejected, RowError
from grip_link.frame import Header
from grip_link.diff import reference_ident
from grip_link.messages import (
    Clamped,
    ClearFault,
    Config,
    DeviceState,
    FaultCode,
    ForceClamp,
    Grip,
    Hello,
    Kind,
    LossAction,
    Status,
)

WANTED = Config(sample_rate_hz=1000, batch=1, channel_mask=3, force_max_mn=10_000, slew_mn_s=200_000, hold_cap_mn=8_000)


class Rig:
    """A device and a host driven by hand; a tick is a microsecond."""

    def __init__(self, config: Config = WANTED) -> None:
        self.device = DeviceLink(reference_ident())
        self.device.ready(0)
        self.tick = 1000
        self.seq = 0
        self.cmd_id = 0
        self.send(Kind.HELLO, Hello(0).pack())
        self.send(Kind.CONFIG, config.pack())
        assert self.device.state == DeviceState.ARMED

    def send(self, kind: Kind, payload: bytes = b"", session: int = 5) -> list[DeviceEvent]:
        wire = frame.encode(Header(kind, self.seq, session, to_host=False), payload)
        self.seq = (self.seq + 1) & 0xFFFF
        return self.device.receive(self.tick, wire)

    def grip(self, force_mn: int, *, ttl_ms: int = 0, slew: int = 0, mode: int = 1, cmd_id: Optional[int] = None) -> list[DeviceEvent]:
        self.cmd_id = self.cmd_id + 1 if cmd_id is None else cmd_id
        return self.send(Kind.GRIP, Grip(self.cmd_id, mode, 0, ttl_ms, force_mn, slew, 0).pack())

    def run(self, ms: int, force_mn: Optional[int] = None) -> Drive:
        for _ in range(ms):
            self.tick += 1000
            if force_mn is not None:
                self.grip(force_mn)
            self.device.drive(self.tick)
        return self.device.drive(self.tick)

    @property
    def status(self) -> Status:
        return self.device.status(self.tick)


@pytest.mark.parametrize("action", list(LossAction))
def test_r2_r3_hold_at_the_cap_then_the_loss_action(action: LossAction) -> None:
    rig = Rig(Config(channel_mask=1, hold_cap_mn=4000, loss_after_ms=300, loss_action=action))
    assert rig.run(200, 9000).force_mn == 9000
    assert rig.run(200).force_mn == 4000 and rig.status.clamp & ForceClamp.HOLD_CAP
    assert rig.device.state == DeviceState.HOLD
    drive = rig.run(200)
    assert rig.device.state == DeviceState.LOSS_ACTION
    kinds = {LossAction.HOLD: DriveKind.FORCE, LossAction.OPEN: DriveKind.OPEN, LossAction.PASSIVE: DriveKind.PASSIVE}
    assert drive.kind is kinds[action] and drive.force_mn == (4000 if action is LossAction.HOLD else 0)
    assert isinstance(rig.grip(5000)[0], Rejected)


def test_r4_every_command_keeps_the_limits() -> None:
    rng = random.Random(6)
    edges = [0, 1, -1, 9999, 10_000, 10_001, 2**31 - 1, -(2**31)]
    rig = Rig()
    last = 0
    for _ in range(5000):
        force = rng.choice(edges) if rng.random() < 0.5 else rng.randrange(-(2**31), 2**31)
        rig.grip(
            force, ttl_ms=rng.randrange(1 << 16), slew=rng.choice([0, 1, 200_000, 2**32 - 1]), mode=rng.randrange(5),
            cmd_id=rng.choice([rig.cmd_id + 1, rig.cmd_id, rng.randrange(2**32)]) & 0xFFFFFFFF,
        )  # fmt: skip
        rig.tick += rng.randrange(20_000)
        drive = rig.device.drive(rig.tick)
        assert 0 <= drive.force_mn <= 10_000 and drive.force_mn - last <= 2000
        last = drive.force_mn


@pytest.mark.parametrize("code", [*FaultCode, FaultCode(0x7777)])
def test_r6_to_r8_faults_latch(code: FaultCode) -> None:
    rig = Rig()
    rig.run(50, 3000)
    rig.device.raise_fault(rig.tick, code)
    if code in (FaultCode.NONE, FaultCode.ESTOP):
        assert rig.device.state == DeviceState.ACTIVE
        return
    drive = rig.run(200, 5000)
    assert rig.device.state == DeviceState.FAULT and rig.status.fault == code
    assert drive == (Drive(DriveKind.FORCE, 3000) if code.holds else Drive(DriveKind.PASSIVE))
    rig.send(Kind.CONFIG, WANTED.pack())
    assert rig.device.in_force is not None and rig.device.state == DeviceState.FAULT
    rig.send(Kind.CLEAR_FAULT, ClearFault(FaultCode(code ^ 1)).pack())
    assert rig.device.state == DeviceState.FAULT
    rig.send(Kind.CLEAR_FAULT, ClearFault(code).pack())
    assert rig.device.state == DeviceState.LINKED and rig.device.drive(rig.tick) == drive


def test_rows_that_are_not_wanted() -> None:
    rig = Rig()
    for reason, row in (("not sampling", (1, 2)), ("elements", (1, 2, 3)), ("value", (1, 40_000))):
        with pytest.raises(RowError) as refused:
            rig.device.push(rig.tick, row)
        assert refused.value.reason == reason
        rig.send(Kind.START)


def test_clamped_names_every_changed_field() -> None:
    other = Config(1, 1, WANTED.format, 20, 1, 1, 1, 1, 100, WANTED.loss_action)
    assert Config().changed(other) == Clamped(0xFF) and WANTED.changed(WANTED) == Clamped(0)


def test_a_board_without_an_actuator_is_possible() -> None:
    limits = replace(reference_ident().limits, force_max_mn=0, hold_cap_mn=0)
    assert DeviceLink(replace(reference_ident(), limits=limits)).ident.limits.force_max_mn == 0
    for impossible in (replace(limits, hold_cap_mn=1), replace(limits, force_max_mn=-1, hold_cap_mn=-1)):
        with pytest.raises(ValueError, match="hold cap"):
            DeviceLink(replace(reference_ident(), limits=impossible))
