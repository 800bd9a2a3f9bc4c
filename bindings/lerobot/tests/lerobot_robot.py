"""The robot as LeRobot finds and drives it: its own SO-101 code on the simulated arm, gripd, a recorded dataset.

scripts/lerobot-check.sh runs it: pytest does not collect it with the others, because lerobot needs Python 3.12, PyTorch and 8 GB.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, List

import draccus
import numpy as np
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.robots import RobotConfig, make_robot_from_config
from lerobot.utils.feature_utils import build_dataset_frame, hw_to_dataset_features
from lerobot.utils.import_utils import register_third_party_plugins
from slip_servo.virtual import SETTINGS, free_port

FPS = 30


@dataclass
class Line:
    robot: RobotConfig


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Any]:
    rows, clients = free_port(), free_port()
    (tmp_path / "gripd.toml").write_text("allow_commands = true\n" + SETTINGS)
    gripd = [os.environ["GRIPD"], "--config", "gripd.toml", "--port", f"rows:tcp:127.0.0.1:{rows}", "--listen", f"tcp:127.0.0.1:{clients}"]
    running = [
        subprocess.Popen([sys.executable, "-m", "slip_servo.virtual", "--serve", str(tmp_path)]),
        subprocess.Popen(gripd, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL),
    ]
    register_third_party_plugins()
    given = {
        "type": "slipgrip", "port": tmp_path / "so101", "id": "virtual", "calibration_dir": tmp_path / "calibration",
        "sensor": tmp_path / "board", "rows": f"127.0.0.1:{rows}", "gripd": f"socket://127.0.0.1:{clients}", "num_read_retries": 20,
    }  # fmt: skip
    end = time.monotonic() + 60
    while not (tmp_path / "board").exists():
        assert time.monotonic() < end, "no board"
        time.sleep(0.1)
    made = make_robot_from_config(draccus.parse(Line, args=[f"--robot.{name}={value}" for name, value in given.items()]).robot)
    try:
        # Its writes have no second try: a busy computer may need one.
        for _ in range(5):
            try:
                made.connect()
                break
            except OSError as error:
                print("once more:", error)
                made.bus.port_handler.closePort()
        yield made
        made.disconnect()
    finally:
        for process in running:
            process.kill()
            process.wait()


def test_a_grasp_becomes_a_dataset(robot: Any, tmp_path: Path) -> None:
    """The jaw closes, the object slips when it is lifted, the limit rises, it is held; then the jaw opens."""
    features = {**hw_to_dataset_features(robot.observation_features, "observation"), **hw_to_dataset_features(robot.action_features, "action")}
    assert features["observation.state"]["names"][-5:] == ["slip.active", "slip.need_n", "slip.estimate_n", "slip.held", "slip.command_n"]
    dataset = LeRobotDataset.create("local/slip", fps=FPS, features=features, root=tmp_path / "out", use_videos=False)
    seen: List[Dict[str, Any]] = []
    for _ in range(7 * FPS):
        begin = time.monotonic()
        seen.append(robot.get_observation())
        goal = {**{name: value for name, value in seen[-1].items() if name.endswith(".pos")}, "gripper.pos": 0.0}
        sent = robot.send_action(goal)
        frames = {**build_dataset_frame(features, seen[-1], "observation"), **build_dataset_frame(features, sent, "action")}
        dataset.add_frame({**frames, "task": "hold it"})
        time.sleep(max(0.0, begin + 1 / FPS - time.monotonic()))
    assert any(frame["slip.active"] for frame in seen), "no slip"
    assert seen[-1]["slip.held"] == 1.0 and seen[-1]["slip.command_n"] > 5.0 and seen[-1]["gripper.pos"] == pytest.approx(40, abs=1)
    dataset.save_episode()
    dataset.finalize()
    read = LeRobotDataset("local/slip", root=tmp_path / "out")
    states = np.stack([read[number]["observation.state"].numpy() for number in range(len(read))])
    assert len(read) == len(seen)
    assert np.array_equal(states, np.array([[frame[name] for name in features["observation.state"]["names"]] for frame in seen], np.float32))

    robot.send_action({**goal, "gripper.pos": 100.0})
    end = time.monotonic() + 10
    while robot.get_observation()["gripper.pos"] < 95:
        assert time.monotonic() < end, "the jaw does not open"
