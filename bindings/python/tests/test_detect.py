"""Arrays and recordings in: the events of gripctl, however the rows arrive."""

from __future__ import annotations

import subprocess
import sys
import threading
import wave
from pathlib import Path
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np
import numpy.typing as npt
import pytest

import slipgrip
from conftest import Replay
from slipgrip import Detector, Event, Pipeline, Recording, detect

RATE = 10_000.0


def noise_with_slips(rows: int = 60_000, seed: int = 5000) -> npt.NDArray[np.float32]:
    rng = np.random.default_rng(seed)
    x = rng.standard_normal(rows).astype(np.float32)
    for at in range(20_000, rows - 3_000, 15_000):
        x[at : at + 2_000] += 8 * rng.standard_normal(2_000).astype(np.float32)
    return x


def plain(events: Sequence[Event]) -> List[Dict[str, Any]]:
    return [{key: value for key, value in event.items() if key != "sample"} for event in events]


def test_the_events_of_gripctl_on_a_file_of_the_same_rows(tmp_path: Path, gripctl_replay: Replay) -> None:
    x = noise_with_slips()
    file = tmp_path / "rows.npz"
    Recording(x, RATE, "vibration").save(file)
    expected = gripctl_replay(file, "--rate", str(RATE))
    found = detect(x, RATE)
    assert plain(found.events) == expected
    assert found.slips == 3
    for event in found.events:
        assert round(event["t_s"] * RATE) == event["sample"]


def test_the_events_of_gripctl_on_real_recordings(data: Path, gripctl_replay: Replay) -> None:
    slips = 0
    files = sorted(file for file in (data / "biotac_slide").glob("m*.csv") if file.stem.count("_") == 1)
    assert files
    for file in files:
        found = detect(slipgrip.read(file))
        assert plain(found.events) == gripctl_replay(file, "--observe"), file
        slips += found.slips
    assert slips > 50


def test_with_the_controller_too(tmp_path: Path, gripctl_replay: Replay) -> None:
    grasp = slipgrip.Grasp("default", 5000)
    rows = np.concatenate([grasp.step(0.0, 3_000), grasp.step(6.0, 5_000), grasp.step(2.0, 5_000)])
    recording = Recording(rows, grasp.rate_hz, grasp.channels)
    file = tmp_path / "grasp.npz"
    recording.save(file)
    found = detect(recording, control=True)
    assert plain(found.events) == gripctl_replay(file, "--rate", str(grasp.rate_hz))
    assert found.command_n is not None and found.command_n.shape == (13_000,) and found.command_n.max() > 1.0
    pipeline = Pipeline(grasp.rate_hz, grasp.channels)
    commands = np.array([pipeline.step(block)[0] for block in np.split(rows, 1300)], dtype=np.float32)
    assert np.array_equal(commands, found.command_n[9::10])
    assert found.need is not None and found.need.shape == (13_000, len(slipgrip.NEED))
    assert np.array_equal(pipeline.need, found.need[-1], equal_nan=True)
    low, median, high, admissible = found.need[np.isfinite(found.need).all(axis=1)].T
    assert (low <= median).all() and (median <= high).all() and (admissible >= 0.0).all()
    assert detect(recording).need is None


def test_an_mcap_of_gripd_replays_with_its_own_settings(tmp_path: Path, gripctl: str, gripctl_replay: Replay) -> None:
    npy, mcap = tmp_path / "rows.npy", tmp_path / "rows.mcap"
    np.save(npy, noise_with_slips())
    command = [gripctl, "import", str(npy), "-o", str(mcap), "--rate", "10000", "--map", "vibration=column_0"]
    subprocess.run(command, capture_output=True, check=True)
    events = slipgrip.replay(mcap)
    assert events == gripctl_replay(mcap)
    assert plain(detect(slipgrip.read(mcap)).events) == events


@pytest.mark.parametrize("size", [1, 7, 10, 997])
def test_blocks_of_any_size_give_the_same_events(size: int) -> None:
    x = noise_with_slips()
    detector, events = Detector(RATE), []
    for at in range(0, len(x), size):
        events += detector.push(x[at : at + size])
    assert events == detect(x, RATE).events
    assert (detector.samples, detector.slips) == (len(x), 3)
    assert detector.floor is not None and detector.floor.shape == (6,)


@pytest.mark.parametrize("kind", ["float64", "float16", "int16", ">f4", "strided", "column", "fortran", "list", "readonly", "unaligned"])
def test_every_kind_of_array_is_the_same_rows(kind: str) -> None:
    x = np.round(20 * noise_with_slips()).astype(np.float32)
    shaped: Any = x
    if kind == "strided":
        shaped = np.repeat(x, 2)[::2]
    elif kind == "column":
        shaped = x[:, np.newaxis]
    elif kind == "fortran":
        shaped = np.asfortranarray(np.stack([x, x], axis=1))[:, 0]
    elif kind == "list":
        shaped = x.tolist()
    elif kind == "readonly":
        shaped = x.copy()
        shaped.flags.writeable = False
    elif kind == "unaligned":
        shaped = np.frombuffer(b"\0" + x.tobytes(), dtype=np.float32, offset=1)
    else:
        shaped = x.astype(kind)
    assert detect(shaped, RATE).events == detect(x, RATE).events


