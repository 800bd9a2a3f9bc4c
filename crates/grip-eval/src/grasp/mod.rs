//! Simulated grasps of objects by controller, sensors and stress: what became of each object, and their totals.
//!
//! A grasp runs in lockstep, faster than real time: the simulated microcontroller and a [`Hand`] exchange the bytes they would exchange
//! over a serial port ([`play()`]). The hand is a session of gripd or one of the older laws of grip force ([`Law`]); both have the
//! same drive, the same sensors ([`SensorSet`]) and the same trouble ([`Stress`]). The same scene, seed and [`Way`] give the same grasp, byte for byte.

mod baseline;
pub mod faults;
mod hand;
mod laboratory;
mod law;
mod line;
pub mod matrix;
pub mod memory;
mod play;
mod readings;
mod sensors;
pub mod stalls;
mod stress;
mod total;
pub mod trial;

pub use hand::{Hand, Own, send_all};
pub use laboratory::{CRUSH_RATIO, Fate, Friction, ORACLE_FACTORS, OracleFate, Spread};
pub use law::Law;
pub use line::Line;
pub use play::{HOST_BUFFER, Incident, IncidentKind, Outcome, Setup, play};
pub use readings::Reading;
pub use sensors::SensorSet;
pub use stress::Stress;
pub use total::{GraspResult, Total, total};

use crate::grasp::trial::TrialError;
use grip_session::{
    config::HostConfig, gripper::least_force, model::HostEstimator, session::Update,
};
use grip_sim::{Clairvoyant, Scene, SceneError, perfect_controller_can_hold};
use slip_core::units::Micros;

/// One way of grasping: who commands the force, what is felt, and what goes wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Way {
    /// Who commands the force.
    pub law: Law,
    /// What the gripper feels.
    pub sensors: SensorSet,
    /// What goes wrong.
    pub stress: Stress,
}

/// What all grasps of a run have in common.
#[derive(Clone, Debug)]
pub struct Bench {
    /// Settings of the gripper, for gripd and the older laws alike.
    pub config: HostConfig,
    /// The force estimate of gripd.
    pub estimator: HostEstimator,
    /// Length of a grasp.
    pub duration: Micros,
}

/// Why a grasp cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum GraspError {
    /// The scene cannot be had with these sensors or this trouble.
    #[error("scene: {0}")]
    Scene(#[from] SceneError),
    /// The session failed, or the scene does not make a device.
    #[error(transparent)]
    Trial(#[from] TrialError),
}

impl Bench {
    /// Grasps the object that `seed` draws from `scene`, in the given way.
    ///
    /// # Errors
    /// Where scene and settings do not make a device and a session.
    pub fn grasp(&self, scene: &Scene, seed: u64, way: &Way) -> Result<GraspResult, GraspError> {
        let scene = way.scene(scene, seed)?;
        let config = way.settings(&scene, &self.config);
        let setup = Setup {
            scene: &scene,
            config: &config,
            duration: self.duration,
            line: way.line(&scene),
            incident: way.stress.stylus_dies(seed, &scene, self.duration),
        };
        let outcome = match way.law.baseline(&setup).map_err(TrialError::from)? {
            Some(mut hand) => play(&setup, &mut hand)?,
            None => {
                let mut silent = |_: Update<'_>| ();
                let own = Own::new(&config, self.estimator.clone(), &mut silent);
                play(&setup, &mut own.map_err(TrialError::from)?)?
            }
        };
        Ok(self.result(&scene, way, &outcome))
    }

    fn result(&self, scene: &Scene, way: &Way, outcome: &Outcome) -> GraspResult {
        let truth = outcome.truth;
        let config = scene.config();
        let lift_s = 1e-3 * config.drive.approach_ms + config.lift_at_s;
        // An object that was never gripped has not been held.
        let dropped = truth.dropped() || !truth.lifted();
        // What fell early would have needed what was still to come.
        let needed_n = if dropped {
            let hold_s = (self.duration.as_seconds() - lift_s).max(0.0);
            scene.force_needed_n(hold_s).max(truth.force_needed_n)
        } else {
            truth.force_needed_n
        };
        let limit_n = config.drive.force_max_n.min(f64::from(self.config.grip.f_max_n));
        let holdable = dropped.then(|| could_be_held(scene, &way.settings(scene, &self.config)));
        GraspResult {
            kind: "grasp",
            scene: config.name.clone(),
            law: way.law.name(),
            sensors: way.sensors.name(),
            stress: way.stress.name,
            seed: config.seed,
            held: outcome.held(),
            dropped,
            crushed: truth.crushed,
            holdable,
            roomy: needed_n <= 0.7 * scene.object().crush_n && 1.2 * needed_n <= limit_n,
            slip_mm: truth.slip_mm(),
            slips: outcome.slips,
            forces_tried: (outcome.trials.trials > 0).then_some(outcome.trials.trials),
            tried_mm: 1e3 * outcome.trials.moved_m,
            stable_s: truth.stable_after_s,
            force_needed_n: needed_n,
            needed_end_n: truth.needed_now_n,
            force_final_n: truth.applied_n,
            force_peak_n: truth.force_peak_n,
            crush_n: scene.object().crush_n,
            force_ratio: truth.applied_n / needed_n,
            peak_command_n: outcome.peak_command_n,
        }
    }
}

impl Way {
    /// `scene` with the object of `seed`, felt and troubled in this way.
    fn scene(&self, scene: &Scene, seed: u64) -> Result<Scene, SceneError> {
        let mut config = scene.config().clone();
        config.seed = seed;
        self.sensors.equip(&mut config);
        self.stress.trouble(&mut config);
        Scene::new(config)
    }

    /// The line of this grasp.
    fn line(&self, scene: &Scene) -> Line {
        let config = scene.config();
        let batch = laboratory::micros(1e-3 * config.reading.batch_ms);
        Line { batch, ..self.stress.line(config.seed) }
    }

    /// `config` for this gripper: it knows where a second stylus stands and, since IDENT does not have it, the smallest force that the data
    /// sheet states, or the drive answers. The fingers close to it in the usual time.
    fn settings(&self, scene: &Scene, config: &HostConfig) -> HostConfig {
        let mut config = self.sensors.settings(config);
        let drive = &scene.config().drive;
        #[expect(clippy::cast_possible_truncation, reason = "a force needs no more digits")]
        let least_n = drive.force_min_n.max(drive.step_n).max(1.5 * drive.dead_band_n) as f32;
        least_force(&mut config.grip, least_n);
        config
    }
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
