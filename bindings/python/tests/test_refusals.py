"""What is wrong is a Python exception with a sentence, whatever is called with whatever."""

from __future__ import annotations

import os
import random
from pathlib import Path
from typing import Any, Callable, List

import numpy as np
import pytest

import slipgrip
from slipgrip import Calibration, Detector, Grasp, GraspEnv, Model, Pipeline, Recording, calibrate, detect, esc, profile, train

X = np.zeros(2_000, dtype=np.float32)
CALLS = int(os.environ.get("FUZZ_CALLS", "100000"))


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda: detect(X), ValueError, "rate_hz is needed"),
        (lambda: detect(X, 0.0), ValueError, "rate_hz = 0: a finite number of more than 0"),
        (lambda: detect(X, float("nan")), ValueError, "rate_hz = NaN"),
        (lambda: detect(X, 5.0), ValueError, "sample_rate_hz = 5 is outside 20 to 50000"),
        (lambda: detect(X, 1e6), ValueError, "outside 20 to 50000"),
        (lambda: detect(X[:0], 1e4), ValueError, "it has no rows"),
        (lambda: detect(X.reshape(-1, 2), 1e4), ValueError, r"shape \[1000, 2\] does not fit the channels"),
        (lambda: detect(X.reshape(-1, 2, 2), 1e4), ValueError, "does not fit"),
        (lambda: detect(np.float32(3.0), 1e4), ValueError, "does not fit"),
        (lambda: detect(X.astype(complex), 1e4), TypeError, "real numbers is needed, not one of dtype complex128"),
        (lambda: detect(np.array(["a"] * 9), 1e4), TypeError, "not one of dtype <U1"),
        (lambda: detect(None, 1e4), TypeError, "dtype object"),  # type: ignore[arg-type]
        (lambda: detect(X, 1e4, "sound"), ValueError, "stylus"),
        (lambda: detect(X.reshape(-1, 2), 1e4, ["vibration", "sound"]), ValueError, '"sound".* is not known; known are'),
        (lambda: detect(X.reshape(-1, 2), 1e4, ["vibration", "vibration"]), ValueError, "named twice"),
        (lambda: detect(X.reshape(-1, 2), 1e4, ["vibration", "t_s"]), ValueError, "times="),
        (lambda: detect(X, 1e4, []), ValueError, ""),
        (lambda: detect(X, 1e4, times=np.arange(5.0)), ValueError, "5 of them for 2000 rows"),
        (lambda: detect(X, 1e4, times=np.full(2_000, np.nan)), ValueError, "NaN s in row 0"),
        (lambda: detect(X, 1e4, times=-np.arange(2_000.0)), ValueError, "-1 s in row 1"),
        (lambda: detect(X, 1e4, times=np.arange(2_000.0) % 7), ValueError, "row 7 goes backwards"),
        (lambda: detect(X, 1e4, control=True), ValueError, "the controller needs"),
        (lambda: detect(X, 1e4, model="nowhere.json"), ValueError, "nowhere.json"),
        (lambda: detect(X, 1e4, config="nowhere.toml"), FileNotFoundError, ""),
        (lambda: detect(X, 1e4, config={"grip": None}), ValueError, "config"),
        (lambda: detect(Recording(X, 1e4, "vibration"), 1e4), ValueError, "has its own rate"),
        (lambda: slipgrip.read("nowhere.csv"), FileNotFoundError, ""),
        (lambda: slipgrip.read(os.curdir), ValueError, ""),
        (lambda: Recording(X, 1e4, "vibration").save("x.txt"), ValueError, "saved as .npz"),
        (lambda: Recording(X, 1e4, "vibration")["force_n"], KeyError, "force_n"),
        (lambda: calibrate(X, 1e4), ValueError, "too short"),
        (lambda: calibrate(X, 1e4, interval_s=0.0), ValueError, "interval_s"),
        (lambda: Calibration.load("nowhere.toml"), FileNotFoundError, ""),
        (lambda: esc([1e-6], [1e-4, 2e-4], 1.0, 0.1), ValueError, "delta has 1 values and s has 2"),
        (lambda: esc([1e-6], [1e-4], float("nan"), 0.1), ValueError, "force = NaN"),
        (lambda: esc([[1e-6]], [1e-4], 1.0, 0.1), ValueError, "one dimension"),
        (lambda: profile([1e-6, 2e-6], 1e-6), ValueError, "at least 3"),
        (lambda: profile([1e-6, np.nan, 0.0], 1e-6), ValueError, "number 1 is NaN"),
        (lambda: profile(np.zeros(100), 1e-3), ValueError, "cutoff"),
        (lambda: profile(np.zeros(100), 1e-6, cutoff=1e3), ValueError, "100 times the length of the profile"),
        (lambda: train([[1.0], [np.nan]], [1.0, 2.0]), ValueError, "x and y"),
        (lambda: train([[1.0], [2.0]], [1.0]), ValueError, "x and y"),
        (lambda: train([[1.0]], [1.0], algorithm="magic"), ValueError, "magic"),
        (lambda: Model.load("default").predict([[1.0, 2.0, 3.0]]), ValueError, "needed"),
        (lambda: Model.load("nowhere.json"), FileNotFoundError, ""),
        (lambda: Grasp("nowhere"), ValueError, "built in are default"),
        (lambda: Grasp("name = 'x'\nmass_kg = -1.0"), ValueError, "mass_kg"),
        (lambda: Grasp().step(-1.0, 10), ValueError, "force_n = -1"),
        (lambda: Grasp().step(1.0, 0), ValueError, "rows = 0"),
        (lambda: GraspEnv(duration_s=float("inf")), ValueError, "duration_s"),
        (lambda: GraspEnv().step([1.0, 2.0]), ValueError, "one force"),
        (lambda: Pipeline(1e4, ["stylus"]), ValueError, "force_n"),
        (lambda: Pipeline(1e4, ["stylus", "force_n"]).at_least(-1.0), ValueError, "force_n = -1"),
        (lambda: Pipeline(1e4, ["stylus", "force_n"]).expect(-1.0), ValueError, "force_n = -1"),
    ],
)
def test_a_sentence_says_what_is_wrong(call: Callable[[], object], kind: type, words: str) -> None:
    with pytest.raises(kind, match=words) as caught:
        call()
    assert str(caught.value)


