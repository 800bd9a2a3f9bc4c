"""Rules R1 to R4 against the firmware: hosts that fall silent, stop, or command what must not be."""

from __future__ import annotations

import math
import signal
import struct
import time

from board import LIFTED, Board, must
from forces import ACTIVE, FAULT, HOLD, LINKED, LOSS, NEAR_MN, PATIENCE_S, counted, forget_peak, held, highest, settled
from host import Gripd, Host, gripd_with_object, until_holding
from grip_link.host import GripCommand
from grip_link.messages import Grip, Hello, Kind, LossAction


def killed(board: Board, gripd: str) -> str:
    """R2, R3: kill -9 mid-grip. The force stays, at most at the hold cap; after ttl + 1 s the loss action, here HOLD."""
    program, before = gripd_with_object(gripd, board)
    try:
        start = forget_peak(board)
        program.signal(signal.SIGKILL)
        hold = board.wait("HOLD", lambda now: now["state"] == HOLD, PATIENCE_S)
        loss = board.wait("the loss action", lambda now: now["state"] == LOSS, PATIENCE_S)
        time.sleep(0.5)
        truth, peak = board.next_truth(), highest(board, start)
    finally:
        program.end()
    waited_ms = (loss["t_us"] - hold["t_us"]) / 1000
    said = (
        f"{before['applied_mn']} mN held before, {truth['applied_mn']} mN 1.5 s after, never over {peak} mN;"
        f" loss action {waited_ms:.0f} ms after HOLD; slipped {truth['travel_um'] - before['travel_um']} um meanwhile"
    )
    must(truth["object"] == LIFTED and truth["travel_um"] - before["travel_um"] <= 1, said)
    must(peak <= before["applied_mn"] + NEAR_MN and abs(truth["applied_mn"] - before["applied_mn"]) <= NEAR_MN, said)
    must(960 <= waited_ms <= 1100, said)
    return said + "; " + taken_over(board, gripd, truth["applied_mn"])


def taken_over(board: Board, gripd: str, force_mn: int) -> str:
    """The next gripd finds the fingers pressing and keeps what they hold."""
    start = board.next_truth()
    program = Gripd(gripd, board)
    try:
        until_holding(board, program)
    finally:
        program.signal(signal.SIGTERM)
        program.end()
    lowest = min(now["applied_mn"] for now in board.since(start["t_us"]))
    must(abs(lowest - force_mn) <= 100 and board.truth["object"] == LIFTED, f"the next gripd fell to {lowest} mN")
    return f"the next gripd took over at {lowest} mN"


def killed_with_cap(board: Board, action: LossAction) -> str:
    """R2, R3: a silent host at a force over the hold cap, and each loss action."""
    board.fresh()
    host = Host(board, hold_cap_mn=6000, loss_action=action, loss_after_ms=300)
    try:
        held(board, host)
    finally:
        host.close()
    hold = board.wait("HOLD", lambda now: now["state"] == HOLD, PATIENCE_S)
    capped = board.wait("the hold cap", lambda now: now["applied_mn"] <= 6000 + NEAR_MN, PATIENCE_S)
    loss = board.wait("the loss action", lambda now: now["state"] == LOSS, PATIENCE_S)
    time.sleep(0.3)
    truth = board.next_truth()
    said = (
        f"{action.name}: 7000 mN -> {capped['applied_mn']} mN at the hold cap of 6000 mN, after"
        f" {(loss['t_us'] - hold['t_us']) / 1000:.0f} ms the loss action, then {truth['applied_mn']} mN"
    )
    must(capped["clamp"] & 16 != 0, said)
    must(abs(truth["applied_mn"] - (6000 if action is LossAction.HOLD else 0)) <= NEAR_MN, said)
    return said


def stalled(board: Board, gripd: str) -> str:
    """R1: a host that stops while it raises the force. What was under way runs out, then nothing rises."""
    board.fresh()
    program = Gripd(gripd, board)
    try:
        board.wait("closing fingers", lambda now: 600 <= now["target_mn"] < 1400, 20.0)
        program.signal(signal.SIGSTOP)
        stopped = board.truth
        # Commands that lie in the line's buffer still count.
        early = board.wait("HOLD", lambda now: now["state"] == HOLD, PATIENCE_S)
        time.sleep(1.5)
        late = board.next_truth()
        highest_mn = max(now["applied_mn"] for now in board.since(early["t_us"]))
        states = sorted({now["state"] for now in board.since(early["t_us"])})
        said = (
            f"stopped near {stopped['target_mn']} mN on the way to 2000 mN, HOLD at {early['target_mn']} mN"
            f" {(early['t_us'] - stopped['t_us']) / 1000:.0f} ms later: then {highest_mn} mN at most in 1.5 s, states {states}"
            f" (7: the object, too heavy for this, fell)"
        )
        must(late["target_mn"] <= early["target_mn"] and highest_mn <= early["target_mn"] + NEAR_MN, said)
        must(set(states) <= {HOLD, LOSS, FAULT}, said)
    finally:
        program.end()
    return said


