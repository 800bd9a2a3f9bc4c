"""Training, its file, and a trained model in the detector."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from slipgrip import Detector, Model, train


def test_a_product_is_learned_and_survives_its_file(tmp_path: Path) -> None:
    rng = np.random.default_rng(5000)
    x = rng.uniform(0.5, 2.0, (400, 2))
    y = x[:, 0] * x[:, 1]
    model = train(x, y, inputs=["a:ln", "b:ln"], targets="f:ln", algorithm="lm", hidden=[5], epochs=100, seed=1)
    predicted = model.predict(x[:10])
    assert predicted.shape == (10, 1) and predicted.dtype == np.float64
    assert np.allclose(predicted[:, 0], y[:10], rtol=0.01)
    assert model.report["train_within_10pct"] == 1.0 and model.inputs == ["a", "b"] and model.targets == ["f"]
    model.save(tmp_path / "m.json")
    assert np.array_equal(Model.load(tmp_path / "m.json").predict(x), model.predict(x))


def test_rows_of_gripctl_train_a_model_for_the_detector(tmp_path: Path, gripctl: str) -> None:
    command = [gripctl, "generate", "-o", "rows.npz", "--rows", "500", "--seed", "5000"]
    subprocess.run(command, check=True, cwd=tmp_path, capture_output=True)
    rows = np.load(tmp_path / "rows.npz")
    names = ["trial_force_n", "slip_acceleration_m_s2"]
    x = np.stack([rows[name] for name in names], axis=1)
    model = train(x, rows["adequate_force_n"], inputs=names, targets="adequate_force_n", algorithm="lm", epochs=50)
    model.save(tmp_path / "m.json")
    for given in (model, tmp_path / "m.json", "default", "paper"):
        Detector(1e4, ["stylus", "force_n"], model=given)


def test_an_interval_holds_its_share_of_unseen_rows(tmp_path: Path) -> None:
    rng = np.random.default_rng(5000)
    x = rng.uniform(0.5, 2.0, (1200, 2))
    y = x[:, 0] * x[:, 1] * np.exp(rng.normal(0.0, 0.1, 1200))
    model = train(
        x[:200], y[:200], inputs=["a:ln", "b:ln"], targets="f:ln", algorithm="lm", hidden=[3], epochs=30, interval=0.9
    )
    model.save(tmp_path / "m.json")
    again = Model.load(tmp_path / "m.json")
    predicted, low, high = again.predict(x[200:], interval=True)
    assert np.array_equal(predicted, model.predict(x[200:])) and again.interval == 0.9
    assert 0.85 < np.mean((low[:, 0] <= y[200:]) & (y[200:] <= high[:, 0])) < 0.95
    assert np.allclose(predicted / low, high / predicted)
    plain = train(x[:50], y[:50], epochs=5)
    assert plain.interval is None
    with pytest.raises(ValueError, match="states no interval"):
        plain.predict(x[:5], interval=True)


def test_validation_ends_a_training() -> None:
    rng = np.random.default_rng(5000)
    x, y = rng.standard_normal((40, 3)), rng.standard_normal(40)
    model = train(x, y, validation=(rng.standard_normal((40, 3)), rng.standard_normal(40)), epochs=2000, hidden=[20])
    assert model.report["epochs"] < 2000 and model.report["validation"]
