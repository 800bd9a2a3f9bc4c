//! Codes of the wire in, states and reset reasons of the microcontroller out.

/// State of the microcontroller; the number is the code on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum DeviceState {
    /// 0: starting, actuator passive.
    Boot,
    /// 1: waiting for HELLO.
    Idle,
    /// 2: session known.
    Linked,
    /// 3: CONFIG accepted.
    Armed,
    /// 4: a fresh GRIP is followed.
    Active,
    /// 5: the last GRIP is older than its ttl.
    Hold,
    /// 6: the loss action was taken.
    LossAction,
    /// 7: latched fault.
    Fault,
    /// 8: latched stop.
    Estop,
    /// A code of a later protocol.
    Other(u8),
}

impl DeviceState {
    /// From the wire.
    #[must_use]
    pub const fn from_code(code: u8) -> Self {
        match code {
            0 => Self::Boot,
            1 => Self::Idle,
            2 => Self::Linked,
            3 => Self::Armed,
            4 => Self::Active,
            5 => Self::Hold,
            6 => Self::LossAction,
            7 => Self::Fault,
            8 => Self::Estop,
            other => Self::Other(other),
        }
    }

    /// To the wire.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Boot => 0,
            Self::Idle => 1,
            Self::Linked => 2,
            Self::Armed => 3,
            Self::Active => 4,
            Self::Hold => 5,
            Self::LossAction => 6,
            Self::Fault => 7,
            Self::Estop => 8,
            Self::Other(code) => code,
        }
    }
}

/// Why the microcontroller started; the number is the code on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ResetReason {
    /// 0: not known.
    Unknown,
    /// 1: power came on.
    PowerOn,
    /// 2: reset pin, or the port was opened.
    Pin,
    /// 3: watchdog.
    Watchdog,
    /// 4: the firmware asked for it.
    Software,
    /// 5: supply voltage too low.
    Brownout,
    /// A code of a later protocol.
    Other(u8),
}

impl ResetReason {
    /// From the wire.
    #[must_use]
    pub const fn from_code(code: u8) -> Self {
        match code {
            0 => Self::Unknown,
            1 => Self::PowerOn,
            2 => Self::Pin,
            3 => Self::Watchdog,
            4 => Self::Software,
            5 => Self::Brownout,
            other => Self::Other(other),
        }
    }

    /// To the wire.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Unknown => 0,
            Self::PowerOn => 1,
            Self::Pin => 2,
            Self::Watchdog => 3,
            Self::Software => 4,
            Self::Brownout => 5,
            Self::Other(code) => code,
        }
    }
}
