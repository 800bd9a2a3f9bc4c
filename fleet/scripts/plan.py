#!/usr/bin/env python3
"""The tree of docs/plan.md as queues, with what a message costs as `scale` measured it.

Usage: scripts/plan.py [--grippers 10000] [--halls 20] [--router-us 71] [--receiver-us 143] [--outage 60] [--seed 1]

Each gripper sends 0.4 events a second at random times, in frames of 10 ms, and HEALTH every second. A message passes the router of its
hall, where the receiver of the hall takes it, and one of two routers of the plant, behind which one archive takes everything. Each of
these serves one message at a time, in the order in which they come. Then the line between halls and plant is away for --outage seconds:
events wait in the spools, and the archive asks for them in pieces of 256, 32 grippers at once, beside what goes on. Nothing of the network
itself is in it: no loss, no handshake, no retry.
"""

import argparse
import random

EVENTS_HZ, HEALTH_HZ, FRAME_S, PIECE, AT_ONCE = 0.4, 1.0, 0.01, 256, 32


def serve(arrivals, service_s):
    """Pairs (time, mark), sorted; the same with the times at which each was served, and the share of the time that was work."""
    free, served = 0.0, []
    for time, mark in arrivals:
        free = max(free, time) + service_s
        served.append((free, mark))
    span = arrivals[-1][0] - arrivals[0][0]
    return served, len(arrivals) * service_s / span


def messages(grippers, seconds, rng):
    """(time it was sent, (time it happened, gripper, whether it is an event))"""
    made = []
    for gripper in range(grippers):
        frame = rng.random() * FRAME_S
        time = rng.expovariate(EVENTS_HZ)
        while time < seconds:
            sent = frame + FRAME_S * (int((time - frame) / FRAME_S) + 1)
            made.append((sent, (time, gripper, True)))
            time += rng.expovariate(EVENTS_HZ)
        time = rng.random() / HEALTH_HZ
        while time < seconds:
            made.append((time, (time, gripper, False)))
            time += 1 / HEALTH_HZ
    return sorted(made)


def quantiles(served):
    late = sorted(1e3 * (time - mark[0]) for time, mark in served if mark[2])
    return f"p50 {late[len(late) // 2]:.1f}, p99 {late[len(late) * 99 // 100]:.1f}, longest {late[-1]:.1f} ms"


def through(arrivals, count, service_s, which):
    """Through `count` servers beside each other, chosen by the gripper."""
    parts = [[] for _ in range(count)]
    for message in arrivals:
        parts[which(message[1][1])].append(message)
    served = [serve(part, service_s) for part in parts if part]
    return [part for part, _ in served], max(load for _, load in served)


def main(args):
    rng = random.Random(args.seed)
    router_s, receiver_s = args.router_us / 1e6, args.receiver_us / 1e6
    sent = messages(args.grippers, args.seconds, rng)
    print(f"{args.grippers} grippers, {args.halls} halls, {len(sent) / args.seconds:.0f} messages a second")
    halls, load = through(sent, args.halls, router_s, lambda gripper: gripper % args.halls)
    print(f"router of a hall: at most {100 * load:.0f} % of a core")
    receivers = [serve(hall, receiver_s) for hall in halls]
    load = max(load for _, load in receivers)
    print(f"receiver of a hall: at most {100 * load:.0f} %; events {quantiles([m for part, _ in receivers for m in part])}")
    plant = sorted(message for hall in halls for message in hall)
    plant, load = through(plant, 2, router_s, lambda gripper: gripper % args.halls % 2)
    print(f"a router of the plant: at most {100 * load:.0f} %")
    plant = sorted(message for part in plant for message in part)
    for name, events_only in [("archive of events and HEALTH", False), ("archive of events alone", True)]:
        taken = [message for message in plant if message[1][2] or not events_only]
        served, load = serve(taken, receiver_s)
        if load >= 1:
            print(f"{name}: {100 * load:.0f} % of a core: one is not enough")
        else:
            print(f"{name}: {100 * load:.0f} %; events {quantiles(served)}")
    # What waits after an outage, and what goes on beside it; the router has room for one piece of each that is asked at once.
    waiting = args.outage * EVENTS_HZ * args.grippers
    share = EVENTS_HZ * args.grippers * receiver_s
    if share < 1:
        seconds = waiting * receiver_s / (1 - share)
        print(f"{args.outage} s without the plant: {waiting:.0f} events wait, and have come {seconds:.0f} s after it (archive of events alone)")
    print(f"on the way at once: at most {AT_ONCE * PIECE * 400 / 1e6:.1f} MB of answers")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grippers", type=int, default=10_000)
    parser.add_argument("--halls", type=int, default=20)
    parser.add_argument("--seconds", type=int, default=30)
    parser.add_argument("--router-us", type=float, default=71)
    parser.add_argument("--receiver-us", type=float, default=143)
    parser.add_argument("--outage", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    main(parser.parse_args())
