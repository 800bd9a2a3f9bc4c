#!/usr/bin/env python3
"""Draws the stylus arrangement and the parts of a surface's texture, from the simulated profile of the pages.

  drawings.py GRIPCTL FOLDER

GRIPCTL is the program; it separates docs/profile.csv. FOLDER gets stylus.svg and texture.svg. Both have a background of
their own, so that they are readable on light and dark pages."""

import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path

PROFILE = Path(__file__).resolve().parent.parent / "docs" / "profile.csv"
INK, GREY, BLUE, ORANGE, GREEN = "#222222", "#777777", "#0072B2", "#D55E00", "#009E73"
PAPER, METAL, OBJECT = "#FFFFFF", "#D8D8D8", "#DCE9F3"


class Picture:
    def __init__(self, width, height, title):
        self.parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
            f'font-family="DejaVu Sans, Verdana, sans-serif" font-size="14" role="img"><title>{title}</title>',
            f'<rect width="{width}" height="{height}" fill="{PAPER}"/>',
        ]

    def path(self, points, colour=INK, width=1.5, fill="none", dash="", close=False):
        d = "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in points) + (" Z" if close else "")
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<path d="{d}" fill="{fill}" stroke="{colour}" stroke-width="{width}" stroke-linejoin="round"{dashed}/>'
        )

    def box(self, x, y, width, height, fill, colour=INK):
        self.parts.append(
            f'<rect x="{x}" y="{y}" width="{width}" height="{height}" fill="{fill}" stroke="{colour}" stroke-width="1.5"/>'
        )

    def text(self, x, y, words, colour=INK, anchor="start", size=14):
        self.parts.append(
            f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}" font-size="{size}">{words}</text>'
        )

    def arrow(self, x, y, to_x, to_y, colour=INK, width=2.5, head=9):
        length = ((to_x - x) ** 2 + (to_y - y) ** 2) ** 0.5
        u, v = (to_x - x) / length, (to_y - y) / length
        back_x, back_y = to_x - head * u, to_y - head * v
        self.path([(x, y), (back_x, back_y)], colour, width)
        side = head * 0.45
        tip = [(to_x, to_y), (back_x - side * v, back_y + side * u), (back_x + side * v, back_y - side * u)]
        self.path(tip, colour, 1, fill=colour, close=True)

    def measure(self, x, y, to_x, to_y, colour):
        """A dimension: an arrow to both ends."""
        middle_x, middle_y = (x + to_x) / 2, (y + to_y) / 2
        self.arrow(middle_x, middle_y, x, y, colour, 1.5, 7)
        self.arrow(middle_x, middle_y, to_x, to_y, colour, 1.5, 7)

    def write(self, file):
        file.write_text("\n".join(self.parts + ["</svg>", ""]), encoding="utf-8")


def separated(gripctl):
    """The columns of the profile in its parts (mm, um), and its parameters."""
    with tempfile.TemporaryDirectory() as folder:
        parts = Path(folder) / "parts.csv"
        command = [gripctl, "profile", PROFILE, "--speed", "0.05", "--cutoff-mm", "0.8", "--form-degree", "2", "--level"]
        ran = subprocess.run([*command, "--json", "--parts", parts], capture_output=True, text=True, check=True)
        with parts.open(encoding="utf-8", newline="") as file:
            rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    return {name: [row[name] for row in rows] for name in rows[0]}, json.loads(ran.stdout)


def turns(heights, hysteresis):
    """Places of valleys and peaks in turn, which differ by more than the hysteresis."""
    found, rising, extreme = [], None, 0
    for i, z in enumerate(heights):
        beyond = z - heights[extreme]
        if rising is None:
            if abs(beyond) > hysteresis:
                rising, extreme = beyond > 0, i
        elif beyond > 0 if rising else beyond < 0:
            extreme = i
        elif abs(beyond) > hysteresis:
            found.append((extreme, rising))
            rising, extreme = not rising, i
    return found


