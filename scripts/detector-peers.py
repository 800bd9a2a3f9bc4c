#!/usr/bin/env python3
"""Detectors in the manner of published ones beside ours: the same recordings, channels, false alarms and rules of `gripctl score`.

usage: detector-peers.py GRIPCTL DATA [MOTION MOTION...]      (Python 3.9, numpy, torch; one thread)
  GRIPCTL   a release build of gripctl
  DATA      the folder of recordings (CONTRIBUTING.md, Data)
  MOTION    folders of a generator of slips under motion (work.csv and set/), each a robot of its own

No published weights: each network is trained here, on the recordings of all objects, stretches or robots but a third, and tested
on those. Its threshold is the lowest with no more false alarms than ours on calibration recordings: those of the other thirds, as
the networks that had not learned them judge them; under motion the work that ours is calibrated on. `hindsight` is the lowest
with no more false alarms than ours on the tested recordings, which nobody could know.
  pillar-gru  after github RedmondLabUCD/Incipient-Slip-Detection-PapillArray (arXiv 2307.04011): medians of 21 ms, 40 ms of rows a
              step, two dense layers, a GRU of 128, three dense layers, the mean of 5 networks
  fft-gru     after github thayral/tactile-slip-demo (Ayral, Aloui, Grossard, AIM 2023): power in dB up to 650 Hz of 26 ms each
              10 ms, four GRU layers of 64, layer normalisation
  fft-linear  logistic regression on the last five such spectra, the usual baseline
Other than published: AdamW through time, classes weighted alike, a bias from the first 40 ms, no rotated copies.
"""
import csv, pathlib, subprocess, sys, tempfile

import numpy as np
import torch

sys.dont_write_bytecode = True

from benchmark import head, rows, score  # noqa: E402

GUARD_S, RELEASE_S, CLIP, FOLDS = 0.06, 0.05, 64, 3


class Recording:
    """One recording: its label and the samples of its channels."""

    def __init__(self, name, group, kind, onset, t, x):
        self.name, self.group, self.kind, self.onset, self.t, self.x = name, group, kind, onset, t, x
        self.quiet_until = {"onset": (onset or 0.0) - GUARD_S, "steady": -np.inf, "rest": np.inf}[kind]


def columns_of(file):
    with open(file) as lines:
        names = lines.readline().strip().split(",")
        return names, np.loadtxt(lines, delimiter=",", ndmin=2)


def labels(folder):
    with open(folder / "labels.csv") as lines:
        rows = list(csv.DictReader(lines))
    return [(row["recording"], row["kind"], row["material"], float(row["onset_s"]) if row["onset_s"] else None) for row in rows]


def read(folder, group, columns, beside=""):
    """The recordings of a folder with the columns whose names begin so; `beside` reads the array that lies beside them."""
    found = []
    for name, kind, material, onset in labels(folder):
        names, values = columns_of(folder / f"{name}{beside}.csv")
        take = [i for i, column in enumerate(names) if column.startswith(columns)]
        found.append(Recording(name, group(material), kind, onset, values[:, 0], values[:, take]))
    return found


def stick_slip(source, folder):
    """A recording for each large drop of the force, with the stick time before it; that before a small one holds no slip."""
    signal = np.load(next(source.glob("*.npz")))
    t, x = signal["t_s"], signal["vibration"]
    _, drops = columns_of(source / "drops.csv")
    begin, rows = t[0], []
    for k, (onset, _, large) in enumerate(drops):
        end = onset + 0.5 if large else onset - 0.1
        inside = (t >= begin) & (t < end)
        if onset - 0.1 > begin + 0.3:
            np.savetxt(folder / f"d{k:03}.csv", np.c_[t[inside] - begin, x[inside]], "%.7g", ",", header="t_s,vibration", comments="")
            rows.append(f"d{k:03},{'onset' if large else 'rest'},stretch{8 * k // len(drops)},{f'{onset - begin:.4f}' if large else ''}")
        begin = onset + 0.4
    (folder / "labels.csv").write_text("recording,kind,material,onset_s\n" + "\n".join(rows) + "\n")


