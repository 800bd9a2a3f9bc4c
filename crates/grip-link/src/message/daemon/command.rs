//! COMMAND: a client wants the gripper to do something.

use super::Operation;
use crate::message::FaultCode;
use crate::message::wire::{PayloadError, Reader, Writer};

/// COMMAND (A9), client to daemon.
///
/// | offset | size | type | field | unit, range |
/// |---|---|---|---|---|
/// | 0 | 1 | u8 | operation | [`Operation`] code; an unknown one is malformed |
/// | 1 | 1 | | reserved, 0 | |
/// | 2 | 2 | u16 | fault, of `ClearFault` | [`FaultCode`] |
/// | 4 | 4 | i32 | force, of `AtLeast` | mN, not negative |
/// | 8 | 4 | u32 | token, of `Release` | that of WELCOME |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Command {
    /// What to do.
    pub operation: Operation,
    /// The fault to clear.
    pub fault: FaultCode,
    /// The force to hold with (mN).
    pub force_mn: i32,
    /// That of WELCOME.
    pub token: u32,
}

impl Command {
    /// Bytes of the payload.
    pub const SIZE: usize = 12;

    /// An operation without force, fault and token.
    #[must_use]
    pub const fn new(operation: Operation) -> Self {
        Self { operation, fault: FaultCode::NONE, force_mn: 0, token: 0 }
    }

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError`]: too short, an unknown operation, or a negative force.
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        let operation = r.coded(Operation::from_code)?;
        let _reserved = r.u8()?;
        let fault = FaultCode(r.u16()?);
        let force_mn = r.i32()?;
        if force_mn < 0 {
            return Err(PayloadError::Value { at: 4, value: i64::from(force_mn) });
        }
        Ok(Self { operation, fault, force_mn, token: r.u32()? })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out).u8(self.operation.code()).u8(0).u16(self.fault.0);
        w.i32(self.force_mn).u32(self.token).finish()
    }
}
