"""GRIP and STATUS: the force wanted and the force that is."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from .codes import DeviceState, FaultCode, ForceClamp, StatusFlags
from .wire import pack, unpack

_GRIP = struct.Struct("<IBBHiII")
_STATUS = struct.Struct("<IBBHiiIHH")

ANSWERS_SLIP = 1


@dataclass(frozen=True)
class Grip:
    """GRIP (10), host to MCU, 20 bytes: an absolute set point, sent every cycle. u32 cmd_id, u8 mode, u8 flags
    (b0 answers a slip), u16 ttl, i32 force, u32 slew, u32 sample index that caused it. ``mode`` is the bare number:
    the MCU judges it."""

    cmd_id: int
    mode: int
    flags: int
    ttl_ms: int
    force_mn: int
    slew_mn_s: int
    cause_sample: int

    @classmethod
    def parse(cls, payload: bytes) -> Grip:
        """Reads a payload; raises PayloadError."""
        return cls(*unpack(_GRIP, payload))

    def pack(self) -> bytes:
        """The 20 payload bytes."""
        return pack(
            _GRIP, self.cmd_id, self.mode, self.flags, self.ttl_ms, self.force_mn, self.slew_mn_s, self.cause_sample
        )


@dataclass(frozen=True)
class Status:
    """STATUS (91), MCU to host, 24 bytes: at least every 10 ms and after every GRIP. u32 cmd_id of the newest accepted
    GRIP, u8 state, u8 clamp, u16 fault, i32 applied, i32 target, u32 age of that GRIP, u16 flags, u16 rejected."""

    last_cmd_id: int
    state: DeviceState
    clamp: ForceClamp
    fault: FaultCode
    applied_mn: int
    """Force set at the actuator now, or measured where the gripper can [mN]."""
    target_mn: int
    """Force aimed at [mN]."""
    age_us: int
    """Age of the newest accepted GRIP [us], saturating."""
    flags: StatusFlags
    rejected: int
    """GRIPs rejected since the start, wrapping."""

    @classmethod
    def parse(cls, payload: bytes) -> Status:
        """Reads a payload; raises PayloadError."""
        cmd_id, state, clamp, fault, applied, target, age, flags, rejected = unpack(_STATUS, payload)
        return cls(
            cmd_id, DeviceState(state), ForceClamp(clamp), FaultCode(fault), applied, target, age, StatusFlags(flags), rejected
        )

    def pack(self) -> bytes:
        """The 24 payload bytes."""
        return pack(
            _STATUS, self.last_cmd_id, self.state, self.clamp, self.fault, self.applied_mn, self.target_mn, self.age_us,
            self.flags, self.rejected,
        )  # fmt: skip
