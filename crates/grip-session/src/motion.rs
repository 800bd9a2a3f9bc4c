//! What the gripper reports of its motion and what it was commanded to do in; the commanded motion of a sample out.

use grip_link::message::{Status, StatusFlags};
use slip_core::grip::GripState;

/// What is known of the gripper's own motion between two STATUS.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OwnMotion {
    reported: Option<bool>,
    /// Commands are sent, so that the controller's state is what the fingers do.
    commands: bool,
}

impl OwnMotion {
    /// Nothing reported yet; `commands` states whether the controller's commands reach the gripper.
    #[must_use]
    pub fn new(commands: bool) -> Self {
        Self { reported: None, commands }
    }

    /// Takes a STATUS.
    pub fn receive(&mut self, status: &Status) {
        let reported = status.flags.has(StatusFlags::MOTION);
        self.reported = reported.then(|| status.flags.has(StatusFlags::MOVING));
    }

    /// The gripper has started anew: what it said before does not count.
    pub fn forget(&mut self) {
        self.reported = None;
    }

    /// The `motion` of a sample taken while the controller is in `state`: 1 while the gripper reports that it moves and while it is
    /// commanded to close, 0 where it reports that it stands still, `None` where nothing is known. The answer to a slip presses harder and is
    /// no motion.
    #[must_use]
    pub fn now(&self, state: Option<GripState>) -> Option<f32> {
        let closing = self.commands && state == Some(GripState::Closing);
        match self.reported {
            _ if closing => Some(1.0),
            Some(moving) => Some(f32::from(u8::from(moving))),
            None => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::OwnMotion;
    use grip_link::message::{DeviceState, FaultCode, ForceClamp, Status, StatusFlags};
    use slip_core::grip::GripState;

    fn status(flags: StatusFlags) -> Status {
        Status {
            last_cmd_id: 0,
            state: DeviceState::Armed,
            clamp: ForceClamp(0),
            fault: FaultCode::NONE,
            applied_mn: 0,
            target_mn: 0,
            age_us: 0,
            flags,
            rejected: 0,
        }
    }

    #[test]
    fn a_gripper_that_reports_is_believed_and_silence_is_not_stillness() {
        let mut motion = OwnMotion::new(true);
        motion.receive(&status(StatusFlags::SAMPLING));
        assert_eq!(motion.now(Some(GripState::Holding)), None);
        motion.receive(&status(StatusFlags::MOTION));
        assert_eq!(motion.now(Some(GripState::Slipping)), Some(0.0));
        motion.receive(&status(StatusFlags::MOTION.with(StatusFlags::MOVING, true)));
        assert_eq!(motion.now(Some(GripState::Holding)), Some(1.0));
        motion.forget();
        assert_eq!(motion.now(None), None);
    }

    #[test]
    fn closing_is_motion_where_commands_are_sent() {
        assert_eq!(OwnMotion::new(true).now(Some(GripState::Closing)), Some(1.0));
        assert_eq!(OwnMotion::new(false).now(Some(GripState::Closing)), None);
    }
}
