#!/usr/bin/env python3
"""Draws the mounting and wiring of sensors for docs/hardware.md.

  wiring.py FOLDER            writes mounting.svg, wiring-piezo.svg and wiring-adxl345.svg
  wiring.py --check FOLDER    compares them with those of the folder; exit code 1 where one differs"""

import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True

from drawings import BLUE, GREEN, GREY, INK, METAL, OBJECT, ORANGE, PAPER, Picture  # noqa: E402

RUBBER, BRASS, BOARD, CHIP = "#4D4D4D", "#E8C46A", "#CFE5D3", "#BFC7D5"


def finger(picture, x, title):
    """A finger from the side with its pad against an object; what lies between is drawn by the caller."""
    picture.text(x + 130, 34, title, INK, "middle", 15)
    picture.box(x + 20, 60, 70, 250, METAL)
    picture.text(x + 55, 335, "finger", INK, "middle", 13)
    picture.box(x + 170, 45, 70, 280, OBJECT)
    picture.text(x + 205, 345, "object", INK, "middle", 13)
    picture.arrow(x + 255, 120, x + 255, 230, GREEN, 3, 11)
    picture.text(x + 262, 180, "slip", GREEN, size=13)


def label(picture, x, y, to_x, to_y, words):
    """Words under the picture with a line to what they name."""
    picture.path([(x + 8, y - 12), (to_x, to_y)], GREY, 1)
    picture.parts.append(f'<circle cx="{to_x}" cy="{to_y}" r="2.5" fill="{GREY}"/>')
    picture.text(x, y, words, INK, size=13)


def mounting(file):
    picture = Picture(1030, 440, "Three ways to put a vibration sensor into a finger")
    finger(picture, 0, "piezo disc under the pad")
    picture.box(90, 110, 12, 150, RUBBER)
    picture.box(102, 120, 6, 130, BRASS)
    picture.box(108, 135, 4, 100, PAPER)
    picture.box(112, 110, 22, 150, RUBBER)
    for k in range(10):
        picture.box(134, 113 + 15 * k, 35, 8, RUBBER)
    label(picture, 20, 426, 96, 256, "soft foam, 3 mm")
    label(picture, 60, 404, 105, 246, "disc, 27 mm, glued to the pad")
    label(picture, 100, 382, 150, 255, "hard rubber skin with ridges")

    finger(picture, 350, "accelerometer on the fingertip")
    picture.box(440, 110, 12, 150, RUBBER)
    picture.box(452, 110, 24, 150, METAL)
    picture.box(440, 165, 12, 40, CHIP)
    for k in range(10):
        picture.box(476, 113 + 15 * k, 44, 8, RUBBER)
    label(picture, 380, 404, 446, 200, "chip, screwed or glued")
    label(picture, 430, 382, 464, 255, "stiff plate, as light as can be")
    picture.text(380, 426, "no wire may pull at the plate", GREY, size=13)

    finger(picture, 700, "needle on a piezo (stylus)")
    picture.box(790, 110, 44, 150, METAL)
    picture.box(792, 158, 26, 54, PAPER)
    picture.box(796, 163, 8, 44, BRASS)
    picture.path([(804, 181), (854, 184), (870, 185), (854, 188), (804, 190)], INK, 1.5, "#F2D9C7", close=True)
    picture.box(834, 110, 36, 55, RUBBER)
    picture.box(834, 205, 36, 55, RUBBER)
    label(picture, 720, 404, 800, 203, "bender on rubber")
    label(picture, 820, 382, 862, 185, "needle, free along its axis")
    picture.text(720, 426, "the pads carry the grip force, not the needle", GREY, size=13)
    picture.write(file)


def pico(picture, x, y, pins):
    """The side of a Raspberry Pi Pico with the pins that are used; their places, by name."""
    height = 40 * len(pins) + 45
    picture.box(x, y, 190, height, BOARD)
    picture.text(x + 90, y + height - 12, "Raspberry Pi Pico", INK, size=12)
    picture.box(x + 180, y + 18, 34, 26, METAL)
    picture.text(x + 222, y + 36, "USB to the computer", INK, size=13)
    places = {}
    for k, (name, number) in enumerate(pins):
        at = y + 40 + 40 * k
        picture.parts.append(f'<circle cx="{x}" cy="{at}" r="5" fill="{BRASS}" stroke="{INK}"/>')
        picture.text(x + 10, at + 5, f"{name} ({number})", INK, size=12)
        places[name] = (x, at)
    return places


def wire(picture, *points, colour=INK):
    picture.path(points, colour, 1.8)


def joint(picture, x, y):
    picture.parts.append(f'<circle cx="{x}" cy="{y}" r="3.5" fill="{INK}"/>')


