"""The folder the bench `peers` wrote in; times of PyTorch's Rprop and scikit-learn's L-BFGS out, one NAME<tab>VALUE<tab>UNIT a line.

Also trains PyTorch's Rprop and SGD for 100 epochs from the weights the bench started from and fails where a weight differs from
the bench's in the fifth digit.
"""

import pathlib
import sys
import time

import numpy
import torch
from sklearn.neural_network import MLPRegressor

HIDDEN = {"surface2": 10, "building1": 16}


def rows(path, kind):
    lines = path.read_text().splitlines()
    return [numpy.array([list(map(float, line.split())) for line in lines[start::2]], dtype=kind) for start in (1, 2)]


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
    net = MLPRegressor(hidden_layer_sizes=(hidden,), activation="tanh", solver="lbfgs", alpha=0.0, max_iter=200, tol=0.0)
    start = time.perf_counter()
    net.fit(x, y.ravel() if y.shape[1] == 1 else y)
    return (time.perf_counter() - start) / max(net.n_iter_, 1)


def load_weights(net, path):
    """Puts the weights of a file, neuron by neuron with the bias last, into the layers of `net`."""
    numbers = torch.tensor([float(line) for line in path.read_text().split()], dtype=torch.float64)
    at = 0
    for layer in (net[0], net[2]):
        rows, columns = layer.weight.shape
        block = numbers[at : at + rows * (columns + 1)].reshape(rows, columns + 1)
        layer.weight.data, layer.bias.data = block[:, :-1].clone(), block[:, -1].clone()
        at += rows * (columns + 1)
    if at != len(numbers):
        sys.exit(f"{path}: {len(numbers)} weights where {at} are needed")


def flat(net):
    return torch.cat([torch.cat([layer.weight, layer.bias[:, None]], 1).reshape(-1) for layer in (net[0], net[2])]).detach()


def check_same(folder, name, rule, make):
    x, y = (torch.from_numpy(part) for part in rows(folder / f"{name}.data", numpy.float64))
    nets = [
        torch.nn.Sequential(torch.nn.Linear(x.shape[1], HIDDEN[name]), torch.nn.Tanh(), torch.nn.Linear(HIDDEN[name], y.shape[1])).double()
        for _ in range(2)
    ]
    load_weights(nets[0], folder / f"{name}.weights")
    load_weights(nets[1], folder / f"{name}.{rule}100")
    optimizer = make(nets[0].parameters())
    for _ in range(100):
        optimizer.zero_grad()
        torch.nn.functional.mse_loss(nets[0](x), y).backward()
        optimizer.step()
    optimizer.zero_grad()
    theirs, ours = flat(nets[0]), flat(nets[1])
    # A saturated neuron has a gradient below rounding: zero in one tanh, 1e-17 with either sign in another, and a rule that
    # looks at the sign alone moves its weights, which no output shows.
    torch.nn.functional.mse_loss(nets[0](x), y).backward()
    slopes = torch.cat([torch.cat([layer.weight.grad, layer.bias.grad[:, None]], 1).reshape(-1) for layer in (nets[0][0], nets[0][2])])
    felt = slopes.abs() > 1e-12 * slopes.abs().max()
    worst = float(((theirs - ours).abs() / ours.abs().clamp(min=1e-3))[felt].max())
    errors = [float(torch.nn.functional.mse_loss(net(x), y)) for net in nets]
    print(
        f"{name}, {rule}, 100 epochs in f64: error ours {errors[1]:.9g}, PyTorch {errors[0]:.9g}; largest relative difference of a weight {worst:.1e} ({len(felt) - int(felt.sum())} of {len(felt)} weights left out: gradient below rounding)",
        file=sys.stderr,
    )
    return worst < 5e-6 and abs(errors[0] / errors[1] - 1.0) < 5e-6


def main():
    folder = pathlib.Path(sys.argv[1])
    makers = {
        "rprop": lambda p: torch.optim.Rprop(p, 0.07, (0.5, 1.2), (1e-6, 50.0)),
        "gd": lambda p: torch.optim.SGD(p, 0.05),
    }
    # All of them are told before any failure.
    same = [check_same(folder, name, rule, make) for name in HIDDEN for rule, make in makers.items()]
    for name, neurons in HIDDEN.items():
        inputs, targets = rows(folder / f"{name}.data", numpy.float32)
        print(f"torch rprop {name}\t{torch_epoch(inputs, targets, neurons) * 1e6:.4f}\tus/epoch")
        print(f"scikit-learn lbfgs {name}\t{sklearn_epoch(inputs, targets, neurons) * 1e6:.4f}\tus/epoch")
    if not all(same):
        sys.exit("PyTorch ends at other weights")


main()
