"""Exports models as ONNX and compares onnxruntime with the networks computed from the model files.

Usage: onnx_check.py GRIPCTL FOLDER MODEL.json...; more models of other shapes are made up. Fails beyond BOUND.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy
import onnx
import onnxruntime

# Largest difference in scaled units (the training range of a target is 2), divided by 1 + the size of the value.
BOUND = 2e-5

FUNCTIONS = {
    "tanh": numpy.tanh,
    "linear": lambda x: x,
    "logistic": lambda x: 1 / (1 + numpy.exp(-x)),
    "relu": lambda x: numpy.maximum(x, 0),
}


def made_up(sizes, activations, transforms):
    """A model with repeatable weights; column i has transforms[i % len], column 3 is constant."""
    random = numpy.random.default_rng(sum(sizes))

    def columns(kind, count):
        return [
            {
                "name": f"{kind}_{i}", "unit": "N", "min": 0.25, "max": 0.25 if i == 3 else 30.0,
                "transform": transforms[i % len(transforms)], "noise": 0.3 if kind == "target" else 0.0,
            }
            for i in range(count)
        ]

    layers = [
        {
            "activation": activation,
            "weights": random.normal(0, 0.6, (after, before)).astype(numpy.float32).tolist(),
            "biases": random.normal(0, 0.3, after).astype(numpy.float32).tolist(),
        }
        for before, after, activation in zip(sizes, sizes[1:], activations)
    ]
    return {
        "format": "mlp-model", "version": 1, "inputs": columns("input", sizes[0]), "targets": columns("target", sizes[-1]),
        "layers": layers, "training": None,
    }


def by_column(columns, rows, functions):
    """Each column of the rows through the function of its transform and itself."""
    rows = numpy.array(rows, dtype=numpy.float64)
    for i, column in enumerate(columns):
        rows[:, i] = functions[column["transform"]](rows[:, i], column)
    return rows


def transformed(columns, raw):
    return by_column(columns, raw, {"identity": lambda x, _: x, "ln": lambda x, _: numpy.log(x), "reciprocal": lambda x, _: -1 / x})


def raw(columns, values):
    """Raw values of transformed ones; a reciprocal answers by its noise."""

    def reciprocal(z, column):
        u = numpy.maximum(-z, column.get("noise", 0))
        return u / (u**2 + column.get("noise", 0) ** 2)

    return by_column(columns, values, {"identity": lambda x, _: x, "ln": lambda x, _: numpy.exp(x), "reciprocal": reciprocal})


def scaling(columns):
    """Lower limits and half ranges, transformed."""
    low, high = (transformed(columns, [[column[key] for column in columns]])[0] for key in ("min", "max"))
    return low, (high - low) / 2


def scaled(columns, rows):
    low, half = scaling(columns)
    return numpy.where(half == 0, 0, (transformed(columns, rows) - low) / numpy.where(half == 0, 1, half) - 1)


def reference(model, rows):
    """Answers in double precision."""
    x = scaled(model["inputs"], rows)
    for layer in model["layers"]:
        x = FUNCTIONS[layer["activation"]](x @ numpy.array(layer["weights"]).T + numpy.array(layer["biases"]))
    low, half = scaling(model["targets"])
    return raw(model["targets"], low + (x + 1) * half)


def check(gripctl, path):
    """Largest difference of one model, relative to 1 + the size of the scaled value."""
    exported = path.with_suffix(".onnx")
    subprocess.run([gripctl, "export", path, "--format", "onnx"], check=True, stdout=subprocess.DEVNULL)
    onnx.checker.check_model(str(exported), full_check=True)
    session = onnxruntime.InferenceSession(str(exported), providers=["CPUExecutionProvider"])
    model = json.loads(path.read_text())
    metadata = session.get_modelmeta().custom_metadata_map
    assert [column["unit"] for column in json.loads(metadata["inputs"])] == [column["unit"] for column in model["inputs"]]

    low, high = (numpy.array([column[key] for column in model["inputs"]]) for key in ("min", "max"))
    random = numpy.random.default_rng(1)
    rows = (low + (high - low) * random.random((4000, len(low)))).astype(numpy.float32)
    beyond = rows[:500] * numpy.float32(1.5)
    positive = [column["transform"] != "identity" for column in model["inputs"]]
    beyond[:, positive] = numpy.abs(beyond[:, positive])
    rows = numpy.concatenate([rows, beyond])
    targets, in_range = session.run(["targets", "in_range"], {"features": rows})
    lowest, highest = low.astype(numpy.float32), high.astype(numpy.float32)
    assert (in_range == ((rows >= lowest) & (rows <= highest))).all(), f"{path}: in_range"
    assert targets.shape == (len(rows), len(model["targets"])) and targets.dtype == numpy.float32
    expected, found = (scaled(model["targets"], answers) for answers in (reference(model, rows), targets))
    return float(numpy.max(numpy.abs(found - expected) / (1 + numpy.abs(expected))))


def main():
    gripctl, folder = sys.argv[1], Path(sys.argv[2])
    models = {Path(name).stem: json.loads(Path(name).read_text()) for name in sys.argv[3:]}
    models["line"] = made_up([1, 1], ["linear"], ["identity"])
    models["small"] = made_up([2, 10, 1], ["tanh", "linear"], ["identity", "ln"])
    models["positive"] = made_up([5, 7, 4], ["relu", "logistic"], ["ln"])
    models["deep"] = made_up([16, 32, 16, 8, 2], ["tanh", "logistic", "relu", "linear"], ["ln", "identity", "reciprocal"])
    models["reciprocal"] = made_up([2, 10, 1], ["tanh", "linear"], ["reciprocal"])
    failed = 0
    for name, model in models.items():
        path = folder / f"{name}.json"
        path.write_text(json.dumps(model))
        difference = check(gripctl, path)
        failed += not difference <= BOUND
        print(f"{name}: largest difference {difference:.1e} (bound {BOUND:.0e})")
    print(f"onnxruntime {onnxruntime.__version__}: {len(models) - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
