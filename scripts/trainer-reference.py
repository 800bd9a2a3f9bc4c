#!/usr/bin/env python3
"""Writes crates/mlp/tests/reference.csv: a small training set and the weights each rule reaches after 100 epochs.

Plain loops over rows and weights in double precision, written from the published rules and from nothing of ours:
the test `reference` compares the trainers with it weight by weight.

    python3 scripts/trainer-reference.py [OUTPUT]
"""

import math
import pathlib
import sys

SIZES = (2, 5, 1)
ROWS = 24
EPOCHS = 100
RATE = 0.05
MOMENTUM = 0.9
DELTA_0, INCREASE, DECREASE, DELTA_MIN, DELTA_MAX = 0.07, 1.2, 0.5, 1e-6, 50.0
WEIGHTS = SIZES[1] * (SIZES[0] + 1) + SIZES[2] * (SIZES[1] + 1)


def numbers(count, seed):
    """Uniform in (-1, 1), short enough to be written exactly."""
    state = seed
    for _ in range(count):
        state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
        yield round((state >> 33) / 2**30 - 1.0, 6)


def rows():
    draws = iter(list(numbers(3 * ROWS, 1)))
    for _ in range(ROWS):
        x, y, noise = next(draws), next(draws), next(draws)
        yield x, y, round(0.6 * math.sin(math.pi * x) * y + 0.4 * math.cos(2.5 * y) + 0.05 * noise, 6)


def error_and_gradient(weights, data):
    inputs, hidden, _ = SIZES
    gradient = [0.0] * len(weights)
    total = 0.0
    for x, y, target in data:
        row = (x, y)
        values = []
        for j in range(hidden):
            s = weights[inputs * hidden + j]
            for i in range(inputs):
                s += weights[j * inputs + i] * row[i]
            values.append(math.tanh(s))
        start = hidden * (inputs + 1)
        output = weights[start + hidden] + sum(weights[start + j] * values[j] for j in range(hidden))
        e = output - target
        total += e * e
        d = 2.0 * e / len(data)
        gradient[start + hidden] += d
        for j in range(hidden):
            gradient[start + j] += d * values[j]
            back = d * weights[start + j] * (1.0 - values[j] ** 2)
            gradient[inputs * hidden + j] += back
            for i in range(inputs):
                gradient[j * inputs + i] += back * row[i]
    return total / len(data), gradient


def descent(weights, data):
    for _ in range(EPOCHS):
        _, g = error_and_gradient(weights, data)
        weights = [w - RATE * d for w, d in zip(weights, g)]
    return weights


def momentum(weights, data, averaged):
    steps = [0.0] * len(weights)
    rate = RATE * (1.0 - MOMENTUM) if averaged else RATE
    for _ in range(EPOCHS):
        _, g = error_and_gradient(weights, data)
        steps = [MOMENTUM * s - rate * d for s, d in zip(steps, g)]
        weights = [w + s for w, s in zip(weights, steps)]
    return weights


def rprop(weights, data, variant):
    weights = list(weights)
    deltas = [DELTA_0] * len(weights)
    last = [0.0] * len(weights)
    moves = [0.0] * len(weights)
    last_error = math.inf
    for _ in range(EPOCHS):
        error, g = error_and_gradient(weights, data)
        for k in range(len(weights)):
            s = g[k] * last[k]
            if s > 0:
                deltas[k] = min(deltas[k] * INCREASE, DELTA_MAX)
            elif s < 0:
                deltas[k] = max(deltas[k] * DECREASE, DELTA_MIN)
            if s < 0 and variant == "rprop+":
                moves[k] = -moves[k]
                g[k] = 0.0
            elif s < 0 and variant == "irprop+":
                moves[k] = -moves[k] if error > last_error else 0.0
                g[k] = 0.0
            else:
                if s < 0 and variant == "irprop-":
                    g[k] = 0.0
                moves[k] = -math.copysign(deltas[k], g[k]) if g[k] != 0 else 0.0
            weights[k] += moves[k]
            last[k] = g[k]
        last_error = error
    return weights


def main():
    default = pathlib.Path(__file__).resolve().parent.parent / "crates/mlp/tests/reference.csv"
    data = list(rows())
    start = [0.8 * w for w in numbers(WEIGHTS, 2)]
    results = {
        "gd": descent(start, data),
        "averaged": momentum(start, data, True),
        "heavy-ball": momentum(start, data, False),
    }
    for variant in ("rprop-", "rprop+", "irprop-", "irprop+"):
        results[variant] = rprop(start, data, variant)
    lines = [["row", *map(repr, row)] for row in data]
    lines += [["start", *map(repr, start)]]
    lines += [[name, *map(repr, weights)] for name, weights in results.items()]
    path = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default
    path.write_text("".join(",".join(line) + "\n" for line in lines), encoding="ascii")


main()