def pillar_steps(recording):
    t, x = recording.t, recording.x
    rate = (len(t) - 1) / (t[-1] - t[0])
    width, stack = 2 * round(0.0105 * rate - 0.5) + 1, max(1, round(0.04 * rate))
    if width > 1:
        padded = np.concatenate([np.repeat(x[:1], width - 1, 0), x])
        x = np.median(np.lib.stride_tricks.sliding_window_view(padded, width, 0), -1)
    steps = len(x) // stack
    x = x - x[:stack].mean(0)
    return t[stack - 1 : steps * stack : stack], x[: steps * stack].reshape(steps, -1)


def spectra(recording):
    t, x = recording.t, recording.x
    rate = (len(t) - 1) / (t[-1] - t[0])
    width = 1 << int(np.ceil(np.log2(0.0256 * rate)))
    ends = np.arange(width, len(t) + 1, max(1, round(0.01 * rate)))
    bins = min(width // 2, int(650 * width / rate)) + 1
    out = np.empty((len(ends), x.shape[1] * bins))
    for k, end in enumerate(ends):
        power = np.abs(np.fft.rfft(x[end - width : end] * np.hanning(width)[:, None], axis=0)[:bins]) ** 2
        out[k] = 10 * np.log10(power.T.reshape(-1) + 1e-30)
    return t[ends - 1], out


class PillarGru(torch.nn.Module):
    def __init__(self, inputs):
        super().__init__()
        dense = lambda a, b: [torch.nn.Linear(a, b), torch.nn.BatchNorm1d(b), torch.nn.ReLU()]
        self.project = torch.nn.Sequential(*dense(inputs, 1024), *dense(1024, 128))
        self.gru = torch.nn.GRU(128, 128, batch_first=True)
        self.predict = torch.nn.Sequential(*dense(128, 256), *dense(256, 128), torch.nn.Linear(128, 1), torch.nn.BatchNorm1d(1))

    def forward(self, x):
        y = self.project(x.flatten(0, 1)).view(*x.shape[:2], -1)
        return self.predict(self.gru(y)[0].flatten(0, 1)).view(x.shape[:2])


class FftGru(torch.nn.Module):
    def __init__(self, inputs):
        super().__init__()
        self.gru = torch.nn.GRU(inputs, 64, 4, batch_first=True, dropout=0.15)
        self.classify = torch.nn.Sequential(torch.nn.Dropout(0.1), torch.nn.LayerNorm(64), torch.nn.Linear(64, 1))

    def forward(self, x):
        return self.classify(self.gru(x)[0]).squeeze(-1)


class FftLinear(torch.nn.Module):
    def __init__(self, inputs):
        super().__init__()
        self.filter = torch.nn.Conv1d(inputs, 1, 5)

    def forward(self, x):
        first = x[:, :1].expand(-1, 4, -1)
        return self.filter(torch.cat([first, x], 1).transpose(1, 2)).squeeze(1)


# name: steps, network, how many, batches it learns and clips in each
PEERS = {
    "pillar-gru": (pillar_steps, PillarGru, 5, (80, 16)),
    "fft-gru": (spectra, FftGru, 1, (150, 48)),
    "fft-linear": (spectra, FftLinear, 1, (800, 48)),
}


def clips(steps, slip_s):
    """Padded clips of input, label and weight; the guard before an onset has none, what follows the slip is cut off."""
    xs, ys, ws, cut = [], [], [], []
    for recording, t, x in steps:
        begin = {"onset": recording.onset, "steady": t[0], "rest": np.inf}[recording.kind]
        shown = t < begin + slip_s
        cut.append((recording.quiet_until, begin, t[shown], x[shown]))
    longest = max(len(t) for _, _, t, _ in cut)
    length = -(-longest // -(-longest // CLIP))
    for quiet_until, begin, t, x in cut:
        slips = t >= begin
        weight = (t < quiet_until) | slips
        for at in range(0, len(t), length):
            pad = [(0, max(0, at + length - len(t)))]
            xs.append(np.pad(x[at : at + length], pad + [(0, 0)]))
            ys.append(np.pad(slips[at : at + length], pad))
            ws.append(np.pad(weight[at : at + length], pad))
    return [torch.tensor(np.array(a), dtype=torch.float32) for a in (xs, ys, ws)]


def train(network, learns, steps, slip_s, seed):
    """A trained network that gives the score of each step of a recording."""
    torch.manual_seed(seed)
    every = np.concatenate([x for _, _, x in steps])
    mean, scale = every.mean(0), every.std(0) + 1e-12
    x, y, w = clips([(recording, t, (x - mean) / scale) for recording, t, x in steps], slip_s)
    share = float((y * w).sum() / w.sum())
    w = w * torch.where(y > 0, 0.5 / share, 0.5 / (1 - share))
    net = network(x.shape[2])
    optimizer = torch.optim.AdamW(net.parameters(), 2e-3, weight_decay=1e-2)
    batches, size = learns
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, batches)
    for _ in range(batches):
        batch = torch.randperm(len(x))[:size]
        noisy = x[batch] * (1 + 0.1 * torch.randn(len(batch), 1, 1)) + 0.02 * torch.randn_like(x[batch])
        loss = torch.nn.functional.binary_cross_entropy_with_logits(net(noisy), y[batch], w[batch], reduction="sum")
        optimizer.zero_grad()
        (loss / w[batch].sum().clamp(min=1)).backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        schedule.step()
    net.eval()

    @torch.no_grad()
    def judge(x):
        return torch.sigmoid(net(torch.tensor((x - mean) / scale, dtype=torch.float32)[None])[0].double()).numpy()

    return judge


def alarms(t, score, threshold):
    """Begin and end of the alarms; those less than the release apart are one."""
    ends = np.append(t[1:], t[-1])
    spans = []
    for k in np.flatnonzero(score > threshold):
        if spans and t[k] - spans[-1][1] < RELEASE_S:
            spans[-1][1] = ends[k]
        else:
            spans.append([t[k], ends[k]])
    return spans


def false_alarms(scored, threshold):
    return sum(begin < recording.quiet_until for recording, t, score in scored for begin, _ in alarms(t, score, threshold))


def lowest_threshold(scored, allowed):
    """The lowest threshold with no more false alarms than allowed."""
    quiet = np.unique(np.concatenate([score[t < recording.quiet_until] for recording, t, score in scored]))[::-1]
    # One by one from above: far below, alarms grow together, and there are few again.
    lowest = quiet[0]
    for threshold in quiet:
        if false_alarms(scored, threshold) > allowed:
            break
        lowest = threshold
    return lowest


def judged(gripctl, folder, detector, *more):
    lines, error = score(gripctl, folder, [detector], *more)
    return lines if lines is not None else sys.exit(f"{folder}, {detector}: {error}")


def judged_own(gripctl, source, spans):
    """What `gripctl score` shows of these alarms, recording: spans."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for file in source.iterdir():
            (folder / file.name).symlink_to(file.resolve())
        lines = (f"{recording},{begin:.6f},{end:.6f}\n" for recording, alarms in spans.items() for begin, end in alarms)
        (folder / "alarms.csv").write_text("recording,begin_s,end_s\n" + "".join(lines))
        return judged(gripctl, folder, "own")


def alarms_of(lines):
    """The alarms of each recording, and how many of them are false."""
    first = [line for line in lines if line.get("slip") == 1]
    spans = {one["recording"]: [(a["t_s"], a["end_s"] or one["length_s"]) for a in one["alarms_at"]] for one in first}
    return spans, {one["recording"]: sum(a["is_false"] for a in one["alarms_at"]) for one in first}


def compare(gripctl, title, folder, recordings, ours, peers, slip_s=np.inf, work=None):
    """The table of a folder. `ours`: its name and result; `work`: for each group a recording to calibrate on and our false alarms there."""
    head(title)
    name, lines = ours
    print(rows(lines, lines[-1]["detector"], f"ours, {name}"), flush=True)
    _, false_of_ours = alarms_of(lines)
    groups = sorted({recording.group for recording in recordings})
    fold_of = {group: n % FOLDS for n, group in enumerate(groups)}
    for peer in peers:
        cut, network, count, learns = PEERS[peer]
        steps = [(recording, *cut(recording)) for recording in recordings]
        nets, scored, thresholds = {}, [], {}
        for fold in sorted(set(fold_of.values())):
            others = [step for step in steps if fold_of[step[0].group] != fold]
            nets[fold] = [train(network, learns, others, slip_s, seed) for seed in range(count)]
            tested = (step for step in steps if fold_of[step[0].group] == fold)
            scored += [(recording, t, np.mean([net(x) for net in nets[fold]], 0)) for recording, t, x in tested]
        for group, fold in fold_of.items():
            if work:
                recording, allowed = work[group]
                t, x = cut(recording)
                calibration = [(recording, t, np.mean([net(x) for net in nets[fold]], 0))]
            else:
                calibration = [one for one in scored if fold_of[one[0].group] != fold]
                allowed = sum(false_of_ours[recording.name] for recording, _, _ in calibration)
            thresholds[group] = lowest_threshold(calibration, allowed)
        best = lowest_threshold(scored, sum(false_of_ours.values()))
        for name, threshold in ((peer, thresholds), (f"{peer}, hindsight", dict.fromkeys(groups, best))):
            spans = {recording.name: alarms(t, score, threshold[recording.group]) for recording, t, score in scored}
            print(rows(judged_own(gripctl, folder, spans), "own", name), flush=True)


def robots(gripctl, folders, scratch):
    """Robots of the generator in one folder: their recordings, ours calibrated on the work of each, and that work."""
    columns, every, spans, work, text = ("stylus", "vibration", "reference"), [], {}, {}, []
    joined = scratch / "joined"
    joined.mkdir()
    for folder in folders:
        more = ("--calibration", scratch / f"{folder.name}.toml")
        subprocess.run([gripctl, "calibrate", folder / "work.csv", "-o", more[1]], check=True, capture_output=True)
        alone = scratch / folder.name
        alone.mkdir()
        (alone / "work.csv").symlink_to((folder / "work.csv").resolve())
        (alone / "labels.csv").write_text("recording,kind,material,onset_s\nwork,rest,work,\n")
        allowed = sum(alarms_of(judged(gripctl, alone, "default", *more))[1].values())
        work[folder.name] = read(alone, lambda _: folder.name, columns)[0], allowed
        for recording in read(folder / "set", lambda _: folder.name, columns):
            recording.name = f"{folder.name}_{recording.name}"
            # Alarms are given: to judge them takes no more than the times.
            times = np.c_[recording.t, recording.x[:, 0]][::10]
            np.savetxt(joined / f"{recording.name}.csv", times, "%.7g", ",", header="t_s,vibration", comments="")
            text.append(f"{recording.name},{recording.kind},{folder.name},{'' if recording.onset is None else recording.onset}\n")
            every.append(recording)
        ours, _ = alarms_of(judged(gripctl, folder / "set", "default", *more))
        spans |= {f"{folder.name}_{name}": of for name, of in ours.items()}
    (joined / "labels.csv").write_text("recording,kind,material,onset_s\n" + "".join(text))
    return joined, every, ("default", judged_own(gripctl, joined, spans)), work


def main():
    if len(sys.argv) < 3 or len(sys.argv) == 4:
        sys.exit(__doc__)
    torch.set_num_threads(1)
    gripctl, data = sys.argv[1], pathlib.Path(sys.argv[2])
    slide, taxels = data / "biotac_slide", data / "taxels_dos"

    def table(title, folder, recordings, ours, peers, **more):
        compare(gripctl, title, folder, recordings, (ours, judged(gripctl, folder, ours)), peers, **more)

    table("taxels_dos, 24 taxels", taxels, read(taxels, lambda of: of.split("_")[-1], "pressure"), "pressure", ["pillar-gru"])
    table("biotac_slide, 19 electrodes", slide, read(slide, str, "ele", "_electrodes"), "pressure", ["pillar-gru"], slip_s=1.0)
    table("biotac_slide, vibration", slide, read(slide, str, "vibration"), "default", PEERS, slip_s=1.0)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        stick_slip(data / "stickslip", folder)
        table("stickslip, force", folder, read(folder, str, "vibration"), "default", PEERS, slip_s=0.1)
    if folders := [pathlib.Path(folder) for folder in sys.argv[3:]]:
        with tempfile.TemporaryDirectory() as name:
            joined, recordings, ours, work = robots(gripctl, folders, pathlib.Path(name))
            title, peers = "slips under motion, stylus and reference", ["fft-gru", "fft-linear"]
            compare(gripctl, title, joined, recordings, ours, peers, slip_s=1.0, work=work)


main()
