"""``python -m grip_link``: look at a gripper, record its samples, or be one."""

from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Sequence
from dataclasses import asdict
from typing import Optional

from .client import GripLink
from .device import Drive
from .mcu import Pty, VirtualMcu
from .messages import Config, Layout, Unit

_SUFFIX = {Unit.METRE: "_m", Unit.NEWTON: "_n", Unit.METRE_PER_SECOND: "_mps", Unit.METRE_PER_SECOND2: "_mps2", Unit.PASCAL: "_pa"}


def _columns(layout: Layout) -> list[str]:
    names: list[str] = []
    for column in layout.columns:
        stem = column.kind.name.lower() + _SUFFIX.get(column.unit, "")
        name, again = stem, 2
        while name in names or f"{name}_0" in names:
            name, again = f"{stem}_{again}", again + 1
        names += [name] if column.count == 1 else [f"{name}_{k}" for k in range(column.count)]
    return names


def _info(arguments: argparse.Namespace) -> int:
    with GripLink.open(arguments.port, baudrate=arguments.baud) as link:
        assert link.ident is not None
        values = asdict(link.ident)
        channels, limits = values.pop("channels"), values.pop("limits")
        for name, value in {**values, **limits}.items():
            shown = value.hex() if isinstance(value, bytes) else getattr(value, "name", str(value)).lower()
            print(f"{name:14} {shown}")
        for bit, channel in enumerate(channels):
            print(f"channel {bit:6} {channel['kind'].name.lower()} x {channel['count']}, {channel['scale']:.3g} {channel['unit'].name.lower()} a step")
    return 0


def _watch(arguments: argparse.Namespace) -> int:
    config = Config(sample_rate_hz=arguments.rate, batch=max(1, min(255, arguments.rate // 1000)))
    duration_s = math.inf if arguments.duration is None else arguments.duration
    with GripLink.open(arguments.port, config, baudrate=arguments.baud) as link:
        writer = csv.writer(sys.stdout, lineterminator="\n")
        writer.writerow(["index", "t_s", *_columns(link.layout)])
        tick_hz = link.ident.tick_hz if link.ident else 1
        for sample in link.samples(duration_s):
            values = ("" if math.isnan(value) else f"{value:.9g}" for value in sample.values)
            writer.writerow([sample.index, f"{sample.tick / tick_hz:.6f}", *values])
        print(f"{link.loss}, {link.counters.bad_blocks} bad blocks", file=sys.stderr)
    return 3 if link.loss.lost else 0


def _mcu(arguments: argparse.Namespace) -> int:
    force_n = 0.0

    def actuate(_t_s: float, drive: Drive) -> None:
        nonlocal force_n
        force_n = drive.force_n

    def sense(t_s: float) -> tuple[float, float]:
        return 2e-6 * math.sin(2.0 * math.pi * 120.0 * t_s), force_n

    with Pty(arguments.pty) as pty:
        print(f"a gripper at {arguments.pty} ({pty.path})", file=sys.stderr, flush=True)
        VirtualMcu(pty.stream, sense, actuate).run(arguments.duration)
    return 0


def main(words: Optional[Sequence[str]] = None) -> int:
    """The command; its exit code: 0 done, 1 failed, 2 wrong arguments, 3 done with lost rows."""
    parser = argparse.ArgumentParser(prog="python -m grip_link", description="Look at a gripper, record its samples, or be one.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    port = argparse.ArgumentParser(add_help=False)
    port.add_argument("port", help="serial device, pseudo-terminal or pyserial URL such as socket://HOST:PORT")
    port.add_argument("--baud", type=int, default=115_200, help="baud rate; USB ports ignore it (%(default)s)")
    commands.add_parser("info", parents=[port], help="say who is there").set_defaults(run=_info)
    watch = commands.add_parser("watch", parents=[port], help="write samples as CSV in SI units; never commands a force")
    watch.add_argument("--rate", type=int, default=1000, help="samples a second (%(default)s)")
    watch.set_defaults(run=_watch)
    mcu = commands.add_parser("mcu", help="be a gripper on a pseudo-terminal: a 120 Hz stylus, force as commanded")
    mcu.add_argument("--pty", required=True, metavar="PATH", help="symbolic link that will lead to it")
    mcu.set_defaults(run=_mcu)
    for command in (watch, mcu):
        command.add_argument("--duration", type=float, help="stop after this time [s]")
    arguments = parser.parse_args(words)
    try:
        return int(arguments.run(arguments))
    except KeyboardInterrupt:
        return 0
    except BrokenPipeError:
        sys.stderr.close()
        return 0
    except (OSError, ValueError) as error:
        print(f"grip_link: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
