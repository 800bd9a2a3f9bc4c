//! Experiment on sensor faults by sensor, fault, onset and kind of slip: what becomes of the object, with gripd and with an oracle.
//!
//! The object, the drive and the lift are drawn by the seed: mass 0.15 to 1.0 kg (uniform in the logarithm), friction 0.25 to 0.5, Ra 0.4
//! to 6.3 um, drive lag 5 or 20 ms, lift in 0.05, 0.3 or 0.5 s; the sensors are those of the default scene: stylus, normal force and
//! travel. The same seed is the same object in every cell. A first grasp without fault gives the times at which the faults begin
//! ([`FaultPhase`]). Beside every grasp with a fault stand, of the same object: gripd without that sensor from the start, and an oracle.

use super::{
    GraspError,
    laboratory::{CRUSH_RATIO, Experiment, Fate, Friction, Marks, OracleFate, Spread, micros},
    play::{Incident, IncidentKind},
};
use crate::dice::Dice;
use grip_session::{config::HostConfig, model::HostEstimator};
use grip_sim::{
    GRAVITY_M_S2, Scene, SceneConfig, SceneError,
    mcu::{Sensor, SensorFault},
    scene::Draw,
};
use serde::Serialize;
use slip_core::{alarm::Method, units::Micros};

/// From the lift to the end of a grasp (s).
const HOLD_S: f64 = 2.0;
/// From a fault while holding to the growth of the load, and from there to the end (s).
const QUIET_S: f64 = 0.6;
const AFTER_S: f64 = 0.8;
/// What the load grows by, as a share of the weight, and the time it takes (ms).
const GROWTH: f64 = 0.4;
const GROWTH_MS: f64 = 50.0;
/// A fault while holding begins at the latest this long after the lift, whether the object rests or not (s).
const LATEST_S: f64 = 1.5;

slip_core::named! {
    /// When a fault begins.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum FaultPhase {
        fn name: "Its name on the command line.";
    }
    Before: "50 ms before the lift.", "before";
    First: "2 ms after the object began to slip.", "first";
    Middle: "At half the needed force in the slip, or 15 ms after its begin, whichever comes first.", "middle";
    End: "At the needed force in the slip, or 30 ms after its begin, whichever comes first.", "end";
    Holding:
        "When nothing has slipped for 0.3 s after the lift; 0.6 s later the load grows by 40 % in 50 ms.",
        "holding";
}

impl FaultPhase {
    /// The phase of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|phase| phase.name() == name)
    }

    /// When it is in a grasp with these marks (s); `None` where the object never slips.
    fn begins_s(self, marks: &Marks) -> Option<f64> {
        let within = |mark: Option<f64>, latest_s: f64| {
            let latest_s = marks.slip_s? + latest_s;
            Some(mark.map_or(latest_s, |mark_s| mark_s.min(latest_s)))
        };
        match self {
            Self::Before => Some(marks.lift_s? - 0.05),
            Self::First => Some(marks.slip_s? + 2e-3),
            Self::Middle => within(marks.half_s, 15e-3),
            Self::End => within(marks.enough_s, 30e-3),
            Self::Holding => {
                let latest_s = marks.lift_s? + LATEST_S;
                Some(marks.rest_s.map_or(latest_s, |rest_s| rest_s.min(latest_s)))
            }
        }
    }
}

/// A fault with its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultKind {
    /// Its name on the command line.
    pub name: &'static str,
    /// What the sensor shows.
    pub fault: SensorFault,
}

impl FaultKind {
    /// Every fault of the table.
    pub const ALL: [Self; 9] = [
        Self { name: "nan", fault: SensorFault::Dead },
        Self { name: "inf", fault: SensorFault::Infinite },
        Self { name: "stuck", fault: SensorFault::Stuck },
        Self { name: "noise30", fault: SensorFault::Noise },
        Self { name: "late5", fault: SensorFault::Late(Micros(5_000)) },
        Self { name: "late50", fault: SensorFault::Late(Micros(50_000)) },
        Self { name: "late300", fault: SensorFault::Late(Micros(300_000)) },
        Self { name: "gain+30", fault: SensorFault::Gain(30) },
        Self { name: "gain-30", fault: SensorFault::Gain(-30) },
    ];

    /// The fault of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name == name)
    }
}