def impossible_forces(board: Board, _: str) -> str:
    """R4: negative forces and NaN are refused, too large ones clamped; none moves the fingers past the limit."""
    refused = 0
    for force_n in (math.nan, -1.0, -math.inf, math.inf):
        try:
            GripCommand.newtons(force_n)
        except ValueError:
            refused += 1
    board.fresh()
    host = Host(board, force_max_mn=8000, hold_cap_mn=8000)
    try:
        before = held(board, host)
        # The wire carries integers: the bits of a NaN with a sign, of -1 N as a float, and -1, and the lowest.
        bits = (0xFFC00000, 0xBF800000, 0xFFFFFFFF, 0x80000000)
        for index in range(200):
            force_mn = struct.unpack("<i", struct.pack("<I", bits[index % len(bits)]))[0]
            host.raw(Kind.GRIP, Grip(100_000 + index, 1, 0, 100, force_mn, 0, 0).pack())
            host.run(0.002, 7000 if index % 10 == 0 else None)
        counted(board, host, "rejected", before["rejected"] + 200)
        # Nothing but negative forces for a moment: the clamp bits are those of the last command.
        host.raw(Kind.GRIP, Grip(150_000, 1, 0, 100, -1, 0, 0).pack())
        rejected = board.wait("201 judged", lambda now: now["rejected"] >= before["rejected"] + 201, PATIENCE_S)
        # A NaN without a sign and infinity are large integers.
        for index, value in enumerate((0x7FC00000, 0x7F800000, 0x7FFFFFFF)):
            host.raw(Kind.GRIP, Grip(200_000 + index, 1, 0, 100, value, 0xFFFFFFFF, 0).pack())
            host.run(0.05)
        board.wait("F_max", lambda now: now["applied_mn"] >= 8000 - NEAR_MN and now["clamp"] & 1 != 0, PATIENCE_S)
        clamped = board.next_truth()
    finally:
        host.close()
    said = (
        f"{refused} of 4 refused by the peer; firmware: {rejected['rejected'] - before['rejected']} of 201 negative ones"
        f" rejected, force {rejected['applied_mn']} mN as before; NaN, infinity and 2^31-1 mN: peak {clamped['peak_mn']} mN"
        f" at F_max 8000 mN"
    )
    must(refused == 4 and rejected["rejected"] - before["rejected"] == 201, said)
    must(rejected["clamp"] & 8 != 0 and abs(rejected["applied_mn"] - before["applied_mn"]) <= NEAR_MN, said)
    must(clamped["peak_mn"] <= 8000 + NEAR_MN and clamped["clamp"] & 1 != 0, said)
    return said


def replayed(board: Board, _: str) -> str:
    """Old commands: the same bytes again, an old cmd_id in a new frame, and frames of a session that is over."""
    board.fresh()
    host = Host(board)
    try:
        held(board, host, 9000)
        old = list(host.sent[-50:])
        settled(board, host, 7000)
        before = forget_peak(board)
        for wire in old:
            host.write(wire)
            host.run(0.004, 7000)
        duplicates = counted(board, host, "duplicate", before["duplicate"] + 50)
        for _ in range(50):
            host.raw(Kind.GRIP, Grip(1, 1, 0, 100, 15_000, 0, 0).pack())
            host.run(0.004, 7000)
        older = board.next_truth()
        own = host.link._sender.session
        host.link._sender.session = own ^ 0x5555
        for index in range(50):
            host.raw(Kind.GRIP, Grip(300_000 + index, 1, 0, 100, 15_000, 0, 0).pack())
        host.link._sender.session = own
        after = counted(board, host, "stale", older["stale"] + 50)
        peak = highest(board, before)
    finally:
        host.close()
    said = (
        f"50 replayed frames: {duplicates['duplicate'] - before['duplicate']} counted as duplicates; 50 older cmd_ids ignored;"
        f" 50 frames of another session: {after['stale'] - older['stale']} counted as stale; peak {peak} mN of 7000 mN"
    )
    must(duplicates["duplicate"] - before["duplicate"] == 50 and after["stale"] - older["stale"] == 50, said)
    must(peak <= 7000 + NEAR_MN and after["target_mn"] == 7000, said)
    return said


def session_changed(board: Board, _: str) -> str:
    """A second host says HELLO mid-grip: the force is held, the first one's commands no longer count."""
    board.fresh()
    first = Host(board)
    try:
        held(board, first)
        before = forget_peak(board)
        old = first.link._sender.session
        first.link._sender.session = old ^ 0x1234 or 1
        first.raw(Kind.HELLO, Hello(0).pack())
        first.link._sender.session = old
        linked = board.wait("LINKED", lambda now: now["state"] == LINKED, PATIENCE_S)
        for _ in range(50):
            first.raw(Kind.GRIP, Grip(400_000, 1, 0, 100, 15_000, 0, 0).pack())
            first.run(0.002)
        board.wait("50 judged", lambda now: now["stale"] >= before["stale"] + 50, PATIENCE_S)
        after = board.next_truth()
    finally:
        first.close()
    second = Host(board)
    try:
        second.run(0.3, 7200)
        settled(board, second, 7200)
        taken = board.next_truth()
        peak = highest(board, before)
    finally:
        second.close()
    said = (
        f"state {linked['state']} (LINKED) with {linked['applied_mn']} mN held; {after['stale'] - before['stale']} stale"
        f" frames of 50 old commands, force {after['applied_mn']} mN; the new host commands {taken['applied_mn']} mN; peak {peak} mN"
    )
    # The first host's PING may be among them.
    must(50 <= after["stale"] - before["stale"] <= 60 and abs(after["applied_mn"] - 7000) <= NEAR_MN, said)
    must(taken["state"] == ACTIVE and peak <= 7200 + NEAR_MN and taken["object"] == LIFTED, said)
    return said
