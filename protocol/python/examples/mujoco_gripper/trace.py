"""A grasp in, a picture of force, slip and events out, and a film of it where MuJoCo can render here (EGL or OSMesa)."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image, ImageDraw

from .items import Item
from .loop import Grasp
from .needed import CRUSH_RATIO
from .world import World

FRAME_MS = 80
COLOURS = 48


def draw(item: Item, sensors: str, done: Grasp, needed_n: float, folder: Path) -> None:
    """Writes ``CLASS-NUMBER-SENSORS.png`` and, where something can be rendered, ``.gif`` into the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    stem = folder / f"{item.kind}-{item.seed[1]}-{sensors}"
    figure, axis, limits = _plot(item, sensors, done, needed_n)
    figure.savefig(stem.with_suffix(".png"), dpi=110)
    frames = _rendered(item, done)
    if frames:
        _film(figure, axis, limits, frames, stem.with_suffix(".gif"))
    plt.close(figure)


def _plot(item: Item, sensors: str, done: Grasp, needed_n: float) -> tuple[Any, Any, tuple[float, float]]:
    trace = np.array([row for row in done.trace if row[0] >= -0.4] or [(0.0,) * 5])
    t = trace[:, 0]
    figure, (above, below) = plt.subplots(2, 1, figsize=(5.6, 4.2), sharex=True, height_ratios=(2, 1), layout="constrained")
    above.plot(t, trace[:, 1], color="0.65", lw=1, label="commanded")
    above.plot(t, trace[:, 2], color="tab:blue", lw=1.4, label="grip force")
    above.axhline(needed_n, color="tab:green", ls="--", lw=1, label="needed")
    if trace[:, 1:3].max() > 0.6 * CRUSH_RATIO * needed_n:
        above.axhline(CRUSH_RATIO * needed_n, color="tab:red", ls=":", lw=1, label="crushed")
    for event in done.events:
        if event.get("type") == "slip":
            colour = {"ended": "0.8", "gross": "tab:orange"}.get(event["phase"], "gold")
            for axis in (above, below):
                axis.axvline(event["t_s"] - done.lift_s, color=colour, lw=0.9, zorder=0)
    above.set_ylabel("N, one finger")
    above.set_title(f"{item.shape} of {item.mass_kg:.2f} kg, friction {item.friction:.2f}: gripd with {_names(sensors)}", fontsize=9)
    above.legend(fontsize=7, ncols=4, loc="upper center")
    above.set_ylim(0.0, above.get_ylim()[1] * 1.15)
    below.plot(t, trace[:, 3] * 1e3, color="tab:purple", lw=1.4)
    below.set_ylabel("slip, mm")
    below.set_xlabel("s from the lift; orange: slip reported, grey: ended")
    below.set_xlim(float(t[0]), float(t[-1]))
    return figure, above, (float(t[0]), float(t[-1]))


def _names(sensors: str) -> str:
    more = {"travel": "travel", "tangential": "tangential force", "taxels": "taxels"}.get(sensors)
    return f"stylus and {more}" if more else "the stylus alone"


def _rendered(item: Item, done: Grasp) -> list[tuple[float, Any]]:
    """Time and picture of each pose; none where nothing can be rendered."""
    import mujoco

    world = World(item)
    try:
        renderer = mujoco.Renderer(world.model, 336, 300)
    except Exception as error:  # what is missing shows in many types: no library, no device, no context
        print(f"mujoco_gripper: no film, nothing renders here ({type(error).__name__}: {error})", file=sys.stderr)
        return []
    frames = []
    with renderer:
        for since, pose in done.poses[:: max(1, FRAME_MS // 40)]:
            world.data.qpos[:] = pose
            mujoco.mj_forward(world.model, world.data)
            renderer.update_scene(world.data, camera="side")
            frames.append((since, renderer.render()))
    return frames


def _film(figure: Any, axis: Any, limits: tuple[float, float], frames: list[tuple[float, Any]], path: Path) -> None:
    """The rendered scene beside the plot, in which a line shows the time."""
    figure.set_dpi(80)
    figure.canvas.draw()
    plot = np.asarray(figure.canvas.buffer_rgba())[:, :, :3]
    box = axis.get_window_extent()
    pages = []
    for since, scene in frames:
        share = (since - limits[0]) / (limits[1] - limits[0])
        page = Image.new("RGB", (scene.shape[1] + plot.shape[1], max(scene.shape[0], plot.shape[0])), "white")
        page.paste(Image.fromarray(scene), (0, 0))
        page.paste(Image.fromarray(plot), (scene.shape[1], 0))
        x = scene.shape[1] + box.x0 + share * box.width
        ImageDraw.Draw(page).line((x, plot.shape[0] * 0.08, x, plot.shape[0] * 0.9), fill=(40, 40, 40))
        pages.append(page.quantize(COLOURS, dither=Image.Dither.NONE))
    pages[0].save(path, save_all=True, append_images=pages[1:], duration=FRAME_MS, loop=0, optimize=True)
