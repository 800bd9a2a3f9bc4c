"""What a person sees of objects and of refusals."""

import pathlib

import numpy as np
import pytest

import slipgrip


def test_objects_say_what_they_are(tmp_path: pathlib.Path) -> None:
    assert repr(slipgrip.Detector(1600)) == 'Detector(1600 Hz, channels=["vibration"])'
    assert repr(slipgrip.Model.load("default")).startswith("Model([")


def test_refusals_name_arguments_of_python() -> None:
    with pytest.raises(ValueError, match="rate_hz=1000000000"):
        slipgrip.Detector(1e9)
    with pytest.raises(TypeError, match=r"a name, or a list of one for each column, is needed, not <class 'dict'>[\s\S]*'channels'"):
        slipgrip.detect(np.zeros(9), 1600, {"vibration": "x"})  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r'slipgrip.read\("run.csv"\) reads a file'):
        slipgrip.detect("run.csv")


def test_a_recording_that_ends_before_the_floor_is_known_says_so() -> None:
    found = slipgrip.detect(np.random.default_rng(1).normal(0, 0.01, 100), 1600)
    assert found.floor_health == "learning" and "never learned" in repr(found)
    whole = slipgrip.detect(np.random.default_rng(1).normal(0, 0.01, 3200), 1600)
    assert whole.floor_health != "learning"


def test_a_model_is_exported(tmp_path: pathlib.Path) -> None:
    model = slipgrip.Model.load("default")
    model.export(tmp_path / "net.c")
    model.export(tmp_path / "net.onnx")
    assert "net.h" in (tmp_path / "net.c").read_text() and (tmp_path / "net.h").exists()
    assert (tmp_path / "net.onnx").stat().st_size > 100
    with pytest.raises(ValueError, match="as .c or .onnx"):
        model.export(tmp_path / "net.txt")
