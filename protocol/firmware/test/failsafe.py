"""Rules R1 to R9 against the firmware: each check breaks something and says what became of the force."""

from __future__ import annotations

import math
import os
import signal
import struct
import time

from board import LIFTED, PIN, WATCHDOG, Board, Truth, must
from host import Gripd, Host, gripd_with_object, until_holding
from grip_link.host import Batch, GripCommand, HostState, Rebooted
from grip_link.messages import Grip, Hello, Kind, LossAction

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


def rebooted(board: Board, _: str) -> str:
    """R5: a reset mid-grip. Another boot_id, passive, and nothing moves until a host arms it again."""
    board.fresh()
    host = Host(board)
    try:
        before = held(board, host)
        start = board.reset()
        until = time.monotonic() + PATIENCE_S
        host.run(1.0)
        while host.link.state is not HostState.STREAM and time.monotonic() < until:
            host.run(0.1)
        quiet = board.next_truth()
        boots = [(event.before, event.now) for event in host.told(Rebooted)]
        highest_mn = max(now["drive_mn"] for now in board.since(start["t_us"]))
        state = host.link.state
        host.run(1.0, 3000)
        armed = board.next_truth()
    finally:
        host.close()
    said = (
        f"boot {before['boot']} -> {quiet['boot']}, reset reason {quiet['reset']} (pin), host told {boots}; drive {highest_mn} mN"
        f" for {quiet['t_us'] / 1e6:.1f} s, force {before['applied_mn']} -> {quiet['applied_mn']} mN; armed again: drive"
        f" {armed['drive_mn']} mN or fault {armed['fault']:04x}"
    )
    must(quiet["reset"] == PIN and boots == [(before["boot"], quiet["boot"])], said)
    must(highest_mn == 0 and quiet["applied_mn"] == 0 and state is HostState.STREAM, said)
    # The object fell when the torque was off: pressing on nothing is found out (R8).
    must(armed["drive_mn"] == 3000 or armed["fault"] == 0x0201, said)
    return said


def wrapped(board: Board, _: str) -> str:
    """Sequence numbers of both directions pass FFFF -> 0000 in the middle of a grip."""
    board.fresh()
    board.order("q")
    host = Host(board, first_seq=0xFFA0)
    try:
        held(board, host)
        before, batches = board.next_truth(), len(host.told(Batch))
        while host.link._sender.next_seq > 0x8000:
            host.run(0.1, 7500)
        host.run(0.5, 7500)
        after = settled(board, host, 7500)
        seq = host.link._sender.next_seq
        counters, lost = host.link.counters, host.link.loss.lost
        refused = sum(after[name] - before[name] for name in ("duplicate", "stale", "crc"))
    finally:
        host.close()
    said = (
        f"from FFA0 the host counted to {seq:04x}, {after['cmd']} commands, {refused} refused;"
        f" from FFC0 the device to {after['seq']:04x}, {len(host.told(Batch)) - batches} batches, {lost} rows lost, {counters.gap} gaps,"
        f" {counters.duplicate} duplicates; force {after['applied_mn']} mN of 7500 mN"
    )
    must(seq < 0x1000 and after["cmd"] - before["cmd"] > 20 and after["seq"] < 0x4000 and before["seq"] < 0x4000, said)
    must(refused == 0 and lost + counters.gap + counters.duplicate == 0, said)
    must(abs(after["applied_mn"] - 7500) <= NEAR_MN, said)
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


def echoed(board: Board, _: str) -> str:
    """A line that sends everything back: own frames are counted as echo and mean nothing."""
    board.fresh()
    host = Host(board, channel_mask=1)
    try:
        held(board, host)
        before = forget_peak(board)
        board.echo(True)
        host.run(1.0, 7000)
        board.echo(False)
        settled(board, host, 7000)
        after, peak = board.next_truth(), highest(board, before)
    finally:
        board.echo(False)
        host.close()
    said = (
        f"{after['echo'] - before['echo']} own frames back in 1 s, {after['crc'] - before['crc']} blocks broken by it, state"
        f" {after['state']}, force {after['applied_mn']} mN, peak {peak} mN of 7000 mN"
    )
    must(after["echo"] - before["echo"] > 20 and peak <= 7000 + NEAR_MN, said)
    must(after["state"] == ACTIVE and abs(after["applied_mn"] - 7000) <= NEAR_MN and after["object"] == LIFTED, said)
    return said


