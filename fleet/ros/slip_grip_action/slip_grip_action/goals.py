"""What a goal asks of gripd. Needs no ROS."""

import math

from grip_link.messages.daemon import Operation

MOST_MN = 2**31 - 1
"""What a command of gripd can hold (mN)."""


def commands(position, effort, open_above):
    """Operations and their forces (mN), in their order. ``position`` and ``effort`` are those of a JointState, each of one joint; without an
    effort the least force stays what it is. Raises ValueError where they are not numbers of a gripper: nothing may move then."""
    if len(position) != 1 or not math.isfinite(position[0]):
        raise ValueError(f"a position of one joint is needed: {list(position)}")
    if len(effort) > 1 or not all(math.isfinite(force_n) and 0 <= 1000 * force_n <= MOST_MN for force_n in effort):
        raise ValueError(f"one effort is the most, a force of 0 N or more: {list(effort)}")
    if position[0] > open_above:
        return [(Operation.RELEASE, 0)]
    # First what gripd may refuse: a force above the largest one must not close the fingers.
    return [(Operation.AT_LEAST, round(1000 * force_n)) for force_n in effort] + [(Operation.GRASP, 0)]