def resistor(picture, x, y, words, upright=True):
    """A resistor with its middle at x, y."""
    if upright:
        picture.box(x - 8, y - 20, 16, 40, PAPER)
        picture.text(x + 14, y + 5, words, INK, size=13)
    else:
        picture.box(x - 20, y - 8, 40, 16, PAPER)
        picture.text(x, y - 14, words, INK, "middle", 13)


def diode(picture, x, y, words):
    """A Schottky diode with its middle at x, y that leads upwards."""
    picture.path([(x - 10, y + 9), (x + 10, y + 9), (x, y - 9)], INK, 1.5, PAPER, close=True)
    picture.path([(x - 10, y - 9), (x + 10, y - 9)], INK, 2)
    picture.text(x + 16, y + 5, words, INK, size=13)


def wiring_piezo(file):
    picture = Picture(930, 330, "A piezo disc on the converter of a Raspberry Pi Pico")
    at = pico(picture, 560, 60, [("3V3", 36), ("GP26", 31), ("AGND", 33)])
    (x, high), (_, signal), (_, low) = at["3V3"], at["GP26"], at["AGND"]
    high_rail, low_rail = 60, 260
    wire(picture, (x, high), (520, high), (520, high_rail), (250, high_rail), colour=ORANGE)
    wire(picture, (x, low), (520, low), (520, low_rail), (110, low_rail), colour=BLUE)
    wire(picture, (x, signal), (110, signal))
    # The disc, with its centre to the signal and its brass to the ground.
    wire(picture, (110, signal), (110, 170))
    wire(picture, (110, 205), (110, low_rail), colour=BLUE)
    picture.box(80, 170, 60, 12, PAPER)
    picture.box(70, 188, 80, 17, BRASS)
    picture.text(20, 162, "centre", INK, size=13)
    picture.text(20, 222, "brass", INK, size=13)
    picture.text(20, 290, "piezo disc, 27 mm, some 20 nF", INK, size=14)
    resistor(picture, 250, 100, "220 k")
    wire(picture, (250, high_rail), (250, 80), colour=ORANGE)
    wire(picture, (250, 120), (250, signal))
    resistor(picture, 250, 200, "220 k")
    wire(picture, (250, signal), (250, 180))
    wire(picture, (250, 220), (250, low_rail), colour=BLUE)
    joint(picture, 250, signal)
    resistor(picture, 350, signal, "10 k", upright=False)
    wire(picture, (420, high_rail), (420, signal), colour=ORANGE)
    wire(picture, (420, signal), (420, low_rail), colour=BLUE)
    diode(picture, 420, 100, "BAT54S")
    diode(picture, 420, 200, "")
    joint(picture, 420, signal)
    joint(picture, 420, high_rail)
    joint(picture, 250, low_rail)
    joint(picture, 420, low_rail)
    picture.text(560, 280, "the LED of the board (GP25) lights in a slip", GREY, size=13)
    picture.text(560, 300, "GP2 is high while the detector computes", GREY, size=13)
    picture.write(file)


def wiring_adxl345(file):
    picture = Picture(930, 400, "An ADXL345 on the SPI of a Raspberry Pi Pico")
    pins = [("3V3", 36, "VCC, VS"), ("GP18", 24, "SCL (clock)"), ("GP19", 25, "SDA (to the chip)"),
            ("GP16", 21, "SDO (from the chip)"), ("GP17", 22, "CS"), ("GP20", 26, "INT1 (a reading is there)"),
            ("GND", 38, "GND")]  # fmt: skip
    places = pico(picture, 560, 40, [(name, number) for name, number, _ in pins])
    picture.box(90, 40, 230, 320, CHIP)
    picture.text(110, 62, "ADXL345 board", INK, size=14)
    for name, _, words in pins:
        x, y = places[name]
        picture.parts.append(f'<circle cx="320" cy="{y}" r="5" fill="{BRASS}" stroke="{INK}"/>')
        picture.text(308, y + 5, words, INK, "end", 12)
        wire(picture, (325, y), (x - 5, y), colour=ORANGE if name == "3V3" else BLUE if name == "GND" else INK)
    picture.text(90, 385, "wires of 10 cm or less; thin strands that do not pull at the plate", GREY, size=13)
    picture.write(file)


def main():
    arguments = sys.argv[1:]
    check = arguments[:1] == ["--check"]
    if len(arguments) != 1 + check:
        sys.exit(__doc__)
    folder = Path(arguments[-1])
    with tempfile.TemporaryDirectory() as made:
        drawn = {"mounting.svg": mounting, "wiring-piezo.svg": wiring_piezo, "wiring-adxl345.svg": wiring_adxl345}
        for name, draw in drawn.items():
            to = Path(made) if check else folder
            draw(to / name)
            if check and (not (folder / name).is_file() or (folder / name).read_bytes() != (to / name).read_bytes()):
                sys.exit(f"{folder / name}: differs from what scripts/wiring.py draws")


if __name__ == "__main__":
    main()
