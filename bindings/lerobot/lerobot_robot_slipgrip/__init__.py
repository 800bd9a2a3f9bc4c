"""An SO-101 of LeRobot whose gripper feels slip: found by its name, ``--robot.type=slipgrip``."""

from .robot import SlipGrip, SlipGripConfig

__all__ = ["SlipGrip", "SlipGripConfig"]
