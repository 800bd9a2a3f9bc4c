"""``python -m grip_link``: look at a gripper, record its samples, or be one."""

from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Sequence
from typing import Optional

from .client import GripLink, LinkClosed, Sample
from .device import Drive
from .mcu import Pty, VirtualMcu
from .messages import Channel, Config, Ident, Layout, SampleFormat, Unit
from .stream import StreamClosed

_UNIT_SUFFIX = {
    Unit.METRE: "_m",
    Unit.NEWTON: "_n",
    Unit.METRE_PER_SECOND: "_mps",
    Unit.METRE_PER_SECOND2: "_mps2",
    Unit.PASCAL: "_pa",
}
_UNIT_SYMBOL = {
    Unit.METRE: "m",
    Unit.NEWTON: "N",
    Unit.METRE_PER_SECOND: "m/s",
    Unit.METRE_PER_SECOND2: "m/s2",
    Unit.PASCAL: "Pa",
}


def _columns(layout: Layout) -> list[str]:
    names: list[str] = []
    for column in layout.columns:
        stem = column.kind.name.lower() + _UNIT_SUFFIX.get(column.unit, "")
        name, again = stem, 2
        while name in names or f"{name}_0" in names:
            name, again = f"{stem}_{again}", again + 1
        names += [name] if column.count == 1 else [f"{name}_{k}" for k in range(column.count)]
    return names


def _describe(channel: Channel) -> str:
    unit = _UNIT_SYMBOL.get(channel.unit, "1")
    offered = "/".join(fmt.name.lower() for fmt in SampleFormat if channel.offers(fmt))
    return f"{channel.kind.name.lower()} x {channel.count}, {channel.scale:.3g} {unit} a step, {offered}"


def _info(ident: Ident) -> list[str]:
    limits = ident.limits
    return [
        f"uid          {ident.uid.hex()}",
        f"boot_id      {ident.boot_id:08x}, reset: {ident.reset.name.lower()}",
        f"firmware     {'.'.join(map(str, ident.firmware))}, protocol {ident.version_min} to {ident.version_max}",
        f"state        {ident.state.name.lower()}, fault {ident.fault:04x} {ident.fault.name.lower()}",
        f"clock        {ident.tick_hz} ticks/s",
        f"force        0 to {limits.force_max_mn / 1000:g} N, {limits.slew_max_mn_s / 1000:g} N/s,"
        f" held without commands {limits.hold_cap_mn / 1000:g} N"
        if limits.force_max_mn
        else "force        none: no actuator",
        f"travel       {limits.travel_min_um / 1000:g} to {limits.travel_max_um / 1000:g} mm",
        f"sampling     up to {limits.rate_max_hz} Hz",
        *(f"channel {bit:2}   {_describe(channel)}" for bit, channel in enumerate(ident.channels)),
    ]


def _info_command(arguments: argparse.Namespace) -> int:
    with GripLink.open(arguments.port, baudrate=arguments.baud) as link:
        if link.ident is not None:
            print("\n".join(_info(link.ident)))
    return 0


def _watch_command(arguments: argparse.Namespace) -> int:
    config = Config(sample_rate_hz=arguments.rate, batch=max(1, min(255, arguments.rate // 1000)))
    duration_s = math.inf if arguments.duration is None else arguments.duration
    with GripLink.open(arguments.port, config, baudrate=arguments.baud) as link:
        names = _columns(link.link.layout)
        writer = csv.writer(sys.stdout, lineterminator="\n")
        if arguments.csv:
            writer.writerow(["index", "t_s", *names])
        tick_hz = link.ident.tick_hz if link.ident else 1
        shown: Optional[Sample] = None
        for sample in link.samples(duration_s):
            if arguments.csv:
                values = ("" if math.isnan(value) else f"{value:.9g}" for value in sample.values)
                writer.writerow([sample.index, f"{sample.tick / tick_hz:.6f}", *values])
            elif shown is None or sample.tick - shown.tick >= tick_hz // 2:
                shown = sample
                print(_watch_line(link, sample, names), flush=True)
        loss = link.loss
        print(
            f"{loss.received} rows, {loss.lost} lost ({loss.dropped_by_mcu} dropped by the gripper),"
            f" {link.counters.bad_blocks} bad blocks",
            file=sys.stderr,
        )
    return 3 if loss.lost else 0


def _watch_line(link: GripLink, sample: Sample, names: Sequence[str]) -> str:
    values = " ".join(f"{name}={value:+.4g}" for name, value in zip(names, sample.values))
    status = link.status
    if status is None:
        return values
    return f"{values} state={status.state.name.lower()} applied={status.applied_mn / 1000:.3f} N fault={status.fault:04x}"


def _mcu_command(arguments: argparse.Namespace) -> int:
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


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m grip_link", description="Look at a gripper, record its samples, or be one."
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    port = argparse.ArgumentParser(add_help=False)
    port.add_argument("port", help="serial device, pseudo-terminal or pyserial URL such as socket://HOST:PORT")
    port.add_argument("--baud", type=int, default=115_200, help="baud rate; USB ports ignore it (%(default)s)")

    info = commands.add_parser("info", parents=[port], help="say who is there")
    info.set_defaults(run=_info_command)

    watch = commands.add_parser("watch", parents=[port], help="show samples; never commands a force")
    watch.add_argument("--csv", action="store_true", help="one line of CSV a row, in SI units")
    watch.add_argument("--rate", type=int, default=1000, help="samples a second (%(default)s)")
    watch.add_argument("--duration", type=float, help="stop after this time [s]")
    watch.set_defaults(run=_watch_command)

    mcu = commands.add_parser("mcu", help="be a gripper on a pseudo-terminal: a 120 Hz stylus, force as commanded")
    mcu.add_argument("--pty", required=True, metavar="PATH", help="symbolic link that will lead to it")
    mcu.add_argument("--duration", type=float, help="stop after this time [s]")
    mcu.set_defaults(run=_mcu_command)
    return parser


def main(words: Optional[Sequence[str]] = None) -> int:
    """The command; its exit code: 0 done, 1 failed, 2 wrong arguments, 3 done with lost rows."""
    arguments = _parser().parse_args(words)
    try:
        return int(arguments.run(arguments))
    except KeyboardInterrupt:
        return 0
    except BrokenPipeError:
        sys.stderr.close()
        return 0
    except (LinkClosed, StreamClosed, OSError, ValueError) as error:
        print(f"grip_link: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
