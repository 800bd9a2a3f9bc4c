//! Simulation of a grasp with a scene and the settings of a gripper: what became of the object.
//!
//! One grasp of gripd over a line without fault; [`crate::grasp`] has older laws, other sensors and trouble too. The same scene
//! and settings give the same grasp, byte for byte.

pub use crate::grasp::{Outcome, could_be_held};

use crate::grasp::{Line, Own, Setup, play};
use grip_session::{
    config::HostConfig,
    model::HostEstimator,
    session::{SessionError, Update},
};
use grip_sim::Scene;
use slip_core::units::Micros;

/// Why a grasp cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// The scene does not make a device.
    #[error("scene: {0}")]
    Device(#[from] grip_sim::mcu::DeviceConfigError),
    /// The session failed.
    #[error(transparent)]
    Session(#[from] SessionError),
}

/// Grasps, lifts and holds the object of `scene` for `duration` and hands everything that happens to `report`.
///
/// # Errors
/// Where scene and settings do not make a device and a session.
pub fn grasp(
    scene: &Scene,
    config: &HostConfig,
    estimator: HostEstimator,
    duration: Micros,
    report: &mut dyn FnMut(Update<'_>),
) -> Result<Outcome, TrialError> {
    let setup = Setup { scene, config, duration, line: Line::default(), incident: None };
    play(&setup, &mut Own::new(config, estimator, report)?)
}
