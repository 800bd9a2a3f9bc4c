"""What the tests stand on: gripctl (GRIPCTL) and the recordings (GRIP_DATA, or ../shared/data beside the checkout)."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any, Callable, Dict, List

import pytest

ROOT = Path(__file__).resolve().parents[3]
Replay = Callable[..., List[Dict[str, Any]]]


@pytest.fixture(scope="session")
def gripctl() -> str:
    program = os.environ.get("GRIPCTL")
    assert program, "GRIPCTL names a built gripctl"
    return program


@pytest.fixture(scope="session")
def gripctl_replay(gripctl: str) -> Replay:
    """The events that `gripctl replay --json` prints of a file."""

    def run(file: Path, *options: str) -> List[Dict[str, Any]]:
        command = [gripctl, "replay", str(file), "--json", *options]
        ran = subprocess.run(command, capture_output=True, text=True, check=False)
        assert ran.returncode in (0, 3), ran.stderr
        lines = [json.loads(line) for line in ran.stdout.splitlines()]
        return [line for line in lines if line["type"] != "summary"]

    return run


@pytest.fixture(scope="session")
def data() -> Path:
    folder = Path(os.environ.get("GRIP_DATA", ROOT / "../shared/data"))
    if not folder.is_dir() and "data" in os.environ.get("GRIP_ALLOW_MISSING", "").split(","):
        pytest.skip("the recordings are left out (GRIP_ALLOW_MISSING)")
    assert folder.is_dir(), f"no recordings in {folder} (GRIP_DATA names them)"
    return folder
