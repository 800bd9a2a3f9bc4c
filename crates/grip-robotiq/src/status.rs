//! Meaning of the three status registers.

use core::fmt;

/// Contact of the fingers (gOBJ); it counts only while the gripper follows a position (gGTO).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObjectDetection {
    /// The fingers move.
    Moving,
    /// They were stopped while opening.
    Outside,
    /// They were stopped while closing: an object is between them.
    Inside,
    /// They are where they were to go: there is no object, or it was lost.
    Arrived,
}

/// A fault of the gripper (gFLT), or of Robotiq's controller before it (kFLT).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// gFLT, 1 to 15.
    Gripper(u8),
    /// kFLT, 1 to 15.
    Controller(u8),
}

/// How grave a fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The gripper goes on.
    Passing,
    /// It takes no command until the fault has gone by itself.
    Minor,
    /// It takes no command until it is reset and activated again, which opens the fingers.
    Major,
}

/// What the gripper reports of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// Its activation bit is set (gACT).
    pub activated: bool,
    /// It follows the requested position (gGTO).
    pub follows: bool,
    /// Activation is complete (gSTA is 3).
    pub complete: bool,
    /// Contact.
    pub object: ObjectDetection,
    /// The gravest fault.
    pub fault: Option<Fault>,
    /// Echo of the requested position: 0 open, 255 closed.
    pub requested: u8,
    /// Position: about 3 open, about 230 closed on a 2F-85.
    pub position: u8,
    /// Motor current (mA).
    pub current_ma: u16,
}

impl Status {
    /// Reads the registers 0x07D0 to 0x07D2.
    #[must_use]
    pub fn read(registers: [u16; 3]) -> Self {
        let [[state, _], [fault, requested], [position, current]] = registers.map(u16::to_be_bytes);
        let object = match state >> 6 {
            0 => ObjectDetection::Moving,
            1 => ObjectDetection::Outside,
            2 => ObjectDetection::Inside,
            _ => ObjectDetection::Arrived,
        };
        let gripper = Some(fault & 15).filter(|code| *code > 0).map(Fault::Gripper);
        let controller = Some(fault >> 4).filter(|code| *code > 0).map(Fault::Controller);
        let grave = |fault: &Fault| fault.severity() == Severity::Major;
        Self {
            activated: state & 1 != 0,
            follows: state & 8 != 0,
            complete: state >> 4 & 3 == 3,
            object,
            fault: controller.filter(grave).or(gripper).or(controller),
            requested,
            position,
            current_ma: 10 * u16::from(current),
        }
    }

    /// Whether the fingers are on their way.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.follows && self.object == ObjectDetection::Moving
    }

    /// Whether something stops the fingers.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.follows && matches!(self.object, ObjectDetection::Inside | ObjectDetection::Outside)
    }
}

impl Fault {
    /// How grave it is. A code that the manual does not name is major.
    #[must_use]
    pub const fn severity(self) -> Severity {
        match self {
            // The time without a request is over with the request that reads this.
            Self::Gripper(0x05 | 0x07 | 0x09) | Self::Controller(0x04) => Severity::Passing,
            Self::Gripper(0x08) | Self::Controller(0x05 | 0x09) => Severity::Minor,
            Self::Gripper(_) | Self::Controller(_) => Severity::Major,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (register, code, name) = match *self {
            Self::Gripper(code) => ("gFLT", code, gripper_fault(code)),
            Self::Controller(code) => ("kFLT", code, controller_fault(code)),
        };
        write!(f, "{name} ({register} 0x{code:02X})")
    }
}

fn gripper_fault(code: u8) -> &'static str {
    match code {
        0x05 => "an action waits for the end of the activation",
        0x07 => "not activated",
        0x08 => "too hot",
        0x09 => "no request for a second",
        0x0A => "supply voltage too low",
        0x0B => "automatic release in progress",
        0x0C => "internal fault",
        0x0D => "activation failed",
        0x0E => "motor current too high",
        0x0F => "automatic release completed",
        _ => "unknown fault",
    }
}

fn controller_fault(code: u8) -> &'static str {
    match code {
        0x04 => "the controller has no 24 V",
        0x05 => "the controller finds no gripper",
        0x09 => "the controller is starting",
        0x0C => "emergency stop of the controller",
        0x0E => "current of the controller too high",
        _ => "unknown fault of the controller",
    }
}

#[cfg(test)]
mod tests {
    use super::{Fault, ObjectDetection, Severity, Status};

    #[test]
    fn the_status_of_the_manual_is_read() {
        // Robotiq, 2F-85 & 2F-140 instruction manual, Modbus RTU example, step 8: open fingers.
        let status = Status::read([0xF900, 0x0000, 0x0D00]);
        assert!(status.activated && status.follows && status.complete && !status.moves());
        assert_eq!((status.object, status.position), (ObjectDetection::Arrived, 13));
        assert_eq!(status.fault, None);
        let holds = Status::read([0xB900, 0x00FF, 0x6421]);
        assert!(holds.holds() && holds.current_ma == 330 && holds.requested == 255);
        assert!(Status::read([0x3900, 0, 0]).moves());
        assert!(!Status::read([0x3100, 0, 0]).moves(), "a gripper that does not follow");
    }

    #[test]
    fn a_code_that_nobody_knows_is_grave() {
        let fault = |byte: u16| Status::read([0xF900, byte << 8, 0]).fault;
        assert_eq!(fault(0x09).map(Fault::severity), Some(Severity::Passing));
        assert_eq!(fault(0x08).map(Fault::severity), Some(Severity::Minor));
        assert_eq!(fault(0x0E).map(Fault::severity), Some(Severity::Major));
        assert_eq!(fault(0x03).map(Fault::severity), Some(Severity::Major));
        assert_eq!(fault(0xC9), Some(Fault::Controller(0x0C)), "the gravest one");
        assert_eq!(fault(0x49), Some(Fault::Gripper(0x09)));
        assert!(fault(0x0E).unwrap().to_string().contains("current too high (gFLT 0x0E)"));
    }
}