/// The sensors of the table and their names on the command line.
pub const FAULT_SENSORS: [(&str, Sensor); 3] =
    [("stylus", Sensor::Stylus), ("force", Sensor::NormalForce), ("travel", Sensor::Travel)];

fn sensor_name(sensor: Sensor) -> &'static str {
    FAULT_SENSORS.iter().find(|(_, known)| *known == sensor).map_or("", |(name, _)| name)
}

/// Which cells of the table are filled, but for the friction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FaultPlan {
    /// Sensors that fail.
    pub sensors: Vec<Sensor>,
    /// How.
    pub faults: Vec<FaultKind>,
    /// When.
    pub phases: Vec<FaultPhase>,
}

impl Default for FaultPlan {
    fn default() -> Self {
        Self {
            sensors: FAULT_SENSORS.map(|(_, sensor)| sensor).to_vec(),
            faults: FaultKind::ALL.to_vec(),
            phases: FaultPhase::ALL.to_vec(),
        }
    }
}

/// One grasp with a fault, and what stands beside it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultTrial {
    /// `fault_trial`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// The sensor that fails.
    pub sensor: &'static str,
    /// How it fails.
    pub fault: &'static str,
    /// When.
    pub phase: &'static str,
    /// How the object slides.
    pub friction: &'static str,
    /// Seed of object, drive, lift and noise.
    pub seed: u64,
    /// When the fault begins (s from the start); `None` where the object never slips and the phase is one of a slip: not counted.
    pub begins_s: Option<f64>,
    /// gripd with the fault.
    pub faulty: Fate,
    /// gripd without that sensor from the start.
    pub absent: Fate,
    /// gripd with all sensors in order.
    pub sound: Fate,
    /// The oracle.
    pub oracle: OracleFate,
}

/// The laboratory of one object: gripd's settings, and the object.
#[derive(Clone, Copy, Debug)]
pub struct FaultBench<'a> {
    /// Settings of gripd.
    pub config: &'a HostConfig,
    /// The force estimate of gripd.
    pub estimator: &'a HostEstimator,
}

/// The grasps of an object that do not depend on the fault.
struct Shared<'a> {
    bench: FaultBench<'a>,
    scene: Scene,
    end: Micros,
    sound: Fate,
    oracle: OracleFate,
    /// By sensor.
    absent: Vec<(Sensor, Fate)>,
}

impl FaultBench<'_> {
    /// Every fault of `plan` on the object of `seed` that slides with `friction`.
    ///
    /// # Errors
    /// Where the settings do not make a session.
    pub fn trials(
        &self,
        plan: &FaultPlan,
        friction: Friction,
        seed: u64,
    ) -> Result<Vec<FaultTrial>, GraspError> {
        let scene = Scene::new(object(friction, seed)?)?;
        let config = scene.config();
        // gripd begins to close after a fraction of a second; the lift is seen in the grasp itself.
        let first_end = micros(1e-3 * config.drive.approach_ms + config.lift_at_s + 1.0 + LATEST_S);
        let first =
            Experiment { scene: &scene, config: self.config, end: first_end, incident: None };
        let (_, marks) = first.marked(self.estimator)?;
        let lift_s = marks.lift_s.unwrap_or_default();
        let mut trials = Vec::new();
        let slips = plan.phases.iter().any(|phase| *phase != FaultPhase::Holding);
        let still = if slips {
            Some(self.shared(plan, scene.clone(), micros(lift_s + HOLD_S))?)
        } else {
            None
        };
        let holding_s = FaultPhase::Holding.begins_s(&marks).unwrap_or(lift_s);
        let disturbed = if plan.phases.contains(&FaultPhase::Holding) {
            let scene = Scene::new(disturbed(&scene, holding_s + QUIET_S - lift_s))?;
            Some(self.shared(plan, scene, micros(holding_s + QUIET_S + AFTER_S))?)
        } else {
            None
        };
        for &phase in &plan.phases {
            let shared = if phase == FaultPhase::Holding { &disturbed } else { &still };
            if let Some(shared) = shared {
                let begins_s = phase.begins_s(&marks);
                trials.extend(shared.faulty(plan, phase, begins_s, friction, seed)?);
            }
        }
        Ok(trials)
    }

    fn shared(
        &self,
        plan: &FaultPlan,
        scene: Scene,
        end: Micros,
    ) -> Result<Shared<'_>, GraspError> {
        let all = Experiment { scene: &scene, config: self.config, end, incident: None };
        let (sound, oracle) = (all.own(self.estimator)?, all.oracle()?);
        let mut absent = Vec::new();
        for &sensor in &plan.sensors {
            let (config, scene) = without(sensor, self.config, &scene)?;
            let less = Experiment { scene: &scene, config: &config, end, incident: None };
            absent.push((sensor, less.own(self.estimator)?));
        }
        Ok(Shared { bench: *self, scene, end, sound, oracle, absent })
    }
}

