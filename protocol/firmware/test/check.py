"""Runs every check against the firmware in QEMU: python3 check.py --firmware firmware.elf --gripd PATH [NAME ...]

Prints a line for each with the measured numbers; exit code 1 when one of them failed. Needs only the standard library.
"""

from __future__ import annotations

import argparse
import signal
import sys
import time

from board import Board, CheckFailed
from device_faults import rebooted, garbage, frozen, hung
from hold import gripd_holds, too_little_force_drops
from host_faults import killed, killed_with_cap, silent_mid_rise, stalled
from grip_link.messages import LossAction

CHECKS = {
    "gripd holds": gripd_holds,
    "too little force": lambda board, _: too_little_force_drops(board),
    "kill -9 of gripd": killed,
    "silent host, hold": lambda board, _: killed_with_cap(board, LossAction.HOLD),
    "silent host, open": lambda board, _: killed_with_cap(board, LossAction.OPEN),
    "silent host, passive": lambda board, _: killed_with_cap(board, LossAction.PASSIVE),
    "stalled gripd": stalled,
    "silent mid-rise": silent_mid_rise,
    "reboot mid-grip": rebooted,
    "AT garbage": garbage,
    "frozen stylus": frozen,
    "control task": lambda board, _: hung(board, "C", "control"),
    "link task": lambda board, _: hung(board, "L", "link"),
    "sampling task": lambda board, _: hung(board, "S", "sampling"),
    "main loop": lambda board, _: hung(board, "X", "the whole loop"),
}


def main() -> int:
    """Exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--firmware", required=True)
    parser.add_argument("--gripd", required=True)
    parser.add_argument("names", nargs="*", help="only these checks")
    args = parser.parse_args()
    unknown = set(args.names) - set(CHECKS)
    if unknown:
        parser.error(f"no such check: {', '.join(sorted(unknown))}; there are {', '.join(CHECKS)}")
    # A request to end goes through the finally blocks, which end QEMU and gripd.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    failed = 0
    board = Board(args.firmware)
    try:
        for name in args.names or CHECKS:
            began = time.monotonic()
            try:
                said, verdict = CHECKS[name](board, args.gripd), "ok  "
            except CheckFailed as error:
                said, verdict = str(error), "FAIL"
                failed += 1
            print(f"{verdict} {name} ({time.monotonic() - began:.1f} s): {said}", flush=True)
        print(f"     the emulated clock ran at {board.pace():.3f} of real time")
    finally:
        board.close()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
