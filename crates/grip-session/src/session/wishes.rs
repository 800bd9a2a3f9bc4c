//! What clients ask for in; what of it stands, and when a stop is sent again, out.

use grip_link::message::DeviceState;
use slip_core::Pipeline;

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
    /// Clear the fault with this code.
    ClearFault(u16),
}

impl ClientCommand {
    /// Carries out what concerns the controller; `false` where the command is none of that or its force is no force.
    pub fn apply<W: AsRef<[f32]>>(self, pipeline: &mut Pipeline<W>) -> bool {
        match self {
            Self::AtLeast(force_n) if force_n >= 0.0 => pipeline.at_least(force_n),
            Self::Release => pipeline.release(),
            Self::Grasp => pipeline.close_again(),
            Self::AtLeast(_) | Self::Stop | Self::ClearFault(_) => return false,
        }
        true
    }
}

/// A stop is sent this often until the gripper says that it has stopped (us).
const STOP_EVERY_US: u64 = 20_000;

/// What was asked for and still stands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wishes {
    least_n: f32,
    released: bool,
    stop_at_us: Option<u64>,
}

impl Wishes {
    /// Carries out and remembers what concerns the controller; `false` where it cannot.
    pub(super) fn apply<W: AsRef<[f32]>>(
        &mut self,
        command: ClientCommand,
        pipeline: &mut Pipeline<W>,
    ) -> bool {
        let done = command.apply(pipeline);
        match command {
            ClientCommand::AtLeast(force_n) if done => self.least_n = force_n,
            ClientCommand::Release => self.released = true,
            ClientCommand::Grasp => self.released = false,
            _ => {}
        }
        done
    }

    /// A stop also takes back what was asked for.
    pub(super) fn stop(&mut self, now_us: u64) {
        self.least_n = 0.0;
        self.stop_at_us = Some(now_us);
    }

    /// Whether the stop is to be sent now.
    pub(super) fn stop_due(&mut self, now_us: u64) -> bool {
        let due = self.stop_at_us.is_some_and(|at_us| now_us >= at_us);
        if due {
            self.stop_at_us = Some(now_us + STOP_EVERY_US);
        }
        due
    }

    /// The gripper told its state.
    pub(super) fn hear(&mut self, state: DeviceState) {
        if state == DeviceState::Estop {
            self.stop_at_us = None;
        }
    }

    pub(super) fn least_n(&self) -> f32 {
        self.least_n
    }

    pub(super) fn released(&self) -> bool {
        self.released
    }
}
