//! What a client may ask for.

use crate::{FaultCode, Operation};

/// What a client may ask for where the configuration allows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClientCommand {
    /// Hold with at least this force (N), within the limits in force; the answer to a slip stays free to press harder. 0 takes it back.
    AtLeast(f32),
    /// Let go: the fingers open until [`ClientCommand::Grasp`].
    Release,
    /// Close again after a release.
    Grasp,
    /// Stop in software; latched by the gripper. Not a safety function.
    Stop,
    /// Expect an object that is known to be held with this force (N), margin included: the next grasps begin with it. 0: nothing is known.
    Expect(f32),
    /// Clear this fault.
    ClearFault(FaultCode),
}

impl ClientCommand {
    /// Which operation it is.
    #[must_use]
    pub const fn operation(self) -> Operation {
        match self {
            Self::AtLeast(_) => Operation::AtLeast,
            Self::Release => Operation::Release,
            Self::Grasp => Operation::Grasp,
            Self::Stop => Operation::Stop,
            Self::Expect(_) => Operation::Expect,
            Self::ClearFault(_) => Operation::ClearFault,
        }
    }

    /// The fault it is about; none where it is about none.
    #[must_use]
    pub const fn fault(self) -> FaultCode {
        if let Self::ClearFault(fault) = self { fault } else { FaultCode::NONE }
    }
}

impl core::fmt::Display for ClientCommand {
    /// In words: `hold with at least 2.50 N`, `release`, `clear fault 0201`.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::AtLeast(force_n) => write!(f, "hold with at least {force_n:.2} N"),
            Self::Expect(force_n) => write!(f, "expect an object that needs {force_n:.2} N"),
            Self::ClearFault(fault) => write!(f, "clear fault {:04x}", fault.0),
            Self::Release | Self::Grasp | Self::Stop => f.write_str(self.operation().name()),
        }
    }
}
