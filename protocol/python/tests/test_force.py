"""What the comparison of this device with the Rust one (`grip_link.diff`) leaves out: commands at random, rows and limits that cannot be."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from grip_link import frame
from grip_link.device import DeviceLink, RowError
from grip_link.diff import reference_ident
from grip_link.frame import Header
from grip_link.messages import Clamped, Config, Grip, Hello, Kind

WANTED = Config(sample_rate_hz=1000, batch=1, channel_mask=3, force_max_mn=10_000, slew_mn_s=200_000, hold_cap_mn=8_000)


class Rig:
    """A device and a host driven by hand; a tick is a microsecond."""

    def __init__(self) -> None:
        self.device, self.tick, self.seq = DeviceLink(reference_ident()), 1000, 0
        self.device.ready(0)
        self.send(Kind.HELLO, Hello(0).pack())
        self.send(Kind.CONFIG, WANTED.pack())

    def send(self, kind: Kind, payload: bytes = b"") -> None:
        self.device.receive(self.tick, frame.encode(Header(kind, self.seq, 5, to_host=False), payload))
        self.seq = (self.seq + 1) & 0xFFFF


def test_every_command_keeps_the_limits() -> None:
    rng = random.Random(6)
    edges = [0, 1, -1, 9999, 10_000, 10_001, 2**31 - 1, -(2**31)]
    rig, cmd_id, last, forces = Rig(), 0, 0, set()
    for _ in range(5000):
        force = rng.choice(edges) if rng.random() < 0.5 else rng.randrange(-(2**31), 2**31)
        cmd_id = rng.choice([cmd_id + 1, cmd_id, rng.randrange(2**32)]) & 0xFFFFFFFF
        slew = rng.choice([0, 1, 200_000, 2**32 - 1])
        rig.send(Kind.GRIP, Grip(cmd_id, rng.randrange(5), 0, rng.randrange(1 << 16), force, slew, 0).pack())
        rig.tick += rng.randrange(20_000)
        drive = rig.device.drive(rig.tick)
        assert 0 <= drive.force_mn <= 10_000 and drive.force_mn - last <= 2000
        last = drive.force_mn
        forces.add(last)
    assert len(forces) > 100


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