def test_a_missing_file_is_named() -> None:
    missing: List[Callable[[], object]] = [
        lambda: slipgrip.read("nowhere/x.csv"),
        lambda: slipgrip.replay("nowhere/x.mcap"),
        lambda: detect(X, 1e4, config="nowhere/x.toml"),
        lambda: detect(X, 1e4, calibration="nowhere/x.toml"),
        lambda: Calibration.load("nowhere/x.toml"),
        lambda: Model.load("nowhere/x.json"),
    ]
    for call in missing:
        with pytest.raises(FileNotFoundError, match="nowhere/x") as caught:
            call()
        assert str(caught.value.filename).startswith("nowhere/x") and caught.value.strerror


def test_a_mask_is_not_ignored() -> None:
    x = np.ma.masked_greater(np.arange(2_000.0), 1_990.0)
    for call in (lambda: detect(x, 1e4), lambda: Detector(1e4).push(x), lambda: detect(X, 1e4, times=x)):
        with pytest.raises(ValueError, match=r"masked.*filled\(numpy.nan\)"):
            call()
    assert detect(x.filled(np.nan), 1e4).unusable == 9
    assert detect(np.ma.asarray(X), 1e4).slips == 0


def test_a_refused_block_changes_nothing() -> None:
    detector = Detector(1e4)
    detector.push(X)
    with pytest.raises(ValueError, match="backwards"):
        detector.push(X[:3], times=[1.0, 2.0, 1.5])
    assert detector.samples == len(X)
    assert detector.push(X[:0]) == []


def test_readings_of_broken_sensors_are_counted_and_no_error() -> None:
    x = np.full(3_000, np.nan, dtype=np.float32)
    x[1_000:] = np.inf
    assert detect(x, 1e4).unusable == len(x)
    assert detect(np.full(9, 1e300), 1e4).unusable == 9


def odd_array(rng: random.Random) -> Any:
    shape = rng.choice([(), (0,), (1,), (2,), (17,), (40,), (3, 2), (20, 2), (20, 3), (0, 2), (4, 1), (2, 2, 2)])
    kind = rng.choice(["f4", "f4", "f8", "f2", "i4", "u1", "?", "c8", "S3", "O", "M8[s]", ">f4", ">f8"])
    values = np.random.default_rng(rng.getrandbits(32)).standard_normal(shape) * 10.0 ** rng.randint(-40, 40)
    with np.errstate(all="ignore"):
        array = np.asarray(values.astype("i8").astype(kind) if kind in ("M8[s]", "u1", "i4") else values.astype(kind))
    if kind in ("f4", "f8") and array.size and rng.random() < 0.3:
        array.flat[rng.randrange(array.size)] = rng.choice([np.nan, np.inf, -np.inf, 1e38])
    if array.ndim and rng.random() < 0.2:
        array = array[:: rng.choice([-1, 2])]
    if rng.random() < 0.1:
        array = np.array(array, order="F")
    return array