def texture(columns, line, file):
    picture = Picture(900, 570, "A surface is form, waviness and roughness")
    waviness = f"Wa {line['wa_um']:.2f} um, Wz {line['wz_um']:.1f} um"
    roughness = f"Ra {line['ra_um']:.2f} um, Rz {line['rz_um']:.1f} um, RSm {line['rsm_um']:.0f} um"
    rows = [
        ("surface", "height_um", INK, "as a stylus traces it"),
        ("= form", "form_um", GREEN, f"least-squares arc, {line['form_um']:.1f} um high"),
        ("+ waviness", "waviness_um", ORANGE, f"longer than lambda_c = {line['cutoff_mm']} mm: {waviness}"),
        ("+ roughness", "roughness_um", BLUE, f"shorter: {roughness}"),
    ]
    left, right, scale = 150, 830, 3.6
    place = lambda x: left + (right - left) * x / columns["x_mm"][-1]
    for k, (name, column, colour, words) in enumerate(rows):
        top = 20 + 124 * k
        middle = top + 76
        heights = columns[column]
        centre = (max(heights) + min(heights)) / 2
        picture.path([(left, middle), (right, middle)], GREY, 0.7, dash="2 4")
        # Every third of the heights: half a pixel.
        pairs = list(zip(columns["x_mm"], heights))[::3]
        points = [(place(x), middle - scale * (z - centre)) for x, z in pairs]
        picture.path(points, colour, 1.3)
        picture.text(20, middle + 5, name, colour, size=16)
        picture.text(left, top + 14, words, GREY, size=13)
        picture.measure(right + 10, middle - 5 * scale, right + 10, middle + 5 * scale, GREY)
        picture.text(right + 20, middle + 4, "10 um", GREY, size=12)
    bottom = 535
    picture.path([(left, bottom), (right, bottom)])
    for mm in range(int(columns["x_mm"][-1] + 0.01) + 1):
        picture.path([(place(mm), bottom), (place(mm), bottom + 5)])
        picture.text(place(mm), bottom + 20, str(mm), anchor="middle", size=12)
    picture.text(right + 20, bottom + 5, "mm", size=12)
    picture.write(file)


def stylus(columns, line, file):
    picture = Picture(1000, 560, "A stylus in the finger of a gripper rides over the surface of the object")
    heights = [w + r for w, r in zip(columns["waviness_um"], columns["roughness_um"])]
    gripper(picture, columns, heights)
    irregularities(picture, columns, heights, line)
    picture.write(file)


def gripper(picture, columns, heights):
    """Finger, stylus, object and what acts on them: the surface is upright, heights point to the finger."""
    face, mean, top, bottom, tip_y = 300, 325, 60, 500, 280
    step = 2.8 / (columns["x_mm"][-1] / (len(heights) - 1)) / (bottom - top)
    surface = []
    for y in range(top, bottom + 1):
        at = int((y - top) * step)
        surface.append((mean - 2.3 * heights[at], y))
    waves = [(mean - 2.3 * columns["waviness_um"][int((y - top) * step)], y) for y in range(top, bottom + 1)]
    picture.path([*surface, (560, bottom), (560, top)], INK, 1.5, OBJECT, close=True)
    picture.path(waves, ORANGE, 1.5, dash="5 4")
    tip_x = surface[tip_y - top][0]
    # Finger with its chamber, second finger.
    chamber = [(face, 268), (face - 18, 268), (face - 18, 225), (110, 225), (110, 335), (face - 18, 335), (face - 18, 292), (face, 292)]
    picture.path([(70, top + 20), (face, top + 20), *chamber, (face, bottom - 20), (70, bottom - 20)], INK, 1.5, METAL, close=True)
    picture.box(560, top + 20, 50, bottom - top - 40, METAL)
    # Spring, damper, mass and needle.
    spring = [(110, 256), (124, 256), *((124 + 6 * k, 256 + (9 if k % 2 else -9)) for k in range(1, 9)), (178, 256), (192, 256)]
    picture.path(spring, BLUE, 2)
    picture.path([(110, 306), (140, 306)], BLUE, 2)
    picture.path([(164, 296), (140, 296), (140, 316), (164, 316)], BLUE, 2)
    picture.path([(154, 299), (154, 313)], BLUE, 2)
    picture.path([(154, 306), (192, 306)], BLUE, 2)
    picture.box(192, 242, 46, 76, "#F2D9C7")
    picture.path([(238, 274), (tip_x - 14, 276), (tip_x, 280), (tip_x - 14, 284), (238, 286)], INK, 1.5, "#F2D9C7", close=True)
    picture.arrow(206, 365, 240, 365, BLUE, 2, 8)
    picture.arrow(216, 365, 182, 365, BLUE, 2, 8)
    picture.text(152, 216, "spring k", BLUE, "middle")
    picture.text(152, 352, "damper c", BLUE, "middle")
    picture.text(215, 285, "m", INK, "middle", 16)
    picture.text(211, 388, "y, along its axis", BLUE, "middle")
    picture.text(185, 112, "finger", INK, "middle", 16)
    picture.text(185, 172, "stylus in its chamber", INK, "middle")
    picture.text(460, 112, "object", INK, "middle", 16)
    picture.text(365, 448, "roughness on", BLUE)
    picture.text(365, 466, "waviness (dashed)", ORANGE)
    # Forces and motion.
    picture.arrow(15, 280, 68, 280, ORANGE, 4, 13)
    picture.text(12, 266, "F", ORANGE, size=16)
    picture.arrow(668, 280, 612, 280, ORANGE, 4, 13)
    picture.text(650, 266, "F", ORANGE, size=16)
    picture.text(12, 306, "grip", ORANGE, size=12)
    picture.text(640, 306, "grip", ORANGE, size=12)
    picture.parts.append(f'<circle cx="500" cy="240" r="5" fill="{INK}"/>')
    picture.arrow(500, 240, 500, 330, INK, 3, 12)
    picture.text(500, 350, "gravity", INK, "middle")
    picture.arrow(420, 180, 420, 290, GREEN, 4, 13)
    picture.text(410, 235, "v", GREEN, "end", 16)
    picture.text(410, 254, "slip", GREEN, "end", 12)


