"""A recording without slip in; the calibration of gripctl out, and in use."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np

from slipgrip import Calibration, Detector, Recording, calibrate, detect

RATE = 2_000.0
REST = np.random.default_rng(5000).standard_normal(60 * 2_000).astype(np.float32)


def test_it_is_the_calibration_of_gripctl_and_survives_a_file(tmp_path: Path, gripctl: str) -> None:
    recording = Recording(REST, RATE, "vibration")
    recording.save(tmp_path / "rest.npz")
    command = [gripctl, "calibrate", "rest.npz", "--rate", str(RATE), "-o", "theirs.toml"]
    subprocess.run(command, capture_output=True, check=True, cwd=tmp_path)
    made = calibrate(REST, RATE)
    made.save(tmp_path / "ours.toml")
    assert (tmp_path / "ours.toml").read_text() == (tmp_path / "theirs.toml").read_text()
    assert calibrate(recording).to_dict() == made.to_dict() == Calibration.load(tmp_path / "ours.toml").to_dict()
    assert made.rate_hz == RATE and made.floor is not None and made.slack is not None and made.smallest is not None


def test_a_calibrated_detector_uses_it(tmp_path: Path) -> None:
    made = calibrate(REST, RATE)
    made.save(tmp_path / "cal.toml")
    x = REST[:20_000].copy()
    x[15_000:16_000] *= 8
    by_object = detect(x, RATE, calibration=made)
    assert by_object.events == detect(x, RATE, calibration=tmp_path / "cal.toml").events
    assert by_object.slips == 1
    detector = Detector(RATE, calibration=made)
    assert detector.floor is not None and np.array_equal(detector.floor, made.floor)  # type: ignore[arg-type]
    try:
        Detector(1_000.0, calibration=made)
    except ValueError as error:
        assert "2000" in str(error)
    else:
        raise AssertionError("a calibration for another rate was taken")
