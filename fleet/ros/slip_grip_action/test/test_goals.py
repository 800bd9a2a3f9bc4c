"""Goals and what they become, without ROS: python test_goals.py, or pytest."""

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from grip_link.messages.daemon import Operation
from slip_grip_action.goals import commands

GRASP, RELEASE = (Operation.GRASP, 0), (Operation.RELEASE, 0)


def test_a_goal_becomes_commands():
    assert commands([0.08], [], 0.02) == [RELEASE]
    assert commands([0.08], [12.0], 0.02) == [RELEASE]
    # Without an effort what others have asked for stands.
    assert commands([0.02], [], 0.02) == commands([-1.0], (), 0.02) == [GRASP]
    # The least force first: where it is refused the fingers stay where they are.
    assert commands([0.0], [12.0004], 0.02) == [(Operation.AT_LEAST, 12_000), GRASP]
    assert commands([0.0], [0.0], 0.02) == [(Operation.AT_LEAST, 0), GRASP]


def test_what_is_no_number_of_a_gripper_moves_nothing():
    for position, effort in (
        *(([wrong], []) for wrong in (math.nan, math.inf, -math.inf)),
        *(([place], [wrong]) for place in (0.0, 0.08) for wrong in (math.nan, math.inf, -math.inf, -0.001, 2147483.7, 1e308)),
        ([], []),
        ([0.0, 0.0], []),
        ([0.0], [1.0, 2.0]),
    ):
        try:
            made = commands(position, effort, 0.02)
        except ValueError:
            continue
        raise AssertionError((position, effort, made))


if __name__ == "__main__":
    test_a_goal_becomes_commands()
    test_what_is_no_number_of_a_gripper_moves_nothing()
    print("goals: done")
