"""Codes of the messages between daemon and clients."""

from __future__ import annotations

from enum import IntEnum, IntFlag

from ..codes import OpenCode


class Phase(OpenCode):
    """How far a slip has come."""

    INCIPIENT = 1
    GROSS = 2
    ENDED = 3


class Method(OpenCode):
    """Which method noticed a slip."""

    NONE = 0
    STYLUS = 1
    TRAVEL = 2
    PRESSURE = 3


class SpeedSource(OpenCode):
    """Where a slip speed comes from."""

    NONE = 0
    FIXED = 1
    DIRECT = 2
    TRAVEL = 3
    TWO_STYLI = 4
    GRAVITY = 5


class EscKind(OpenCode):
    """A reading of E_sc."""

    NONE = 0
    LITERAL = 1
    ARC_COT = 2
    SLOPE_POWER = 3
    LIFT_WORK = 4
    VISCOUS_WORK = 5


class Scene(OpenCode):
    """What the grasp is doing."""

    IDLE = 0
    MOVING = 1
    HOLDING = 2
    SLIPPING = 3


class GripStage(OpenCode):
    """What the force controller does."""

    OBSERVING = 0
    OPEN = 1
    CLOSING = 2
    SETTLING = 3
    HOLDING = 4
    SLIPPING = 5
    FAULT = 6
    RELEASED = 7
    LOST = 8


class Sensor(OpenCode):
    """A sensor whose health is judged."""

    STYLUS = 1
    TRAVEL = 2
    PRESSURE = 3
    REFERENCE = 4


class SensorHealth(OpenCode):
    """State of a sensor."""

    GOOD = 0
    FROZEN = 1
    SATURATED = 2
    FAILED = 3
    DRIFTING = 4
    JUMPED = 5
    BACKWARDS = 6
    LOST = 7
    DOUBTED = 8
    COARSE = 9
    LATE = 10
    UNCOUPLED = 11
    ABSENT = 12


class LinkState(OpenCode):
    """State of the link between daemon and gripper."""

    CLOSED = 0
    OPEN = 1
    HELLO = 2
    CONFIG = 3
    STREAM = 4
    DEGRADED = 5


class Recording(OpenCode):
    """State of the recording."""

    OFF = 0
    RUNNING = 1
    STOPPED = 2


class RealTime(OpenCode):
    """What of real-time operation was granted."""

    NOT_ASKED = 0
    GRANTED = 1
    PARTLY = 2
    REFUSED = 3


class NoticeKind(OpenCode):
    """What a NOTICE is about."""

    DROPPED = 1
    SENSOR = 2
    LINK = 3
    CLIENT = 4
    GOODBYE = 5
    OBJECT = 6


class DroppedClass(OpenCode):
    """What dropped frames held."""

    ROWS = 1
    STATES = 2
    NEWS = 3


class Goodbye(OpenCode):
    """Why the daemon closes a connection."""

    VERSION = 1
    SILENT = 2
    STALLED = 3
    GARBAGE = 4
    FULL = 5
    ENDING = 6


class Operation(IntEnum):
    """What a client wants done."""

    AT_LEAST = 1
    RELEASE = 2
    GRASP = 3
    STOP = 4
    CLEAR_FAULT = 5
    EXPECT = 6


class Causes(IntFlag):
    """Causes of an alarm other than a slip."""

    KNOCK = 1
    MOTION = 2
    GRIP_CHANGE = 4
    CLOSING = 8
    ARM_STOP = 16


class Topics(IntFlag):
    """What a client wants to hear."""

    SLIP = 1
    STATE = 2
    HEALTH = 4
    NEWS = 8
    ESTIMATES = 16


class Unsure(IntFlag):
    """Which of two estimates may not move the fingers."""

    IN_FORCE = 1
    SHADOW = 2


class WelcomeFlags(IntFlag):
    """How the daemon runs."""

    COMMANDS = 1
    DRY_RUN = 2
    RECORDS = 4
    MODELS = 8


class RowSet(IntFlag):
    """The channels of a row, in the order of their values."""

    STYLUS = 1
    NORMAL_FORCE = 2
    TANGENTIAL_FORCE = 4
    TRAVEL = 8
    VELOCITY = 16
    SECOND_STYLUS = 32
    REFERENCE = 64
    PRESSURE = 128
    MOTION = 256