def garbage(board: Board, _: str) -> str:
    """What ModemManager writes, and random bytes: before a session, and between the commands of one."""
    modem = b"AT\r\nATZ\r\nAT+CGMM\r\nAT+GCAP\r\nAT+CPIN?\r\n~\0"
    board.fresh()
    with open(board.port, "wb", buffering=0) as port:
        for _ in range(10):
            port.write(modem + os.urandom(64))
            time.sleep(0.02)
    passive = board.next_truth()
    host = Host(board)
    try:
        held(board, host)
        before = forget_peak(board)
        for index in range(100):
            host.write(modem if index % 2 == 0 else os.urandom(64) + b"\0")
            host.run(0.01, 7000)
        counted(board, host, "garbage", before["garbage"] + 4000)
        after, peak = settled(board, host, 7000), highest(board, before)
    finally:
        host.close()
    said = (
        f"state {passive['state']}, drive {passive['drive_mn']} mN after 10 x {len(modem) + 64} bytes without a session; mid-grip"
        f" {after['garbage'] - before['garbage']} bytes counted as garbage, force {after['applied_mn']} mN, peak {peak} mN of 7000 mN"
    )
    must(passive["state"] == IDLE and passive["drive_mn"] == 0 and passive["garbage"] > 0, said)
    must(after["garbage"] - before["garbage"] > 4000 and peak <= 7000 + NEAR_MN and after["state"] == ACTIVE, said)
    return said


def frozen(board: Board, _: str) -> str:
    """R6, R7: a stylus that no longer moves is a latched minor fault: the force is held and takes no commands."""
    board.fresh()
    host = Host(board)
    try:
        held(board, host)
        before = forget_peak(board)
        board.order("f")
        host.run(0.3, 7000)
        told = [now for now in board.since(before["t_us"]) if now["fault"] == 0x0102]
        must(bool(told), f"no fault within 0.3 s: {board.truth}")
        fault = told[0]
        host.run(0.5, 12_000)
        after, peak = board.next_truth(), highest(board, before)
    finally:
        host.close()
    said = (
        f"fault {fault['fault']:04x} at most {(fault['t_us'] - before['t_us']) / 1000:.0f} ms after it froze, state {after['state']};"
        f" 12 N commanded then: {after['rejected'] - before['rejected']} rejected, peak {peak} mN of 7000 mN"
    )
    must(after["state"] == FAULT and after["fault"] == 0x0102 and peak <= 7000 + NEAR_MN, said)
    must(after["rejected"] > before["rejected"] and abs(after["applied_mn"] - 7000) <= NEAR_MN, said)
    return said


def hung(board: Board, order: str, name: str) -> str:
    """R9: one task no longer runs. The watchdog resets, the reason says so, and the fingers are passive."""
    board.fresh()
    host = Host(board)
    try:
        before = held(board, host)
        began = time.monotonic()
        board.order(order)
        while board.truth["boot"] == before["boot"] and time.monotonic() - began < PATIENCE_S:
            host.run(0.005, 7000)
        took_ms = (time.monotonic() - began) * 1000
        must(board.truth["boot"] == before["boot"] + 1, f"{name} hangs: no reset within {took_ms:.0f} ms")
        time.sleep(0.2)
        after = board.next_truth()
        highest_mn = max(now["drive_mn"] for now in board.since(0))
    finally:
        host.close()
    said = f"{name} hangs: reset after {took_ms:.0f} ms, reason {after['reset']} (watchdog), state {after['state']}, drive {highest_mn} mN"
    must(after["reset"] == WATCHDOG and highest_mn == 0 and after["state"] in (IDLE, LINKED, ARMED), said)
    must(100 <= took_ms <= 2000, said)
    return said


CHECKS = {
    "kill -9 of gripd": killed,
    "silent host, hold": lambda board, _: killed_with_cap(board, LossAction.HOLD),
    "silent host, open": lambda board, _: killed_with_cap(board, LossAction.OPEN),
    "silent host, passive": lambda board, _: killed_with_cap(board, LossAction.PASSIVE),
    "stalled gripd": stalled,
    "NaN and negative force": impossible_forces,
    "replayed and stale commands": replayed,
    "reboot mid-grip": rebooted,
    "sequence wrap": wrapped,
    "session change": session_changed,
    "echo": echoed,
    "AT garbage": garbage,
    "frozen stylus": frozen,
    "control task": lambda board, _: hung(board, "C", "control"),
    "link task": lambda board, _: hung(board, "L", "link"),
    "sampling task": lambda board, _: hung(board, "S", "sampling"),
    "main loop": lambda board, _: hung(board, "X", "the whole loop"),
}