impl Shared<'_> {
    /// The faults that begin in one phase.
    fn faulty(
        &self,
        plan: &FaultPlan,
        phase: FaultPhase,
        begins_s: Option<f64>,
        friction: Friction,
        seed: u64,
    ) -> Result<Vec<FaultTrial>, GraspError> {
        let Self { bench, scene, end, sound, oracle, absent } = self;
        let mut trials = Vec::new();
        for (sensor, absent) in absent {
            for kind in &plan.faults {
                // From the sample after the one in which the phase begins on.
                let incident = begins_s.map(|begins_s| Incident {
                    at: micros(begins_s).plus(Micros(1)),
                    kind: IncidentKind::Sensor(*sensor, kind.fault),
                });
                let faulty = match incident {
                    None => *sound,
                    incident => Experiment { scene, config: bench.config, end: *end, incident }
                        .own(bench.estimator)?,
                };
                trials.push(FaultTrial {
                    kind: "fault_trial",
                    sensor: sensor_name(*sensor),
                    fault: kind.name,
                    phase: phase.name(),
                    friction: friction.name,
                    seed,
                    begins_s,
                    faulty,
                    absent: *absent,
                    sound: *sound,
                    oracle: *oracle,
                });
            }
        }
        Ok(trials)
    }
}

/// The scene of an object of the table.
fn object(friction: Friction, seed: u64) -> Result<SceneConfig, SceneError> {
    let mut scene = SceneConfig::from_toml("name = \"faults\"")?;
    let mut dice = Dice(seed ^ 0x6661_756c_7400);
    scene.seed = seed;
    scene.mass_kg = Draw::LogUniform { log_uniform: [0.15, 1.0] };
    scene.friction = Draw::Uniform { uniform: [0.25, 0.5] };
    scene.roughness_ra_um = Draw::LogUniform { log_uniform: [0.4, 6.3] };
    scene.crush_ratio = Some(Draw::Fixed(CRUSH_RATIO));
    scene.drive.lag_ms = if dice.share() < 0.5 { 5.0 } else { 20.0 };
    let ramp = 3.0 * dice.share();
    scene.lift_ramp_s = if ramp < 1.0 {
        0.05
    } else if ramp < 2.0 {
        0.3
    } else {
        0.5
    };
    friction.put_into(&mut scene);
    Ok(scene)
}

impl Friction {
    /// Lets the object of `scene` slide this way.
    pub(super) fn put_into(self, scene: &mut SceneConfig) {
        scene.friction_ratio = Draw::Fixed(self.ratio);
        scene.pad.stribeck_mm_s = self.stribeck_mm_s;
        scene.viscous_n_s_m = self.viscous_n_s_m;
    }
}

/// The scene whose load grows `start_s` after the lift, for good.
fn disturbed(scene: &Scene, start_s: f64) -> SceneConfig {
    let mut config = scene.config().clone();
    let weight_n = scene.object().mass_kg * GRAVITY_M_S2;
    config.tug.force_n = Draw::Fixed(GROWTH * weight_n);
    config.tug.start_s = start_s;
    config.tug.rise_ms = GROWTH_MS;
    config.tug.hold_ms = 60_000.0;
    config
}

/// Settings and scene of a gripper that never had `sensor`: gripd is not to use the stylus, any other channel is not offered.
fn without(
    sensor: Sensor,
    config: &HostConfig,
    scene: &Scene,
) -> Result<(HostConfig, Scene), SceneError> {
    let (mut config, mut scene) = (config.clone(), scene.config().clone());
    match sensor {
        Sensor::Stylus => config.methods.retain(|method| *method != Method::Stylus),
        Sensor::NormalForce => scene.channels.force = false,
        Sensor::Travel => scene.channels.travel = false,
        Sensor::TangentialForce => scene.channels.tangential = false,
        Sensor::SecondStylus => scene.second_stylus_mm = None,
    }
    Ok((config, Scene::new(scene)?))
}

