//! State of a gripper on a line of its own, and its column of the rows.

use super::BoardOptions;
use crate::rows::Header;
use grip_link::message::{ChannelKind, MAX_CHANNELS};

/// What a gripper that follows the commands may be asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actuator {
    /// Largest force (N).
    pub force_max_n: f32,
    /// Fastest change of force (N/s).
    pub slew_n_s: f32,
    /// Force (N) with which it holds something already; 0 where it holds nothing.
    pub holds_n: f32,
    /// Whether it has a line of its own and shows a force there: a column of the rows, unless they have one.
    pub shows_force: bool,
}

/// What a gripper on a line of its own shows of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GripperReading {
    /// Its force.
    pub force: GripperForce,
    /// Whether the fingers travel freely.
    pub moving: bool,
}

/// The force of a gripper on a line of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GripperForce {
    /// It was measured (N), and counts for one row.
    Measured(f32),
    /// It is not measured: it follows what is asked for (N) with this lag (s), or is 0 where nothing is between the fingers.
    Asked {
        /// What is asked for (N); 0 where nothing is between the fingers.
        force_n: f32,
        /// First-order lag (s) that the gripper declares.
        lag_s: f32,
    },
}

/// What is known of a gripper on a line of its own.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gripper {
    pub(super) reading: Option<GripperReading>,
    /// Force (N) behind its lag.
    pub(super) lagged_n: f32,
    /// It cannot be commanded now: nobody is to work with this board, and rows are not kept.
    pub(super) absent: bool,
    /// The last command of the host opens the fingers.
    pub(super) opens: bool,
}

impl Gripper {
    /// The force for a row (N) that comes `dt_s` after the one before; NaN where there is no reading.
    pub(super) fn force_n(&mut self, dt_s: f32) -> f32 {
        match &mut self.reading {
            None => f32::NAN,
            Some(GripperReading { force: GripperForce::Measured(force_n), .. }) => {
                core::mem::replace(force_n, f32::NAN)
            }
            Some(GripperReading { force: GripperForce::Asked { force_n, lag_s }, .. }) => {
                if *force_n > 0.0 {
                    self.lagged_n += (*force_n - self.lagged_n) * dt_s / (dt_s + *lag_s);
                } else {
                    self.lagged_n = 0.0;
                }
                self.lagged_n
            }
        }
    }
}

/// Whether the force of a gripper on a line of its own is a column after those of the header.
pub(super) fn shows_force(header: &Header, options: &BoardOptions) -> bool {
    let has_own = || header.channels.iter().any(|channel| channel.kind == ChannelKind::NormalForce);
    options.actuator.is_some_and(|actuator| actuator.shows_force)
        && header.channels.len() < MAX_CHANNELS
        && !has_own()
}