def irregularities(picture, columns, heights, line):
    """The way under the tip, lying: one irregularity with its height delta and length s."""
    left, right, middle, scale = 700, 980, 255, 11.0
    step_mm = columns["x_mm"][1]
    found = turns(columns["roughness_um"], line["hysteresis_um"])
    first = next(k for k in range(8, len(found)) if not found[k][1])
    valley, peak, next_valley = (found[first + 2 + k][0] for k in range(3))
    begin = found[first][0] - int(0.03 / step_mm)
    count = int(0.62 / step_mm)
    x = lambda i: left + (right - left) * (i - begin) / count
    centre = sum(heights[begin : begin + count]) / count
    y = lambda z: middle - scale * (z - centre)
    drawn = range(begin, begin + count)
    picture.path([(x(i), y(heights[i])) for i in drawn], BLUE, 2)
    picture.path([(x(i), y(columns["waviness_um"][i])) for i in drawn], ORANGE, 1.5, dash="5 4")
    picture.text((left + right) / 2, 112, "under the tip", INK, "middle", 16)
    lowest = max(y(heights[i]) for i in drawn)
    for at in (valley, next_valley):
        picture.path([(x(at), y(heights[at])), (x(at), lowest + 40)], GREY, 1, dash="3 3")
    picture.measure(x(valley), lowest + 34, x(next_valley), lowest + 34, GREEN)
    picture.text((x(valley) + x(next_valley)) / 2, lowest + 54, "s_i", GREEN, "middle", 16)
    foot = y((heights[valley] + heights[next_valley]) / 2)
    picture.path([(x(valley), foot), (x(next_valley) + 6, foot)], GREY, 1, dash="3 3")
    picture.measure(x(peak), y(heights[peak]), x(peak), foot, GREEN)
    picture.text(x(peak), y(heights[peak]) - 8, "delta_i", GREEN, "middle", 16)
    picture.text(left, 400, "delta_i: peak over the mean of", GREY, size=13)
    picture.text(left, 418, "its two valleys; s_i: from valley", GREY, size=13)
    picture.text(left, 436, "to valley; n of them in a slip", GREY, size=13)
    picture.arrow(left, 145, left + 80, 145, GREEN, 2, 9)
    picture.text(left + 90, 150, "way along the slip", GREEN, size=13)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    columns, line = separated(sys.argv[1])
    texture(columns, line, Path(sys.argv[2]) / "texture.svg")
    stylus(columns, line, Path(sys.argv[2]) / "stylus.svg")


if __name__ == "__main__":
    main()
