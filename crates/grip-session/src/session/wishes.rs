//! What clients ask for in; what of it stands, and when a stop is sent again, out.

use grip_link::message::DeviceState;
use slip_core::{ClientCommand, Pipeline};

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
        let done = pipeline.obey(command);
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
    pub(super) fn receive(&mut self, state: DeviceState) {
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
