"""Recordings as a LeRobot dataset (v3.0), and the same features of a running gripd: ``observation.slip.*``.

    python -m slipgrip.lerobot run.mcap run-2.mcap out/ --fps 30 --task "hold the cup"

``pip install slipgrip[lerobot]`` brings pyarrow, which writes the files; LeRobot itself is not needed.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import threading
from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple, Type, Union

import numpy as np

from . import _frames
from ._core import Detection, Recording, detect, read, trace
from ._frames import CHANNELS, FEATURES, Columns, Frame, SlipState, columns

if TYPE_CHECKING:
    from grip_link import Daemon

__all__ = ["FEATURES", "LiveSlip", "columns", "convert", "dataset_features", "open_recording"]

VERSION = "v3.0"
PREFIX = "observation.slip."
DATA = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
EPISODES = "meta/episodes/chunk-000/file-000.parquet"
CHUNK = 1000
"""Files in a folder, as LeRobot has them. Each episode has a file."""
INDICES = ("frame_index", "episode_index", "index", "task_index")
QUANTILES = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}

_Path = Union[str, "PathLike[str]"]


def dataset_features(names: Sequence[str]) -> Dict[str, Dict[str, Any]]:
    """``features`` of ``LeRobotDataset.create`` for these names of ``FEATURES``."""
    kept = _frames.chosen(list(FEATURES), names)
    labels = {name: "command_n" if name == "action" else name for name in kept}
    return {_key(name): {"dtype": "float32", "shape": (1,), "names": [label]} for name, label in labels.items()}


def open_recording(
    path: _Path, *, rate_hz: Optional[float] = None, channels: Optional[Mapping[str, str]] = None
) -> Tuple[Recording, Detection]:
    """A recording and its slips: an .mcap of gripd with the settings and the model inside, others as ``detect`` has them."""
    recording = read(path, rate_hz=rate_hz, channels=channels)
    if str(path).lower().endswith(".mcap") and rate_hz is None and channels is None:
        try:
            return recording, trace(path)
        except ValueError:
            # Of another program: `read` has found a sensor in it.
            pass
    return recording, detect(recording)


def convert(
    recordings: Sequence[_Path],
    out: _Path,
    *,
    fps: int,
    task: str,
    features: Optional[Sequence[str]] = None,
    robot_type: Optional[str] = None,
    rate_hz: Optional[float] = None,
    channels: Optional[Mapping[str, str]] = None,
) -> Dict[str, Any]:
    """Writes a dataset with an episode for each recording to the folder ``out``, which must not be there or be empty.

    ``columns`` states what a frame holds. ``features`` are names of ``FEATURES``: all that the recordings have, if not
    given. Gives the contents of ``meta/info.json``.
    Raises ValueError, OSError, or ImportError without pyarrow.
    """
    if isinstance(fps, bool) or not isinstance(fps, int) or fps < 1:
        raise ValueError(f"fps = {fps!r}: a whole number from 1 on is needed")
    if not task.strip():
        raise ValueError("task: a sentence is needed")
    if not recordings:
        raise ValueError("recordings: there are none")
    out = Path(out)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise FileExistsError(f"{out}: it is there and not empty")
    writer = _Writer(out, fps, task)
    episodes = []
    for path in recordings:
        try:
            episodes.append(columns(*open_recording(path, rate_hz=rate_hz, channels=channels), fps, features))
        except ValueError as error:
            text = str(error)
            raise ValueError(text if str(path) in text else f"{path}: {text}") from error
        if list(episodes[-1]) != list(episodes[0]):
            raise ValueError(
                f"{path}: it has {', '.join(episodes[-1])}, but {recordings[0]} has {', '.join(episodes[0])}; "
                "choose features that all have"
            )
    return writer.write(episodes, robot_type)


def _key(name: str) -> str:
    return name if name == "action" else PREFIX + name


class _Writer:
    """Columns of episodes in, the files of a dataset out."""

    def __init__(self, out: Path, fps: int, task: str) -> None:
        try:
            import pyarrow
            import pyarrow.parquet
        except ImportError as error:
            raise ImportError("pyarrow writes the dataset: pip install slipgrip[lerobot]") from error
        self.arrow, self.parquet = pyarrow, pyarrow.parquet
        self.out, self.fps, self.task = out, fps, task

    def write(self, episodes: List[Columns], robot_type: Optional[str]) -> Dict[str, Any]:
        first = 0
        tables, rows = [], []
        for number, episode in enumerate(episodes):
            table = self._table(number, episode, first)
            place = {"chunk_index": number // CHUNK, "file_index": number % CHUNK}
            self._save(table, DATA.format(**place))
            length = len(table["index"])
            row = {"episode_index": number, "tasks": [self.task], "length": length}
            row.update({f"data/{name}": value for name, value in place.items()})
            row.update({"dataset_from_index": first, "dataset_to_index": first + length})
            row.update({"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0})
            for name, values in table.items():
                row.update({f"stats/{name}/{kind}": value for kind, value in _statistics(values).items()})
            rows.append(row)
            tables.append(table)
            first += length
        self._save({name: [row[name] for row in rows] for name in rows[0]}, EPISODES)
        self._save_tasks()
        merged = {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}
        self._json({name: _statistics(values) for name, values in merged.items()}, "meta/stats.json")
        info = self._info(list(episodes[0]), len(episodes), first, robot_type)
        # Last: without it LeRobot takes the folder for none of its own.
        self._json(info, "meta/info.json")
        return info

    def _table(self, number: int, episode: Columns, first: int) -> Dict[str, Any]:
        table: Dict[str, Any] = {_key(name): values for name, values in episode.items()}
        frame = np.arange(len(next(iter(table.values()))), dtype=np.int64)
        table["timestamp"] = (frame / self.fps).astype(np.float32)
        table.update(dict(zip(INDICES, (frame, np.full_like(frame, number), frame + first, np.zeros_like(frame)))))
        return table

    def _info(self, names: List[str], episodes: int, frames: int, robot_type: Optional[str]) -> Dict[str, Any]:
        features = dataset_features(names)
        features["timestamp"] = {"dtype": "float32", "shape": (1,), "names": None}
        features.update({name: {"dtype": "int64", "shape": (1,), "names": None} for name in INDICES})
        return {
            "codebase_version": VERSION,
            "robot_type": robot_type,
            "total_episodes": episodes,
            "total_frames": frames,
            "total_tasks": 1,
            "chunks_size": CHUNK,
            "data_files_size_in_mb": 100,
            "video_files_size_in_mb": 200,
            "fps": self.fps,
            "splits": {"train": f"0:{episodes}"},
            "data_path": DATA,
            "video_path": None,
            "features": features,
        }

    def _save_tasks(self) -> None:
        """The task as the index of a table of pandas, which LeRobot reads it with."""
        names = ["task_index", "task"]
        kinds = [("int64", "int64"), ("unicode", "object")]
        about = [
            {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": stored, "metadata": None}
            for name, (kind, stored) in zip(names, kinds)
        ]
        index = {"name": None, "field_name": None, "pandas_type": "unicode", "numpy_type": "object", "metadata": None}
        pandas = {"index_columns": ["task"], "column_indexes": [index], "columns": about, "pandas_version": "2.0.0"}
        table = self.arrow.table({"task_index": np.zeros(1, np.int64), "task": [self.task]})
        self._write(table.replace_schema_metadata({"pandas": json.dumps(pandas)}), "meta/tasks.parquet")

    def _save(self, table: Mapping[str, Any], name: str) -> None:
        self._write(self.arrow.table(dict(table)), name)

    def _write(self, table: Any, name: str) -> None:
        file = self.out / name
        file.parent.mkdir(parents=True, exist_ok=True)
        self.parquet.write_table(table, file)

    def _json(self, value: Mapping[str, Any], name: str) -> None:
        text = json.dumps(value, indent=4, ensure_ascii=False, allow_nan=False)
        (self.out / name).write_text(text + "\n", encoding="utf-8")


def _statistics(values: Any) -> Dict[str, List[Any]]:
    """What LeRobot keeps of a feature, each of shape (1,)."""
    exact = values.astype(np.float64)
    made = {"min": exact.min(), "max": exact.max(), "mean": exact.mean(), "std": exact.std()}
    made.update({name: np.quantile(exact, share) for name, share in QUANTILES.items()})
    return {**{name: [float(value)] for name, value in made.items()}, "count": [len(exact)]}


class LiveSlip:
    """The features of a running gripd, frame by frame, for a control loop or ``LeRobotDataset.add_frame``.

    A thread receives what gripd sends. ``frame()`` gives arrays of shape (1,) by the names of the dataset: what was
    received last, and in ``active`` any slip since the frame before. ``features`` are names of ``FEATURES``, all but
    ``action`` if not given; what the gripper has not stays 0. Needs the package grip_link of ``protocol/python``.
    """

    def __init__(self, url: Optional[str] = None, features: Optional[Sequence[str]] = None) -> None:
        """Connects; ``url`` is ``socket://127.0.0.1:7747`` if not given. Raises OSError where no gripd answers."""
        observed = [name for name in FEATURES if name != "action"]
        self.names = _frames.chosen(list(FEATURES), observed if features is None else features)
        self._daemon = _connect(url, rows=any(name in CHANNELS for name in self.names))
        self._slips = SlipState()
        self._readings = dict.fromkeys(("statistic", "need_n", "held", "command_n", "action", *CHANNELS), 0.0)
        self._error: Optional[Exception] = None
        self._lock, self._ended = threading.Lock(), threading.Event()
        try:
            # The last slips too: E_sc and estimate are known where this connects late.
            for message in self._daemon.query():
                self._take(message)
        except BaseException:
            self._daemon.close()
            raise
        # What has ended by now belongs to no frame.
        self._slips.frame()
        self._thread = threading.Thread(target=self._receive, name="slipgrip", daemon=True)
        self._thread.start()

    @property
    def features(self) -> Dict[str, Dict[str, Any]]:
        """``features`` of ``LeRobotDataset.create`` for these frames."""
        return dataset_features(self.names)

    def frame(self) -> Frame:
        """The frame that ends now. Raises ConnectionError where gripd has gone, ValueError after ``close``."""
        with self._lock:
            if self._error is not None:
                raise ConnectionError(f"gripd has gone: {self._error}") from self._error
            if self._ended.is_set():
                raise ValueError("the connection was closed")
            values = {**self._slips.frame(), **self._readings}
        return {_key(name): np.array([values[name]], np.float32) for name in self.names}

    def close(self) -> None:
        """Ends the connection."""
        self._ended.set()
        self._thread.join()
        self._daemon.close()

    def __enter__(self) -> LiveSlip:
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], value: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None:
        self.close()

    def _receive(self) -> None:
        try:
            while not self._ended.is_set():
                for message in self._daemon.messages(0.1):
                    with self._lock:
                        self._take(message)
        except Exception as error:
            self._error = error

    def _take(self, message: Any) -> None:
        from grip_link.messages.daemon import Phase, Rows, RowSet, Scene, Slip, State

        if isinstance(message, Slip):
            kind = "slip_end" if message.phase is Phase.ENDED else "slip"
            values = (message.confidence, message.speed, message.esc, message.estimate)
            self._slips.event({"type": kind, **dict(zip(_frames.OF_SLIPS, values))})
        elif isinstance(message, State):
            self._reading("statistic", min(message.statistic, _frames.MOST))
            self._reading("command_n", message.command)
            self._reading("action", message.command)
            self._reading("need_n", math.nan if message.need is None else message.need)
            self._readings["held"] = float(message.scene is Scene.HOLDING)
            # Also of a slip that had begun before this connection.
            self._slips.seen(message.scene is Scene.SLIPPING)
        elif isinstance(message, Rows):
            for row in message:
                for name, channel in zip(CHANNELS, (RowSet.NORMAL_FORCE, RowSet.TRAVEL)):
                    self._reading(name, row.values.get(channel, math.nan))

    def _reading(self, name: str, value: float) -> None:
        if math.isfinite(value):
            self._readings[name] = value


