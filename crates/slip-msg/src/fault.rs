//! Fault codes and what the gripper does about them.

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

macro_rules! faults {
    ($($code:literal $name:ident $doc:literal,)+) => {
        impl FaultCode {
            $(#[doc = concat!(stringify!($code), ": ", $doc)] pub const $name: Self = Self($code);)+
            /// Every code that is listed, with its name and meaning.
            pub const TABLE: &[(Self, &str, &str)] = &[$((Self::$name, stringify!($name), $doc)),+];
        }
    };
}

faults! {
    0x0000 NONE "no fault.",
    0x0001 ESTOP "ESTOP was received.",
    0x0101 SENSOR_DEAD "the last slip sensor delivers nothing.",
    0x0102 SENSOR_FROZEN "the last slip sensor delivers the same value for too long.",
    0x0103 SENSOR_SATURATED "the last slip sensor is at the end of its range.",
    0x0104 TASK_HUNG "a task of the firmware did not run.",
    0x0201 OBJECT_LOST "the object is gone.",
    0x0202 POSITION_UNDEFINED "the finger position is not known.",
    0x0203 OVER_TEMPERATURE "motor or driver too hot.",
    0x0204 OVER_CURRENT "motor current too high.",
    0x0205 DRIVE "the motor driver reports a fault.",
    0x0206 SUPPLY "supply voltage out of range.",
}

impl FaultCode {
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