/// Trials that agree in sensor, fault, phase and friction, or in one of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultCell {
    /// `fault`, or `fault_total` of several cells.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// The sensor that fails, or `all`.
    pub sensor: String,
    /// How it fails, or `all`.
    pub fault: String,
    /// When, or `all`.
    pub phase: String,
    /// How the object slides, or `all`.
    pub friction: String,
    /// Grasps with the fault.
    pub trials: usize,
    /// Grasps in which the phase never came: the object did not slip. Not counted below.
    pub unreached: usize,
    /// Objects that fell with the fault.
    pub dropped: usize,
    /// Objects that were crushed with it.
    pub crushed: usize,
    /// Objects that fell without the sensor from the start.
    pub dropped_absent: usize,
    /// Objects that were crushed without the sensor from the start.
    pub crushed_absent: usize,
    /// Objects that fell without any fault.
    pub dropped_sound: usize,
    /// Objects that were crushed without any fault.
    pub crushed_sound: usize,
    /// Objects that fell although an oracle holds them: neither dropped nor crushed with 1.1, 1.2, 1.3, 1.4 or 1.5 times the needed force.
    pub dropped_holdable: usize,
    /// Objects that were crushed although an oracle holds them.
    pub crushed_holdable: usize,
    /// Objects that the oracle dropped with 1.3 times the needed force.
    pub oracle_dropped: usize,
    /// Objects that no factor of the oracle holds.
    pub oracle_lost: usize,
    /// Largest over needed force of all that did not fall.
    pub peak_ratio: Spread,
    /// How far they slipped (mm).
    pub slip_mm: Spread,
    /// Seeds of the objects that fell.
    pub dropped_seeds: Vec<u64>,
    /// Seeds of the objects that were crushed.
    pub crushed_seeds: Vec<u64>,
}

/// The cell of `trials`; the names are those of its row.
#[must_use]
pub fn fault_cell(kind: &'static str, names: [&str; 4], trials: &[&FaultTrial]) -> FaultCell {
    let [sensor, fault, phase, friction] = names.map(str::to_owned);
    let reached = || trials.iter().filter(|trial| trial.begins_s.is_some());
    let count = |test: &dyn Fn(&FaultTrial) -> bool| reached().filter(|trial| test(trial)).count();
    let spread = |value: &dyn Fn(&Fate) -> f64| {
        let kept = reached().filter(|trial| !trial.faulty.dropped);
        Spread::of(kept.map(|trial| value(&trial.faulty)).collect())
    };
    let seeds = |test: &dyn Fn(&Fate) -> bool| {
        let mut seeds: Vec<u64> =
            reached().filter(|trial| test(&trial.faulty)).map(|trial| trial.seed).collect();
        seeds.sort_unstable();
        seeds.dedup();
        seeds
    };
    FaultCell {
        kind,
        sensor,
        fault,
        phase,
        friction,
        trials: reached().count(),
        unreached: trials.len() - reached().count(),
        dropped: count(&|trial| trial.faulty.dropped),
        crushed: count(&|trial| trial.faulty.crushed),
        dropped_absent: count(&|trial| trial.absent.dropped),
        crushed_absent: count(&|trial| trial.absent.crushed),
        dropped_sound: count(&|trial| trial.sound.dropped),
        crushed_sound: count(&|trial| trial.sound.crushed),
        dropped_holdable: count(&|trial| trial.faulty.dropped && trial.oracle.holds),
        crushed_holdable: count(&|trial| trial.faulty.crushed && trial.oracle.holds),
        oracle_dropped: count(&|trial| trial.oracle.usual.dropped),
        oracle_lost: count(&|trial| !trial.oracle.holds),
        peak_ratio: spread(&|fate| fate.peak_ratio),
        slip_mm: spread(&|fate| fate.slip_mm),
        dropped_seeds: seeds(&|fate| fate.dropped),
        crushed_seeds: seeds(&|fate| fate.crushed),
    }
}
