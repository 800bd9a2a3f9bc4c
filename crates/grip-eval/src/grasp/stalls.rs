//! Experiment on stalls in the middle of a slip: what becomes of the object, by place and length of the stall.
//!
//! The stall begins when the object first slips faster than 1 mm/s at more than half the needed force. Either the line holds all frames of
//! the gripper and then delivers them at once, none lost; or gripd does not run, and up to 64 KiB wait for it. The device goes on in
//! simulated time: its commands run out, and it holds. Objects of 0.2, 0.4 and 1.0 kg with friction 0.35, Ra 2 um, a drive of 20 ms lag and
//! travel noise of 1 um; a slow
//! slip (150 N s/m, lift in 0.5 s) and a quick one (static over kinetic 1.3, lift in 0.05 s).

use super::{
    GraspError,
    laboratory::{Experiment, Fate, Friction, OracleFate, Spread, micros},
    play::{Incident, IncidentKind},
};
use grip_session::{config::HostConfig, model::HostEstimator};
use grip_sim::{Scene, SceneConfig, SceneError, scene::Draw};
use serde::Serialize;
use slip_core::units::Micros;

/// From the end of a stall to the end of the grasp (s).
const AFTER_S: f64 = 1.5;
/// Longest wait for a slip (s from the start).
const WATCH_S: f64 = 3.0;

slip_core::named! {
    /// Who stops.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum StallPlace {
        fn name: "Its name in the table.";
    }
    Line: "The line.", "line";
    Daemon: "gripd.", "daemon";
}

/// Lengths of the stalls (ms).
pub const STALLS_MS: [u32; 5] = [50, 100, 200, 300, 1000];
/// Masses of the objects (kg).
pub const MASSES_KG: [f64; 3] = [0.2, 0.4, 1.0];

/// A slow slip.
const SLOW: Friction = Friction { name: "viscous150", viscous_n_s_m: 150.0, ..Friction::COULOMB };
/// How the objects slide, and the time of their lift (s).
pub const SLIPS: [(Friction, f64); 2] = [(SLOW, 0.5), (Friction::STRIBECK, 0.05)];

/// One grasp with a stall.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StallTrial {
    /// `stall_trial`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Who stops: `line` or `daemon`.
    pub place: &'static str,
    /// For how long (ms).
    pub stall_ms: u32,
    /// How the object slides.
    pub friction: &'static str,
    /// Its mass (kg).
    pub mass_kg: f64,
    /// Seed of surface and noise.
    pub seed: u64,
    /// When the stall begins (s from the start); `None` where the object never slips that fast: not counted.
    pub begins_s: Option<f64>,
    /// gripd with the stall.
    pub stalled: Fate,
    /// gripd without it.
    pub sound: Fate,
    /// The oracle, with the same stall at the same time.
    pub oracle: OracleFate,
}

/// Every stall in the slip of an object of this mass (kg) that slides this way and is lifted in this time (s).
///
/// # Errors
/// Where the settings do not make a session.
pub fn stall_trials(
    config: &HostConfig,
    estimator: &HostEstimator,
    friction: Friction,
    ramp_s: f64,
    mass_kg: f64,
    seed: u64,
) -> Result<Vec<StallTrial>, GraspError> {
    let scene = Scene::new(object(friction, ramp_s, mass_kg, seed)?)?;
    let run = |end_s: f64, incident: Option<Incident>| Experiment {
        scene: &scene,
        config,
        end: micros(end_s),
        incident,
    };
    let (sound, marks) = run(WATCH_S, None).marked(estimator)?;
    let calm = run(WATCH_S, None).oracle()?;
    let mut trials = Vec::new();
    for place in StallPlace::ALL {
        for stall_ms in STALLS_MS {
            let length = Micros::from_millis(stall_ms);
            let kind = match place {
                StallPlace::Line => IncidentKind::LineStall(length),
                StallPlace::Daemon => IncidentKind::HostStall(length),
            };
            let (stalled, oracle) = match marks.fast_s {
                None => (sound, calm),
                Some(begins_s) => {
                    let incident = Incident { at: micros(begins_s).plus(Micros(1)), kind };
                    let end_s = begins_s + length.as_seconds() + AFTER_S;
                    let run = run(end_s, Some(incident));
                    (run.own(estimator)?, run.oracle()?)
                }
            };
            trials.push(StallTrial {
                kind: "stall_trial",
                place: place.name(),
                stall_ms,
                friction: friction.name,
                mass_kg,
                seed,
                begins_s: marks.fast_s,
                stalled,
                sound,
                oracle,
            });
        }
    }
    Ok(trials)
}

