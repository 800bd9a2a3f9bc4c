"""The Rust peer's virtual gripper at the other end of a pseudo-terminal; GRIPCTL is the path of the program."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from grip_link import ChannelKind, Config, GripLink
from grip_link.messages import DeviceState, FaultCode

GRIPCTL = os.environ.get("GRIPCTL", "")
pytestmark = pytest.mark.skipif(not GRIPCTL, reason="GRIPCTL does not name the gripctl program")


@pytest.fixture
def port(tmp_path: Path) -> Iterator[str]:
    path = tmp_path / "gripper"
    with subprocess.Popen([GRIPCTL, "sim", "--pty", str(path), "--duration", "60"], stderr=subprocess.DEVNULL) as sim:
        try:
            end_s = time.monotonic() + 20.0
            while not path.exists() and time.monotonic() < end_s:
                time.sleep(0.01)
            yield str(path)
        finally:
            sim.terminate()


def test_samples_force_clock_and_latches(port: str) -> None:
    with GripLink.open(port, Config(sample_rate_hz=2000, batch=2, force_max_mn=20_000)) as link:
        assert link.ident is not None and link.ident.channels[0].kind == ChannelKind.STYLUS
        count = 0
        for sample in link.samples(2.0):
            link.grip(15.0, cause_sample=sample.index)
            assert abs(sample[ChannelKind.STYLUS]) < 1e-2
            count += 1
        assert 1000 <= count <= link.loss.received and link.loss.lost == link.loss.dropped_by_mcu
        assert link.counters.bad_blocks == link.counters.stale == link.malformed_frames == 0
        assert link.status is not None and link.status.target_mn == 15_000
        assert link.status.state == DeviceState.ACTIVE and link.status.last_cmd_id > 100
        assert link.wait(lambda: link.status is not None and link.status.state == DeviceState.HOLD, 1.0)
        assert link.wait(lambda: link.stats is not None, 3.0) and link.stats is not None
        assert link.stats.crc == link.stats.cobs == link.stats.length == link.stats.malformed == 0
        assert link.estop()
        link.clear_fault(FaultCode.ESTOP)
        assert link.wait(lambda: link.status is not None and link.status.state == DeviceState.ARMED, 1.0)


def test_a_second_session_after_the_first(port: str) -> None:
    for rate_hz in (500, 1000):
        with GripLink.open(port, Config(sample_rate_hz=rate_hz, batch=1)) as link:
            assert link.config is not None and link.config.sample_rate_hz == rate_hz
            assert sum(1 for _ in link.samples(0.5)) > rate_hz // 4