def test_a_column_without_a_name_is_left_out() -> None:
    x = noise_with_slips()
    wide = np.stack([np.full_like(x, np.nan), x, np.zeros_like(x)], axis=1)
    assert detect(wide, RATE, ["", "vibration", ""]).events == detect(x, RATE).events


def test_statistics_have_a_value_for_each_row() -> None:
    x = noise_with_slips()
    found = detect(x, RATE, bands=True)
    assert found.t_s.shape == found.statistic.shape == found.scene.shape == (len(x),)
    assert found.t_s[1] == pytest.approx(1e-4) and found.command_n is None
    assert found.levels is not None and found.levels.shape == (len(x), len(slipgrip.BANDS))
    first = next(event for event in found.events if event["type"] == "slip")
    assert found.statistic[first["sample"]] >= 1.0
    assert slipgrip.SCENES[found.scene[first["sample"] + 1]] == "slipping"


def test_times_of_the_rows_are_used(tmp_path: Path, gripctl_replay: Replay) -> None:
    x = noise_with_slips()
    times = 5.0 + np.arange(len(x)) / RATE
    times[30_000:] += 0.5
    recording = Recording(x, RATE, "vibration", times=times)
    file = tmp_path / "late.npz"
    recording.save(file)
    found = detect(x, RATE, times=times)
    assert plain(found.events) == gripctl_replay(file, "--rate", str(RATE))
    assert np.allclose(found.t_s, times, atol=1e-6) and np.array_equal(recording.times, found.t_s)


def test_files_of_other_programs(tmp_path: Path) -> None:
    x = noise_with_slips(20_000)
    np.save(tmp_path / "x.npy", x)
    with wave.open(str(tmp_path / "x.wav"), "wb") as file:
        file.setparams((1, 2, 10_000, 0, "NONE", ""))
        file.writeframes((1000 * x).astype("<i2").tobytes())
    npy = slipgrip.read(tmp_path / "x.npy", rate_hz=RATE, channels={"vibration": "column_0"})
    assert np.array_equal(npy["vibration"], x) and npy.rate_hz == RATE and len(npy) == len(x)
    wav = slipgrip.read(tmp_path / "x.wav", channels={"vibration": "channel_1"})
    assert np.allclose(wav["vibration"] * 32.768, x, atol=1e-3) and any("channel_1" in note for note in wav.notes)
    np.savetxt(tmp_path / "x.csv", x, header="vibration", comments="")
    assert np.allclose(slipgrip.read(tmp_path / "x.csv", rate_hz=RATE).data[:, 0], x)


def test_settings_come_from_a_dictionary_or_a_file(tmp_path: Path) -> None:
    x = noise_with_slips()
    deaf = {"detector": {"slack_still": [1e8] * 7}}
    file = tmp_path / "gripd.toml"
    file.write_text(f"[detector]\nslack_still = {[1e8] * 7}\n")
    by_table, by_file = detect(x, RATE, config=deaf), detect(x, RATE, config=file)
    assert by_table.events == by_file.events != detect(x, RATE).events
    with pytest.raises(ValueError, match="unknown field `dtector`"):
        detect(x, RATE, config={"dtector": {}})
    wrong: List[Tuple[Dict[str, Any], str]] = [
        ({"baud": 9600, "detector": {"threshold": 3}}, r'config\["detector"\]\["threshold"\]: unknown field'),
        ({"grip": {"f_max_n": -3}}, r'config\["grip"\]\["f_max_n"\]: grip.f_max_n = -3 is outside'),
        ({"baud": "x"}, r'config\["baud"\]: '),
    ]
    for config, message in wrong:
        with pytest.raises(ValueError, match=message):
            detect(x, RATE, config=config)
    no_config: Any = 3
    with pytest.raises(TypeError, match=r"dict \| path"):
        detect(x, RATE, config=no_config)


def test_long_calls_release_the_gil() -> None:
    x = np.tile(noise_with_slips(), 20)
    counted, done = 0, threading.Event()

    def work() -> None:
        detect(x, RATE)
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    while not done.is_set():
        counted += 1
    thread.join()
    # A held GIL would let this thread count in the short time before and after the call only.
    assert counted > 10_000


def test_an_array_that_another_thread_changes_is_read_as_it_was() -> None:
    x = noise_with_slips(200_000)
    expected, changed, started = detect(x, RATE).events, x.copy(), threading.Event()

    def work() -> None:
        started.wait()
        changed[:] = 0

    interval = sys.getswitchinterval()
    thread = threading.Thread(target=work)
    thread.start()
    try:
        # The other thread runs when this one lets go of the GIL, in the midst of the call.
        sys.setswitchinterval(1000)
        started.set()
        found = detect(changed, RATE).events
    finally:
        sys.setswitchinterval(interval)
    thread.join()
    assert found == expected and not changed.any()


def test_a_floor_that_was_learned_in_a_slip_is_named() -> None:
    x = 0.1 * np.random.default_rng(7).standard_normal(60_000).astype(np.float32)
    assert "floor" not in repr(detect(x, RATE))
    x[:10_000] *= 10
    found, detector = detect(x, RATE), Detector(RATE)
    detector.push(x)
    assert found.floor_lowered >= 1 and "floor" in repr(found)
    assert (found.floor_lowered, found.floor_health) == (detector.floor_lowered, detector.floor_health)
