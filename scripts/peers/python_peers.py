"""The folder the bench `peers` wrote in; times of PyTorch's Rprop and scikit-learn's L-BFGS out, one NAME<tab>VALUE<tab>UNIT a line."""

import pathlib
import sys
import time

import numpy
import torch
from sklearn.neural_network import MLPRegressor

HIDDEN = {"surface2": 10, "building1": 16}


def rows(path):
    lines = path.read_text().splitlines()
    return [numpy.array([list(map(float, line.split())) for line in lines[start::2]], dtype=numpy.float32) for start in (1, 2)]


def torch_epoch(x, y, hidden):
    torch.set_num_threads(1)
    net = torch.nn.Sequential(torch.nn.Linear(x.shape[1], hidden), torch.nn.Tanh(), torch.nn.Linear(hidden, y.shape[1]))
    optimizer = torch.optim.Rprop(net.parameters(), lr=0.07)
    x, y = torch.from_numpy(x), torch.from_numpy(y)
    least = 1e9
    for _ in range(7):
        start = time.perf_counter()
        for _ in range(100):
            optimizer.zero_grad()
            torch.nn.functional.mse_loss(net(x), y).backward()
            optimizer.step()
        least = min(least, (time.perf_counter() - start) / 100)
    return least


def sklearn_epoch(x, y, hidden):
    net = MLPRegressor((hidden,), activation="tanh", solver="lbfgs", alpha=0.0, max_iter=200, tol=0.0)
    start = time.perf_counter()
    net.fit(x, y.ravel() if y.shape[1] == 1 else y)
    return (time.perf_counter() - start) / max(net.n_iter_, 1)


for name, neurons in HIDDEN.items():
    inputs, targets = rows(pathlib.Path(sys.argv[1]) / f"{name}.data")
    print(f"torch rprop {name}\t{torch_epoch(inputs, targets, neurons) * 1e6:.4f}\tus/epoch")
    print(f"scikit-learn lbfgs {name}\t{sklearn_epoch(inputs, targets, neurons) * 1e6:.4f}\tus/epoch")
