"""A seed in, an object to grasp out: shape, mass, friction, surface, and what happens to it while it is held."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

CLASSES = ("box", "cylinder", "round", "mesh", "off_centre", "cup", "pulled", "handed_over")
GRAVITY = 9.81


@dataclass(frozen=True)
class Pull:
    """A force along the slip (down), in seconds from the lift on; a person who takes the object keeps on pulling."""

    force_n: float
    start_s: float
    rise_s: float
    hold_s: float

    def at(self, t_s: float) -> float:
        """The force [N] at so many seconds from the lift."""
        since = t_s - self.start_s
        return self.force_n * max(0.0, min(since / self.rise_s, 1.0, (2.0 * self.rise_s + self.hold_s - since) / self.rise_s))


@dataclass(frozen=True)
class Item:
    """An object."""

    kind: str
    shape: str
    seed: tuple[int, int]
    xml: str
    """The geoms of its body in MJCF, centre at the origin."""
    assets: str
    mass_kg: float
    """All of it."""
    friction: float
    roughness_um: float
    """Ra of its surface."""
    half_height_m: float
    offset_m: float = 0.0
    """How far beside its centre it is gripped."""
    sway_m: float = 0.0
    """How far the hand moves sideways while it holds."""
    pull: Pull | None = None
    release_s: float | None = None
    """When a client commands the release [s from the lift]."""

    @property
    def weight_force_n(self) -> float:
        """The grip force that its weight at rest needs without torque: m g / (2 mu) [N]."""
        return self.mass_kg * GRAVITY / (2.0 * self.friction)


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def _geom(shape: str, size: tuple[float, ...], mass_kg: float, more: str = "", role: str = "item") -> str:
    return f'<geom class="{role}" type="{shape}" size="{" ".join(f"{s:.5f}" for s in size)}" mass="{mass_kg:.6f}" {more}/>'


def _prism(sides: int, flat_m: float, half_m: float, taper: float) -> str:
    """Corners of a prism with two faces across x, ``flat_m`` from the axis; ``taper`` widens the top and narrows the bottom by this share."""
    corner = flat_m / math.cos(math.pi / sides)
    turns = [(2 * k + 1) * math.pi / sides for k in range(sides)]
    return " ".join(
        f"{corner * w * math.cos(a):.6f} {corner * w * math.sin(a):.6f} {z:.6f}"
        for z, w in ((-half_m, 1.0 - taper), (half_m, 1.0 + taper))
        for a in turns
    )


def _mesh(rng: np.random.Generator, mass_kg: float) -> tuple[str, str, str, float]:
    """A hexagonal prism, or a frustum of sixteen sides: name, asset, geom, half of the height."""
    half = rng.uniform(0.03, 0.045)
    if rng.random() < 0.5:
        name, corners = "hexagon", _prism(6, rng.uniform(0.015, 0.022), half, 0.0)
    else:
        name, corners = "frustum", _prism(16, rng.uniform(0.018, 0.024), half, rng.uniform(0.02, 0.05))
    asset = f'<mesh name="part" vertex="{corners}"/>'
    return name, asset, f'<geom class="item" type="mesh" mesh="part" mass="{mass_kg:.6f}"/>', half


def _cup(mass_kg: float) -> tuple[str, float]:
    """Two walls and what is between them; a third of the mass lies still, the rest swings sideways at 3 Hz, damped by 0.05, as a liquid does."""
    half, inner, wall = 0.04, 0.02, 0.0015
    swinging, omega = mass_kg * 2.0 / 3.0, 2.0 * math.pi * 3.0
    walls = "".join(_geom("box", (wall, inner, half), mass_kg / 9.0, f'pos="{x:.4f} 0 0"') for x in (-inner - wall, inner + wall))
    bottom = _geom("box", (inner, inner, wall), mass_kg / 9.0, f'pos="0 0 {wall - half:.4f}"', "rest")
    spring = f'stiffness="{swinging * omega**2:.4f}" damping="{0.1 * swinging * omega:.5f}" limited="false"'
    fill = (
        f'<body><joint type="slide" axis="1 0 0" {spring}/><joint type="slide" axis="0 1 0" {spring}/>'
        f'<geom class="fill" size="0.014" mass="{swinging:.6f}"/></body>'
    )
    return walls + bottom + fill, half


def draw(kind: str, seed: int, number: int) -> Item:
    """The ``number``-th object of a seed, of the class ``kind``."""
    rng = np.random.default_rng([seed, number])
    mass, friction = _log_uniform(rng, 0.15, 1.0), _log_uniform(rng, 0.25, 0.7)
    base = {"kind": kind, "seed": (seed, number), "mass_kg": mass, "friction": friction, "roughness_um": _log_uniform(rng, 0.4, 3.0)}
    assets = ""
    more: dict[str, object] = {}
    shape = kind
    if kind in ("pulled", "handed_over"):
        shape = "box" if rng.random() < 0.5 else "cylinder"
    if shape == "box":
        half = rng.uniform(0.025, 0.04)
        xml = _geom("box", (rng.uniform(0.012, 0.02), rng.uniform(0.012, 0.025), half), mass)
    elif shape == "cylinder":
        half = rng.uniform(0.03, 0.045)
        xml = _geom("cylinder", (rng.uniform(0.015, 0.022), half), mass)
    elif shape == "round":
        radius, length = rng.uniform(0.018, 0.024), rng.uniform(0.01, 0.025)
        if rng.random() < 0.5:
            shape, half, xml = "sphere", radius, _geom("sphere", (radius,), mass)
        else:
            shape, half, xml = "capsule", radius + length, _geom("capsule", (radius, length), mass)
    elif shape == "mesh":
        shape, assets, xml, half = _mesh(rng, mass)
    elif shape == "off_centre":
        shape, half = "bar", 0.02
        xml = _geom("box", (0.012, rng.uniform(0.04, 0.07), half), mass)
        more["offset_m"] = rng.uniform(0.006, 0.015)
    else:
        xml, half = _cup(mass)
        more["sway_m"] = 0.04
    weight = mass * GRAVITY
    if kind == "pulled":
        more["pull"] = Pull(weight * rng.uniform(0.3, 1.0), 1.3, rng.uniform(0.1, 0.3), 0.4)
    if kind == "handed_over":
        more["pull"] = Pull(weight * rng.uniform(0.3, 1.0), 1.5, 0.4, math.inf)
        more["release_s"] = 1.5 + rng.uniform(0.3, 0.7)
    return Item(shape=shape, xml=xml, assets=assets, half_height_m=half, **base, **more)  # type: ignore[arg-type]
