"""States of the firmware, and waiting until a force is what a host commands."""

from __future__ import annotations

import time

from board import LIFTED, Board, Truth, must
from host import Host

IDLE, LINKED, ARMED, ACTIVE, HOLD, LOSS, FAULT = range(1, 8)
NEAR_MN = 3
"""The force follows its target exponentially; the bench rounds to 1 mN."""

PATIENCE_S = 10.0
"""A busy computer runs the emulator slowly; what is asserted is measured by the firmware's own clock."""


def settled(board: Board, host: Host, force_mn: int) -> Truth:
    """The object hangs between the fingers and the force is what the host commands: commands under way have arrived."""
    until = time.monotonic() + PATIENCE_S
    while True:
        host.run(0.1, force_mn)
        truth = board.truth
        if truth["object"] == LIFTED and abs(truth["applied_mn"] - force_mn) <= NEAR_MN:
            return truth
        must(time.monotonic() < until, f"not held with {force_mn} mN: {truth}")


def held(board: Board, host: Host, force_mn: int = 7000) -> Truth:
    """The object between the fingers with a force that holds it."""
    host.run(0.6, force_mn)
    return settled(board, host, force_mn)


def counted(board: Board, host: Host, counter: str, least: int) -> Truth:
    """Goes on with 7000 mN until a counter of the firmware has come so far."""
    until = time.monotonic() + PATIENCE_S
    while board.truth[counter] < least and time.monotonic() < until:
        host.run(0.05, 7000)
    return board.next_truth()


def highest(board: Board, since: Truth) -> int:
    """The highest applied force since a line (mN), by the bench's peak that was forgotten then."""
    return max(now["peak_mn"] for now in board.since(since["t_us"]))


def forget_peak(board: Board) -> Truth:
    """From here on the peak counts."""
    board.order("p")
    return board.next_truth()
