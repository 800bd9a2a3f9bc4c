"""A gripper of one Feetech servo on gripd, without LeRobot: bus, bridge, and a simulated SO-101."""