def _connect(url: Optional[str], rows: bool) -> Daemon:
    try:
        from grip_link import Daemon
        from grip_link.daemon import DEFAULT_URL
        from grip_link.messages.daemon import Subscribe, Topics
    except ImportError as error:
        raise ImportError("grip_link speaks with gripd: pip install protocol/python in a checkout") from error
    wanted = Subscribe(topics=Topics.SLIP | Topics.STATE, every_nth=int(rows), state_ms=5)
    return Daemon.open(DEFAULT_URL if url is None else url, wanted)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Returns 0, or 2 with a sentence where something is wrong."""
    parser = argparse.ArgumentParser(prog="python -m slipgrip.lerobot", description="recordings as a LeRobot dataset")
    parser.add_argument("recordings", nargs="+", help="what slipgrip.read takes; each is an episode")
    parser.add_argument("out", help="folder of the dataset")
    parser.add_argument("--fps", type=int, default=30, help="frames a second (30)")
    parser.add_argument("--task", required=True, help="what is done, as a sentence")
    parser.add_argument("--features", metavar="NAME,NAME", help=f"some of {', '.join(FEATURES)}")
    parser.add_argument("--robot-type", metavar="NAME")
    parser.add_argument("--rate", type=float, metavar="HZ", help="rows a second, where the files have no times")
    parser.add_argument("--map", action="append", metavar="OURS=NAME", help="which of their signals is which of ours")
    given = parser.parse_args(arguments)
    pairs = [pair.partition("=") for pair in given.map or []]
    if any(not (ours and theirs) for ours, _, theirs in pairs):
        parser.error("--map: OURS=NAME is needed")
    try:
        info = convert(
            given.recordings,
            given.out,
            fps=given.fps,
            task=given.task,
            features=given.features.split(",") if given.features else None,
            robot_type=given.robot_type,
            rate_hz=given.rate,
            channels={ours: theirs for ours, _, theirs in pairs} or None,
        )
    except (ValueError, OSError, ImportError) as error:
        print(f"slipgrip.lerobot: {error}", file=sys.stderr)
        return 2
    print(f"{given.out}: {info['total_episodes']} episodes, {info['total_frames']} frames, {', '.join(info['features'])}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
