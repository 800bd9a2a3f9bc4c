"""Prints what a gripd hears: slips and news, or every n-th sample as CSV.

    python examples/listen.py [socket://HOST:PORT] [--every N] [--seconds S]
"""

from __future__ import annotations

import argparse
import sys

from grip_link import Daemon, DaemonError
from grip_link.daemon import DEFAULT_URL
from grip_link.messages.daemon import Notice, Phase, Rows, RowSet, Slip, Subscribe, Topics


def show(message: object) -> None:
    """One line for a slip or a notice, one for each sample."""
    if isinstance(message, Slip):
        ended = message.phase is Phase.ENDED
        what = f"ended after {message.duration * 1e3:.1f} ms" if ended else message.phase.name.lower()
        print(f"{message.device_us / 1e6:.4f} s  slip {what}, command {message.command:.2f} N", flush=True)
    elif isinstance(message, Notice):
        print(f"{message.host_us / 1e6:.4f} s  {message.message}", flush=True)
    elif isinstance(message, Rows):
        for row in message:
            print(f"{row.index},{row.t_us / 1e6:.6f},{row.values[RowSet.STYLUS]:.9g}")


def main() -> int:
    """Returns 0, 1 when gripd is not there, 3 when samples were dropped because this program was too slow."""
    parser = argparse.ArgumentParser(description="listen to a gripd")
    parser.add_argument("url", nargs="?", default=DEFAULT_URL)
    parser.add_argument("--every", type=int, default=0, metavar="N", help="every n-th sample as index,t_s,stylus_m")
    parser.add_argument("--seconds", type=float, default=None, metavar="S")
    arguments = parser.parse_args()
    if not 0 <= arguments.every <= 65535:
        parser.error(f"--every {arguments.every}: expected 0 to 65535")
    topics = Topics(0) if arguments.every else Topics.SLIP | Topics.NEWS
    try:
        with Daemon.open(arguments.url, Subscribe(topics=topics, every_nth=arguments.every)) as gripd:
            print(f"{gripd.welcome.daemon} at {arguments.url}", file=sys.stderr)
            for message in gripd.messages(arguments.seconds):
                show(message)
            return 3 if gripd.dropped else 0
    except KeyboardInterrupt:
        return 0
    except (DaemonError, OSError, ValueError) as error:
        print(f"listen: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
