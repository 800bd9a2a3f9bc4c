//! A simulated scene and the settings of a gripper in; what became of the object out.
//!
//! The grasp runs in lockstep, faster than real time: the simulated microcontroller and the session exchange the
//! bytes they would exchange over a serial port, with time that only goes on between the frames. The same scene
//! and settings give the same grasp, byte for byte.

use crate::{
    config::HostConfig,
    model::HostEstimator,
    session::{News, Session, SessionError, SessionOptions},
};
use grip_link::frame::MAX_WIRE;
use grip_sim::{Clairvoyant, Scene, Truth, VirtualMcu, perfect_controller_can_hold};
use slip_core::{estimate::ForceEstimate, grip::Trials, units::Micros};

/// What became of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// The simulator's truth at the end.
    pub truth: Truth,
    /// Slips that were noticed.
    pub slips: u64,
    /// How the object was tried until it was held; what it moved is as measured.
    pub trials: Trials,
    /// The last estimate of the adequate force, with its deviation.
    pub estimate: Option<ForceEstimate>,
    /// Highest force commanded (N).
    pub peak_command_n: f32,
    /// Last force commanded (N).
    pub command_n: f32,
    /// Samples handled.
    pub samples: u64,
    /// Samples lost.
    pub lost: u64,
}

impl Outcome {
    /// Final applied force over the needed one.
    #[must_use]
    pub fn force_ratio(&self) -> f64 {
        self.truth.applied_n / self.truth.force_needed_n
    }

    /// The object was lifted and is still in the fingers, whole.
    #[must_use]
    pub fn held(&self) -> bool {
        self.truth.lifted() && !self.truth.dropped() && !self.truth.crushed
    }
}

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

/// Grasps, lifts and holds the object of `scene` for `duration` and tells everything that happens to `tell`.
///
/// # Errors
/// Where scene and settings do not make a device and a session.
pub fn grasp(
    scene: &Scene,
    config: &HostConfig,
    estimator: HostEstimator,
    duration: Micros,
    tell: &mut dyn FnMut(News<'_>),
) -> Result<Outcome, TrialError> {
    let mut mcu = VirtualMcu::new(scene, 1)?;
    let mut session = Session::new(config.clone(), estimator, SessionOptions::default())?;
    session.open(0, 1)?;
    let mut bytes = Vec::with_capacity(4 * MAX_WIRE);
    let mut out = [0; MAX_WIRE];
    let mut peak_command_n = 0.0_f32;
    loop {
        let now = mcu.next_due();
        if now > duration {
            break;
        }
        mcu.advance(now);
        bytes.clear();
        mcu.transmit(now, &mut bytes);
        if let Some(len) = session.receive(now.0, &bytes, &mut out, tell)? {
            mcu.receive(now, out.get(..len).unwrap_or(&out));
        }
        while let Some(len) = session.poll_transmit(now.0, &mut out) {
            mcu.receive(now, out.get(..len).unwrap_or(&out));
        }
        let command = session.latest().and_then(|step| step.command);
        peak_command_n = peak_command_n.max(command.map_or(0.0, |c| c.0));
    }
    Ok(Outcome {
        truth: mcu.truth(),
        slips: session.log().slips(),
        trials: session.trials().unwrap_or_default(),
        estimate: session.log().evidence().1,
        peak_command_n,
        command_n: session.latest().and_then(|step| step.command).map_or(0.0, |c| c.0),
        samples: session.counters().samples,
        lost: session.link().loss().lost,
    })
}

/// Whether a controller that knows the needed force, and acts 1 ms after the first slip with the slew rate of
/// `config`, would have kept the object.
#[must_use]
pub fn could_be_held(scene: &Scene, config: &HostConfig) -> bool {
    let clairvoyant = Clairvoyant {
        trial_n: f64::from(config.grip.trial_force_n),
        slew_n_s: f64::from(config.grip.slew_n_s),
        delay_s: 1e-3,
    };
    perfect_controller_can_hold(scene, clairvoyant)
}