def odd_value(rng: random.Random) -> Any:
    words = [None, True, "", "x", "stylus", "vibration", "force_n", b"x", {}, [], (), object(), "default"]
    names = [["vibration", "force_n"], ["stylus", "force_n"], ["pressure_0", "pressure_1"], [""], ["travel_mm"]]
    figures = [0, 1, -1, 20, 1000.0, 10_000, 1e9, -0.0, 1e-300, float("nan"), float("inf"), 2**70]
    kind = rng.randrange(7)
    if kind < 2:
        return odd_array(rng)
    if kind == 2:
        return odd_array(rng).tolist()
    if kind == 6:
        return {"grip": {"f_max_n": rng.choice([1.0, -1.0, "x", None, float("nan")])}}
    all_choices: List[List[Any]] = [words, names, figures]
    return rng.choice(all_choices[kind - 3])


def test_random_calls_never_crash() -> None:
    """Each of so many calls returns, or raises an ordinary exception with a sentence."""
    rng = random.Random(5000)
    detector, pipeline = Detector(1e4), Pipeline(1e4, ["stylus", "force_n"])
    recording, model, grasp = Recording(X, 1e4, "vibration"), Model.load("default"), Grasp()

    def value() -> Any:
        return odd_value(rng)

    def options(*names: str) -> Any:
        return {name: value() for name in names if rng.random() < 0.2}

    def rate() -> Any:
        return rng.choice([1e4, 1e4, value()])

    def channels() -> Any:
        return rng.choice(["vibration", ["stylus", "force_n"], value()])

    calls: List[Callable[[], Any]] = [
        lambda: detector.push(value(), **options("times")),
        lambda: pipeline.push(value(), **options("times")),
        lambda: pipeline.step(value(), **options("times")),
        lambda: pipeline.at_least(value()),
        lambda: rng.choice([pipeline.release, pipeline.grasp])(),
        lambda: detect(value(), rate(), channels(), **options("times", "config", "calibration", "model", "control", "bands")),
        lambda: detect(recording, **options("rate_hz", "config", "bands")),
        lambda: Detector(rate(), channels(), **options("config", "calibration", "model")),
        lambda: Pipeline(rate(), channels(), **options("config", "calibration", "model")),
        lambda: Recording(value(), rate(), channels(), **options("times", "name")),
        lambda: recording[value()],
        lambda: calibrate(value(), rate(), channels(), **options("times", "interval_s", "config")),
        lambda: esc(value(), value(), rng.choice([1.0, value()]), rng.choice([0.1, value()]), **options("noise")),
        lambda: profile(value(), rng.choice([1e-6, value()]), **options("speed", "cutoff", "lambda_s", "low_pass", "hysteresis")),
        lambda: model.predict(value()),
        lambda: train(value(), value(), epochs=3, **options("inputs", "targets", "algorithm", "validation", "seed", "goal", "decay")),
        lambda: grasp.step(rng.choice([1.0, value()]), rng.choice([1, value()]) if rng.random() < 0.5 else 1),
    ]
    done = failed = 0
    for _ in range(CALLS):
        try:
            rng.choice(calls)()
            done += 1
        except (ValueError, TypeError, KeyError, OverflowError, OSError) as error:
            assert str(error)
            failed += 1
    assert done > CALLS / 20 and failed > CALLS / 20


def test_files_of_any_content_never_crash(tmp_path: Path) -> None:
    rng = random.Random(5001)
    for number in range(300):
        ending = rng.choice(["csv", "npz", "npy", "wav", "mcap", "db3", "toml", "json", "x"])
        file = tmp_path / f"{number}.{ending}"
        head = rng.choice([b"", b"RIFF\x10\0\0\0WAVEfmt ", b"\x93NUMPY\x01\0v\0{'descr': '<f4'", b"t_s,vibration\n0,1\n", b"\x89MCAP0\r\n", b"PK\x03\x04"])
        file.write_bytes(head + rng.randbytes(rng.randrange(200)))
        for read in (slipgrip.read, slipgrip.replay, Calibration.load, Model.load):
            try:
                read(file)
            except (ValueError, OSError) as error:
                assert str(error)