fn object(
    friction: Friction,
    ramp_s: f64,
    mass_kg: f64,
    seed: u64,
) -> Result<SceneConfig, SceneError> {
    let mut scene = SceneConfig::from_toml("name = \"stalls\"")?;
    scene.seed = seed;
    scene.mass_kg = Draw::Fixed(mass_kg);
    scene.friction = Draw::Fixed(0.35);
    scene.roughness_ra_um = Draw::Fixed(2.0);
    scene.noise.travel_um = 1.0;
    scene.drive.lag_ms = 20.0;
    scene.lift_ramp_s = ramp_s;
    friction.put_into(&mut scene);
    Ok(scene)
}

/// Trials that agree in place, length, friction and mass, or in some of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StallCell {
    /// `stall`, or `stall_total` of several cells.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Who stops, or `all`.
    pub place: String,
    /// For how long (ms), or `all`.
    pub stall_ms: String,
    /// How the objects slide, or `all`.
    pub friction: String,
    /// Their mass (kg), or `all`.
    pub mass_kg: String,
    /// Grasps with the stall.
    pub trials: usize,
    /// Grasps without a slip that is fast enough. Not counted below.
    pub unreached: usize,
    /// Objects that fell.
    pub dropped: usize,
    /// Objects that were crushed.
    pub crushed: usize,
    /// Objects that fell although an oracle holds them.
    pub dropped_holdable: usize,
    /// Objects that the oracle dropped with 1.3 times the needed force.
    pub oracle_dropped: usize,
    /// Objects that fell without a stall.
    pub dropped_sound: usize,
    /// Largest over needed force of all objects, fallen ones included.
    pub peak_ratio: Spread,
    /// The same without a stall.
    pub peak_ratio_sound: Spread,
    /// Seeds of the objects that fell.
    pub dropped_seeds: Vec<u64>,
}

/// The cell of `trials`; the names are those of its row.
#[must_use]
pub fn stall_cell(kind: &'static str, names: [String; 4], trials: &[&StallTrial]) -> StallCell {
    let [place, stall_ms, friction, mass_kg] = names;
    let reached = || trials.iter().filter(|trial| trial.begins_s.is_some());
    let count = |test: &dyn Fn(&StallTrial) -> bool| reached().filter(|trial| test(trial)).count();
    let spread = |value: &dyn Fn(&StallTrial) -> f64| {
        Spread::of(reached().map(|trial| value(trial)).collect())
    };
    let mut dropped_seeds: Vec<u64> =
        reached().filter(|trial| trial.stalled.dropped).map(|trial| trial.seed).collect();
    dropped_seeds.sort_unstable();
    dropped_seeds.dedup();
    StallCell {
        kind,
        place,
        stall_ms,
        friction,
        mass_kg,
        trials: reached().count(),
        unreached: trials.len() - reached().count(),
        dropped: count(&|trial| trial.stalled.dropped),
        crushed: count(&|trial| trial.stalled.crushed),
        dropped_holdable: count(&|trial| trial.stalled.dropped && trial.oracle.holds),
        oracle_dropped: count(&|trial| trial.oracle.usual.dropped),
        dropped_sound: count(&|trial| trial.sound.dropped),
        peak_ratio: spread(&|trial| trial.stalled.peak_ratio),
        peak_ratio_sound: spread(&|trial| trial.sound.peak_ratio),
        dropped_seeds,
    }
}
