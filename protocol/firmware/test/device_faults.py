"""Rules R5 to R9 against the firmware, and a bad line: resets, garbage, a dead sensor, hung tasks."""

from __future__ import annotations

import os
import time

from board import PIN, WATCHDOG, Board, must
from forces import ACTIVE, ARMED, FAULT, IDLE, LINKED, NEAR_MN, PATIENCE_S, counted, forget_peak, held, highest, settled
from host import Host


def rebooted(board: Board, _: str) -> str:
    """R5: a reset mid-grip. Another boot_id, passive, and nothing moves until a host arms it again."""
    board.fresh()
    host = Host(board)
    try:
        before = held(board, host)
        start = board.reset()
        until = time.monotonic() + PATIENCE_S
        host.run(1.0)
        while len(host.boots) < 2 and time.monotonic() < until:
            host.run(0.1)
        quiet = board.next_truth()
        highest_mn = max(now["drive_mn"] for now in board.since(start["t_us"]))
        host.run(1.0, 3000)
        armed = board.next_truth()
    finally:
        host.close()
    said = (
        f"boot {before['boot']} -> {quiet['boot']}, reset reason {quiet['reset']} (pin), host told {host.boots}; drive {highest_mn} mN"
        f" for {quiet['t_us'] / 1e6:.1f} s, force {before['applied_mn']} -> {quiet['applied_mn']} mN; armed again: drive"
        f" {armed['drive_mn']} mN or fault {armed['fault']:04x}"
    )
    must(quiet["reset"] == PIN and host.boots == [before["boot"], quiet["boot"]], said)
    must(highest_mn == 0 and quiet["applied_mn"] == 0, said)
    # The object fell when the torque was off: pressing on nothing is found out (R8).
    must(armed["drive_mn"] == 3000 or armed["fault"] == 0x0201, said)
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
    """R6, R7: a stylus that no longer moves is no fault while the travel has readings; without both it is a latched minor
    fault: the force is held and takes no commands."""
    board.fresh()
    host = Host(board)
    try:
        held(board, host)
        before = forget_peak(board)
        board.order("f")
        host.run(0.3, 7000)
        alone = board.next_truth()
        must(alone["fault"] == 0 and alone["state"] == ACTIVE, f"a fault although the travel has readings: {alone}")
        before = alone
        board.order("t")
        host.run(0.3, 7000)
        told = [now for now in board.since(before["t_us"]) if now["fault"] == 0x0102]
        must(bool(told), f"no fault within 0.3 s: {board.truth}")
        fault = told[0]
        host.run(0.5, 12_000)
        after, peak = board.next_truth(), highest(board, before)
    finally:
        host.close()
    said = (
        f"fault {fault['fault']:04x} at most {(fault['t_us'] - before['t_us']) / 1000:.0f} ms after the travel was lost too, state {after['state']};"
        f" 12 N commanded then: {after['rejected'] - before['rejected']} rejected, peak {peak} mN of 7000 mN"
    )
    must(after["state"] == FAULT and after["fault"] == 0x0102 and peak <= 7000 + NEAR_MN, said)
    must(after["rejected"] > before["rejected"] and abs(after["applied_mn"] - 7000) <= NEAR_MN, said)
    return said


LATEST_RESET_MS = 2000


def hung(board: Board, order: str, name: str) -> str:
    """R9: one task no longer runs. The watchdog resets in time (three tries, because the time is this computer's, which may
    be busy), the reason says so, and the fingers are passive."""
    for _ in range(2):
        said, took_ms = hang(board, order, name)
        if took_ms <= LATEST_RESET_MS:
            return said
        print(f"     {said}: late, once more", flush=True)
    said, took_ms = hang(board, order, name)
    must(took_ms <= LATEST_RESET_MS, said)
    return said


def hang(board: Board, order: str, name: str) -> tuple[str, float]:
    """One try: what happened, and the time from the order to the reset (ms)."""
    board.fresh()
    host = Host(board)
    try:
        before = held(board, host)
        began = time.monotonic()
        board.order(order)
        while board.truth["boot"] == before["boot"] and time.monotonic() - began < PATIENCE_S:
            host.run(0.005)  # a host that went on commanding would arm it again
        took_ms = (time.monotonic() - began) * 1000
        must(board.truth["boot"] == before["boot"] + 1, f"{name} hangs: no reset within {took_ms:.0f} ms")
        time.sleep(0.2)
        after = board.next_truth()
        highest_mn = max(now["drive_mn"] for now in board.since(0))
    finally:
        host.close()
    said = f"{name} hangs: reset after {took_ms:.0f} ms, reason {after['reset']} (watchdog), state {after['state']}, drive {highest_mn} mN"
    must(after["reset"] == WATCHDOG and highest_mn == 0 and after["state"] in (IDLE, LINKED, ARMED), said)
    must(took_ms >= 100, said)
    return said, took_ms
