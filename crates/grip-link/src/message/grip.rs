//! GRIP and STATUS: the force wanted and the force that is.

use super::DeviceState;
use super::FaultCode;
use super::wire::{PayloadError, Reader, Writer};

/// GRIP (10), host to MCU: an absolute set point, sent every cycle. Not acknowledged: STATUS.last_cmd_id says what
/// arrived.
///
/// | offset | size | type | field | unit, range |
/// |---|---|---|---|---|
/// | 0 | 4 | u32 | cmd_id | +1 a command, wraps; older or equal is ignored |
/// | 4 | 1 | u8 | mode | `GripMode` code; others are rejected |
/// | 5 | 1 | u8 | flags | b0 the command answers a slip, others 0 |
/// | 6 | 2 | u16 | ttl | ms, 0 = that of CONFIG, else clamped to 20..=100 |
/// | 8 | 4 | i32 | force | mN, 0..= F_max; above is clamped, negative is rejected |
/// | 12 | 4 | u32 | slew | mN/s, 0 = that of CONFIG, above it is clamped |
/// | 16 | 4 | u32 | sample index that caused the command | |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grip {
    /// Command number.
    pub cmd_id: u32,
    /// Mode code as on the wire; the MCU rejects what `GripMode::from_code` does not know.
    pub mode: u8,
    /// b0 answers a slip.
    pub flags: u8,
    /// Life \[ms\].
    pub ttl_ms: u16,
    /// Force \[mN\].
    pub force_mn: i32,
    /// Change of force \[mN/s\].
    pub slew_mn_s: u32,
    /// Sample index that caused it.
    pub cause_sample: u32,
}

impl Grip {
    /// Bytes of the payload.
    pub const SIZE: usize = 20;
    /// Flag: the command answers a slip.
    pub const ANSWERS_SLIP: u8 = 1;

    /// Reads a payload; values outside their range are judged by the force guard of the MCU.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        Ok(Self {
            cmd_id: r.u32()?,
            mode: r.u8()?,
            flags: r.u8()?,
            ttl_ms: r.u16()?,
            force_mn: r.i32()?,
            slew_mn_s: r.u32()?,
            cause_sample: r.u32()?,
        })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out).u32(self.cmd_id).u8(self.mode).u8(self.flags).u16(self.ttl_ms);
        w.i32(self.force_mn).u32(self.slew_mn_s).u32(self.cause_sample).finish()
    }
}

/// What the force guard did to the last command: a bit set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ForceClamp(pub u8);

impl ForceClamp {
    /// b0: force over F_max.
    pub const FORCE: Self = Self(1);
    /// b1: slew over that of CONFIG.
    pub const SLEW: Self = Self(2);
    /// b2: ttl outside 20..=100 ms.
    pub const TTL: Self = Self(4);
    /// b3: the command was rejected: negative force, unknown mode or not armed.
    pub const REJECTED: Self = Self(8);
    /// b4: the hold cap limits the force.
    pub const HOLD_CAP: Self = Self(16);
    /// b5: the fingers are at the end of their travel.
    pub const TRAVEL: Self = Self(32);

    /// Whether all bits of `other` are set.
    #[must_use]
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// With the bits of `other` too, when `on`.
    #[must_use]
    pub const fn with(self, other: Self, on: bool) -> Self {
        if on { Self(self.0 | other.0) } else { self }
    }
}

/// Flags of STATUS: a bit set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StatusFlags(pub u16);

impl StatusFlags {
    /// b0: samples are being sent.
    pub const SAMPLING: Self = Self(1);
    /// b1: batches were dropped since the last STATUS.
    pub const DROPPING: Self = Self(2);
    /// b2: the torque is off.
    pub const PASSIVE: Self = Self(4);
    /// b3: opening or open.
    pub const OPEN: Self = Self(8);
    /// b4: no command was accepted since CONFIG; `last_cmd_id` and `age` mean nothing.
    pub const NO_COMMAND: Self = Self(16);
    /// b5: the gripper tells its motion, so that a missing `MOVING` means standing still.
    pub const MOTION: Self = Self(32);
    /// b6: the fingers travel without pressing on anything, or the gripper knows that the arm moves.
    pub const MOVING: Self = Self(64);

    /// Whether all bits of `other` are set.
    #[must_use]
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// With the bits of `other` too, when `on`.
    #[must_use]
    pub const fn with(self, other: Self, on: bool) -> Self {
        if on { Self(self.0 | other.0) } else { self }
    }
}

/// STATUS (91), MCU to host: at least every 10 ms and after every GRIP.
///
/// | offset | size | type | field | unit, range |
/// |---|---|---|---|---|
/// | 0 | 4 | u32 | cmd_id of the newest accepted GRIP | |
/// | 4 | 1 | u8 | state | [`DeviceState`] code |
/// | 5 | 1 | u8 | clamp | [`ForceClamp`] |
/// | 6 | 2 | u16 | fault | [`FaultCode`], 0 = none |
/// | 8 | 4 | i32 | applied: force set at the actuator now, or measured where the gripper can | mN |
/// | 12 | 4 | i32 | target: force aimed at | mN |
/// | 16 | 4 | u32 | age of the newest accepted GRIP | us, saturates |
/// | 20 | 2 | u16 | flags | [`StatusFlags`] |
/// | 22 | 2 | u16 | GRIPs rejected since the start | wraps |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status {
    /// Newest accepted GRIP.
    pub last_cmd_id: u32,
    /// State.
    pub state: DeviceState,
    /// What was clamped.
    pub clamp: ForceClamp,
    /// Latched fault.
    pub fault: FaultCode,
    /// Force now \[mN\].
    pub applied_mn: i32,
    /// Force aimed at \[mN\].
    pub target_mn: i32,
    /// Age of the newest GRIP \[us\].
    pub age_us: u32,
    /// Flags.
    pub flags: StatusFlags,
    /// GRIPs rejected.
    pub rejected: u16,
}

impl Status {
    /// Bytes of the payload.
    pub const SIZE: usize = 24;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        Ok(Self {
            last_cmd_id: r.u32()?,
            state: DeviceState::from_code(r.u8()?),
            clamp: ForceClamp(r.u8()?),
            fault: FaultCode(r.u16()?),
            applied_mn: r.i32()?,
            target_mn: r.i32()?,
            age_us: r.u32()?,
            flags: StatusFlags(r.u16()?),
            rejected: r.u16()?,
        })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out)
            .u32(self.last_cmd_id)
            .u8(self.state.code())
            .u8(self.clamp.0)
            .u16(self.fault.0);
        let w = w.i32(self.applied_mn).i32(self.target_mn).u32(self.age_us);
        w.u16(self.flags.0).u16(self.rejected).finish()
    }
}
