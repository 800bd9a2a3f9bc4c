"""Rules R1 to R3 against the firmware: hosts that fall silent or stop. What the link makes of bytes, the C peer shows without a board."""

from __future__ import annotations

import signal
import time

from board import LIFTED, Board, CheckFailed, must
from forces import FAULT, HOLD, LOSS, NEAR_MN, PATIENCE_S, forget_peak, held, highest
from host import Gripd, Host, gripd_with_object, until_holding
from grip_link.messages import Grip, Kind, LossAction


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
    program = stopped_while_closing(board, gripd)
    try:
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


def stopped_while_closing(board: Board, gripd: str) -> Gripd:
    """A gripd stopped between 0.6 and 1.4 N on its way to 2 N. On a busy computer the bench, which tells the time every
    20 ms, may tell neither: another start then."""
    for _ in range(5):
        board.fresh()
        program = Gripd(gripd, board)
        try:
            seen = board.wait("closing fingers", lambda now: now["target_mn"] >= 600, 20.0)
            if seen["target_mn"] < 1400:
                program.signal(signal.SIGSTOP)
                return program
        except BaseException:
            program.end()
            raise
        program.end()
        print(f"     not stopped in time: {seen['target_mn']} mN already", flush=True)
    raise CheckFailed("never seen between 600 and 1400 mN in five starts")


def silent_mid_rise(board: Board, _: str) -> str:
    """R1: one GRIP of 15 N at 5 N/s while 7 N hold the object, then silence. The force stops where the ttl found it."""
    slew_mn_s, ttl_ms, number = 5000, 100, 500_000
    board.fresh()
    host = Host(board)
    try:
        held(board, host)
        before = forget_peak(board)
        host.link.send(Kind.GRIP, Grip(number, 1, 0, ttl_ms, 15_000, slew_mn_s, 0).pack())
    finally:
        host.close()
    hold = board.wait("HOLD after it", lambda now: now["state"] == HOLD and now["cmd"] == number, PATIENCE_S)
    time.sleep(1.5)
    late = board.next_truth()
    later = board.since(hold["t_us"])
    drive_mn, applied_mn = max(now["drive_mn"] for now in later), highest(board, before)
    # A turn of the firmware counts for 10 ms of slew at most; with one more the command may run out.
    most_mn = 7000 + slew_mn_s * (ttl_ms + 10) // 1000
    said = (
        f"from {before['drive_mn']} mN one command of 15000 mN at {slew_mn_s} mN/s for {ttl_ms} ms, then nothing: HOLD at"
        f" {hold['drive_mn']} mN, never over {drive_mn} mN set and {applied_mn} mN pressed in {(late['t_us'] - hold['t_us']) / 1e6:.1f} s;"
        f" goal then {late['target_mn']} mN"
    )
    must(7000 + 2 * NEAR_MN < hold["drive_mn"] <= most_mn, said)
    must(drive_mn <= hold["drive_mn"] + 1 and late["target_mn"] <= hold["drive_mn"] + 1, said)
    must(applied_mn <= hold["drive_mn"] + NEAR_MN and {now["state"] for now in later} <= {HOLD, LOSS}, said)
    return said
