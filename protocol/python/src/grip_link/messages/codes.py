"""Numbers of the wire in, their names out. Open codes keep a number they do not know, as ``OTHER_n``."""

from __future__ import annotations

from enum import IntEnum, IntFlag


class OpenCode(IntEnum):
    """Codes to which later protocols may add; every other number gets a nameless member."""

    @classmethod
    def _missing_(cls, value: object) -> OpenCode:
        if not isinstance(value, int) or not 0 <= value <= 0xFFFF:
            raise ValueError(f"{value!r} is no code of {cls.__name__}")
        member = int.__new__(cls, value)
        member._name_ = f"OTHER_{value}"
        member._value_ = value
        return member


class Kind(OpenCode):
    """Message types."""

    HELLO = 0x01
    CONFIG = 0x03
    START = 0x04
    STOP = 0x05
    PING = 0x06
    GRIP = 0x10
    HEARTBEAT = 0x11
    ESTOP = 0x12
    CLEAR_FAULT = 0x13
    IDENT = 0x81
    CONFIG_ACK = 0x83
    PONG = 0x86
    ACK = 0x8E
    NACK = 0x8F
    SAMPLES = 0x90
    STATUS = 0x91
    STATS = 0x92
    EVENT = 0x93
    LOG = 0x94
    WELCOME = 0xA0
    SLIP = 0xA1
    STATE = 0xA2
    HEALTH = 0xA3
    GRIPPER = 0xA4
    ROWS = 0xA5
    NOTICE = 0xA6
    SETUP = 0xA7
    SUBSCRIBE = 0xA8
    COMMAND = 0xA9
    QUERY = 0xAA
    LOAD = 0xAB
    OBJECT = 0xAC
    SHADOW = 0xAD
    ESTIMATES = 0xAE


class DeviceState(OpenCode):
    """States of the microcontroller."""

    BOOT = 0
    IDLE = 1
    LINKED = 2
    ARMED = 3
    ACTIVE = 4
    HOLD = 5
    LOSS_ACTION = 6
    FAULT = 7
    ESTOP = 8


class ResetReason(OpenCode):
    """Why the microcontroller started."""

    UNKNOWN = 0
    POWER_ON = 1
    PIN = 2
    WATCHDOG = 3
    SOFTWARE = 4
    BROWNOUT = 5


class ChannelKind(OpenCode):
    """What a channel measures."""

    STYLUS = 1
    NORMAL_FORCE = 2
    TANGENTIAL_FORCE = 3
    TRAVEL = 4
    VELOCITY = 5
    SECOND_STYLUS = 6
    REFERENCE = 7
    PRESSURE = 8
    PRESSURE_ARRAY = 9


class Unit(OpenCode):
    """Unit of a channel after scaling."""

    NONE = 0
    METRE = 1
    NEWTON = 2
    METRE_PER_SECOND = 3
    METRE_PER_SECOND2 = 4
    PASCAL = 5


class SampleFormat(IntEnum):
    """How the elements of a row stand in SAMPLES."""

    I16 = 0
    """value = raw * scale of the channel; raw -32768 means no reading."""
    F32 = 1
    """In the channel's unit, the scale is not applied; NaN means no reading."""

    @property
    def size(self) -> int:
        """Bytes of one element."""
        return 2 if self is SampleFormat.I16 else 4


class LossAction(IntEnum):
    """What the gripper does when no command came for ttl + loss_after."""

    HOLD = 0
    OPEN = 1
    PASSIVE = 2


class GripMode(IntEnum):
    """What a GRIP asks for; 0 is no mode."""

    FORCE = 1
    OPEN = 2
    PASSIVE = 3


class NackReason(OpenCode):
    """Why a request was refused."""

    UNKNOWN_TYPE = 1
    MALFORMED = 2
    WRONG_STATE = 3
    LATCHED = 4
    OTHER_FAULT = 5
    VERSION = 6
    FORBIDDEN = 7
    TOKEN = 8
    BUSY = 9


class EventKind(OpenCode):
    """What an EVENT tells."""

    STATE = 1
    FAULT = 2
    FAULT_CLEARED = 3
    COMMAND_REJECTED = 4


class LogLevel(OpenCode):
    """Weight of a LOG."""

    ERROR = 0
    WARN = 1
    INFO = 2
    DEBUG = 3


class FaultCode(OpenCode):
    """Latched faults; 0 = none, a code that is not listed is major."""

    NONE = 0
    ESTOP = 0x0001
    SENSOR_DEAD = 0x0101
    SENSOR_FROZEN = 0x0102
    SENSOR_SATURATED = 0x0103
    TASK_HUNG = 0x0104
    OBJECT_LOST = 0x0201
    POSITION_UNDEFINED = 0x0202
    OVER_TEMPERATURE = 0x0203
    OVER_CURRENT = 0x0204
    DRIVE = 0x0205
    SUPPLY = 0x0206

    @property
    def holds(self) -> bool:
        """Minor faults (0001, 0101..0104) hold the force; every other code takes the torque off."""
        return self == 0x0001 or 0x0101 <= self <= 0x0104


class Clamped(IntFlag):
    """Fields of CONFIG that the microcontroller changed."""

    RATE = 1
    BATCH = 2
    MASK = 4
    FORCE_MAX = 8
    SLEW = 16
    TTL = 32
    HOLD_CAP = 64
    LOSS_DELAY = 128


class ForceClamp(IntFlag):
    """What the force guard did to the last command."""

    FORCE = 1
    SLEW = 2
    TTL = 4
    REJECTED = 8
    HOLD_CAP = 16
    TRAVEL = 32


class StatusFlags(IntFlag):
    """Flags of STATUS."""

    SAMPLING = 1
    DROPPING = 2
    PASSIVE = 4
    OPEN = 8
    NO_COMMAND = 16
    MOTION = 32
    MOVING = 64
