"""What the package lerobot itself makes of our datasets and of live frames.

scripts/lerobot-check.sh runs it: pytest does not collect it with the others, because lerobot needs Python 3.10, PyTorch and 8 GB.
"""

from __future__ import annotations

import socket
import subprocess
import time
from pathlib import Path
from typing import Any, Dict, List

import numpy as np
import pytest
import torch
from lerobot.datasets.compute_stats import compute_episode_stats
from lerobot.datasets.dataset_tools import merge_datasets
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from test_lerobot import FPS, OBSERVED, SEEDS, connected, grasp, gripd

from slipgrip.lerobot import FEATURES, LiveSlip, columns, convert, open_recording

__all__ = ["gripd"]
TASK = "hold the cup"
WHOLE = [f"observation.slip.{name}" for name in OBSERVED]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> List[Path]:
    folder = tmp_path_factory.mktemp("recordings")
    return [grasp(seed, folder / f"{seed}.npz") for seed in SEEDS]


def opened(root: Path, **options: Any) -> Any:
    """The dataset as LeRobot reads it from a folder; it asks no server where the folder is whole."""
    return LeRobotDataset("local/grasps", root=root, **options)


def test_it_reads_what_was_converted(files: List[Path], tmp_path: Path) -> None:
    info = convert(files, tmp_path / "out", fps=FPS, task=TASK, robot_type="two fingers")
    dataset = opened(tmp_path / "out")
    assert (dataset.num_episodes, dataset.num_frames, dataset.fps) == (2, info["total_frames"], FPS)
    assert dataset.meta.robot_type == "two fingers" and list(dataset.meta.tasks.index) == [TASK]
    wanted = [columns(*open_recording(file), FPS) for file in files]
    row = 0
    for episode, frames in enumerate(wanted):
        for frame in range(len(frames["active"])):
            item = dataset[row]
            assert (item["episode_index"], item["frame_index"], item["index"], item["task"]) == (episode, frame, row, TASK)
            assert item["timestamp"] == pytest.approx(frame / FPS, abs=1e-6)
            for name, values in frames.items():
                seen = item[f"observation.slip.{name}"]
                assert seen.dtype == torch.float32 and seen.item() == values[frame], (name, row)
            row += 1
    assert row == len(dataset) and sum(frames["active"].sum() for frames in wanted) > 0

    # One episode of two, and frames of the past beside the present one, as policies ask for them.
    second = opened(tmp_path / "out", episodes=[1], delta_timestamps={"observation.slip.force_n": [-1 / FPS, 0.0]})
    assert second.num_frames == len(wanted[1]["active"])
    assert second[5]["observation.slip.force_n"].flatten().tolist() == wanted[1]["force_n"][4:6].tolist()
    batch = next(iter(torch.utils.data.DataLoader(dataset, batch_size=8)))
    assert set(WHOLE) <= set(batch) and all(len(batch[name]) == 8 for name in WHOLE)


def test_its_statistics_are_ours(files: List[Path], tmp_path: Path) -> None:
    convert(files[:1], tmp_path / "out", fps=FPS, task=TASK)
    dataset = opened(tmp_path / "out")
    frames = {f"observation.slip.{name}": values for name, values in columns(*open_recording(files[0]), FPS).items()}
    for name, wanted in compute_episode_stats(frames, dataset.meta.features).items():
        ours, ordered = dataset.meta.stats[name], np.sort(frames[name])
        assert ours.keys() == wanted.keys(), name
        for kind, value in wanted.items():
            assert ours[kind].shape == value.shape
            if not kind.startswith("q"):
                assert ours[kind] == pytest.approx(value, rel=1e-5, abs=1e-5 * float(np.abs(ordered).max())), (name, kind)
                continue
            # Ours lies between two frames; it takes the end of one of 5,000 bins.
            place, bins = int(kind[1:]) / 100 * (len(ordered) - 1), np.ptp(ordered) / 2500
            low, high = ordered[int(place)] - bins, ordered[min(int(place) + 2, len(ordered) - 1)] + bins
            assert low <= ours[kind] <= high and low <= value <= high, (name, kind)


def test_it_merges_them(files: List[Path], tmp_path: Path) -> None:
    parts = []
    for number, file in enumerate(files):
        convert([file], tmp_path / str(number), fps=FPS, task=f"{TASK} {number}")
        parts.append(LeRobotDataset(f"local/{number}", root=tmp_path / str(number)))
    merged = merge_datasets(parts, "local/both", output_dir=tmp_path / "both")
    assert (merged.num_episodes, merged.num_frames) == (2, sum(part.num_frames for part in parts))
    last = opened(tmp_path / "both")[-1]
    assert last["task"] == f"{TASK} 1"


def test_it_goes_on_with_one_of_ours(files: List[Path], tmp_path: Path) -> None:
    info = convert(files[:1], tmp_path / "out", fps=FPS, task=TASK)
    dataset = LeRobotDataset.resume("local/grasps", root=tmp_path / "out")
    for _ in range(7):
        dataset.add_frame({**{name: np.ones(1, np.float32) for name in WHOLE}, "task": "another"})
    dataset.save_episode()
    dataset.finalize()
    again = opened(tmp_path / "out")
    assert (again.num_episodes, again.num_frames) == (2, info["total_frames"] + 7)
    assert again[-1]["task"] == "another" and again[-1]["observation.slip.active"] == 1.0


def test_live_frames_become_a_dataset(gripd: Path, tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    command = [str(gripd), "--port", "sim", "--listen", f"tcp:127.0.0.1:{port}", "--duration", "6"]
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    kept: List[Dict[str, Any]] = []
    with connected(lambda: LiveSlip(f"socket://127.0.0.1:{port}", list(FEATURES))) as live:
        dataset = LeRobotDataset.create("local/live", fps=FPS, features=live.features, root=tmp_path / "live", use_videos=False)
        try:
            while len(kept) < 20 * FPS:
                time.sleep(1 / FPS)
                kept.append(live.frame())
                dataset.add_frame({**kept[-1], "task": TASK})
        except ConnectionError:
            pass
    assert running.wait(30) in (0, 3)
    dataset.save_episode()
    dataset.finalize()
    read = opened(tmp_path / "live")
    assert len(read) == len(kept) > 2 * FPS and set(kept[0]) <= set(read.features)
    for number, frame in enumerate(kept):
        item = read[number]
        assert all(item[name].item() == values[0] for name, values in frame.items()), number
    assert any(frame["observation.slip.active"][0] for frame in kept)
