"""The simulator as an environment with ``reset`` and ``step``, as gymnasium has them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

from ._core import Grasp
from ._types import Truth

if TYPE_CHECKING:
    Base = object
else:
    try:
        from gymnasium import Env as Base
    except ImportError:
        Base = object

Rows = npt.NDArray[np.float32]

CHUNK_S = 1e-3
"""Time of a step, unless ``rows`` says otherwise (s)."""
UNSEEN = 1e9
"""Readings stay within this; a channel without a reading shows 0."""


class GraspEnv(Base):
    """Close, lift and hold a simulated object with just enough force.

    An action is the force to aim at (N): a number, or an array of shape ``(1,)``, from 0 to ``force_max_n``. An
    observation has shape ``(rows, channels)``, ``float32``, in the units of a recording (``channels`` names them).
    A step takes ``rows / rate_hz`` seconds. The reward of a step is the time (s) in which the lifted object is held,
    less a tenth of that for each newton above the needed force; a drop or a crush costs ``duration_s`` and ends the
    episode. After ``duration_s`` it is truncated. ``info`` is the truth of the simulator (:class:`Truth`).

    With gymnasium installed this is a ``gymnasium.Env`` with spaces; it works without.
    """

    metadata: Dict[str, Any] = {"render_modes": []}
    render_mode: Optional[str] = None

    def __init__(
        self, scene: str = "default", *, rows: Optional[int] = None, duration_s: float = 4.0, seed: Optional[int] = None
    ) -> None:
        """``scene`` is the name of a built-in scene, a file ending in ``.toml``, or the text of one."""
        if not (np.isfinite(duration_s) and duration_s > 0):
            raise ValueError(f"duration_s = {duration_s}: a finite number of more than 0 is needed")
        self._scene, self._seed, self.duration_s = scene, seed, float(duration_s)
        self._grasp = Grasp(scene, seed)
        self.rate_hz: float = self._grasp.rate_hz
        self.channels: list[str] = self._grasp.channels
        self.force_max_n: float = self._grasp.force_max_n
        self.rows: int = max(1, round(CHUNK_S * self.rate_hz)) if rows is None else int(rows)
        if not 1 <= self.rows <= 200_000:
            raise ValueError(f"rows = {rows}: 1 to 200000 are possible")
        self._over = False
        self._spaces()

    def _spaces(self) -> None:
        try:
            from gymnasium import spaces
        except ImportError:
            return
        shape = (self.rows, len(self.channels))
        self.action_space = spaces.Box(0.0, self.force_max_n, (1,), np.float32)
        self.observation_space = spaces.Box(-UNSEEN, UNSEEN, shape, np.float32)

    def reset(self, *, seed: Optional[int] = None, options: Optional[Dict[str, Any]] = None) -> Tuple[Rows, Truth]:
        """Open fingers over an object; another ``seed`` draws another object. ``options`` may name a ``scene``."""
        parent = super()
        if hasattr(parent, "reset"):
            parent.reset(seed=seed)
        if seed is not None:
            self._seed = seed
        self._scene = (options or {}).get("scene", self._scene)
        self._grasp = Grasp(self._scene, self._seed)
        self._over = False
        return self._observe(0.0), self._grasp.truth()

    def step(self, action: Union[float, npt.ArrayLike]) -> Tuple[Rows, float, bool, bool, Truth]:
        """Aims at a force (N) for one step: observation, reward, terminated, truncated, truth."""
        if self._over:
            raise ValueError("the episode is over: call reset()")
        force = np.asarray(action, dtype=np.float64)
        if force.size != 1:
            raise ValueError(f"action: one force is needed, not an array of shape {force.shape}")
        observation = self._observe(float(force.reshape(())))
        truth = self._grasp.truth()
        reward, terminated = self._judge(truth)
        truncated = not terminated and truth["time_s"] >= self.duration_s
        self._over = terminated or truncated
        return observation, reward, terminated, truncated, truth

    def _judge(self, truth: Truth) -> Tuple[float, bool]:
        if truth["dropped"] or truth["crushed"]:
            return -self.duration_s, True
        if not truth["lifted"]:
            return 0.0, False
        excess = max(0.0, truth["applied_n"] - truth["needed_n"])
        return self.rows / self.rate_hz * (1.0 - 0.1 * excess), False

    def _observe(self, force_n: float) -> Rows:
        return np.nan_to_num(self._grasp.step(force_n, self.rows))
