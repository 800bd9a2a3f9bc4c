//! Fault codes in, what the gripper does about them out.

/// A latched fault, as on the wire; 0 = none. A code that is not listed is major.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FaultCode(pub u16);

/// What a fault does to the force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Reaction {
    /// Stay at the present force, at most the hold cap.
    Hold,
    /// Torque off.
    Passive,
}

impl FaultCode {
    /// 0000: no fault.
    pub const NONE: Self = Self(0);
    /// 0001: ESTOP was received.
    pub const ESTOP: Self = Self(0x0001);
    /// 0101: the last slip sensor delivers nothing.
    pub const SENSOR_DEAD: Self = Self(0x0101);
    /// 0102: the last slip sensor delivers the same value for too long.
    pub const SENSOR_FROZEN: Self = Self(0x0102);
    /// 0103: the last slip sensor is at the end of its range.
    pub const SENSOR_SATURATED: Self = Self(0x0103);
    /// 0104: one task of the firmware did not run.
    pub const TASK_HUNG: Self = Self(0x0104);
    /// 0201: the object is gone.
    pub const OBJECT_LOST: Self = Self(0x0201);
    /// 0202: the finger position is not known.
    pub const POSITION_UNDEFINED: Self = Self(0x0202);
    /// 0203: motor or driver too hot.
    pub const OVER_TEMPERATURE: Self = Self(0x0203);
    /// 0204: motor current too high.
    pub const OVER_CURRENT: Self = Self(0x0204);
    /// 0205: the motor driver reports a fault.
    pub const DRIVE: Self = Self(0x0205);
    /// 0206: supply voltage out of range.
    pub const SUPPLY: Self = Self(0x0206);

    /// Whether there is one.
    #[must_use]
    pub const fn is_fault(self) -> bool {
        self.0 != 0
    }

    /// Minor faults (0001, 0101..0104) hold; every other code, known or not, takes the torque off.
    #[must_use]
    pub const fn reaction(self) -> Reaction {
        match self.0 {
            0x0001 | 0x0101..=0x0104 => Reaction::Hold,
            _ => Reaction::Passive,
        }
    }
}
