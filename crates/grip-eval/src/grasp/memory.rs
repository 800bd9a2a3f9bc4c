//! Series of grasps of the same objects: what the memory of gripd changes.
//!
//! Each object is grasped ten times under one name, each time at another place of its surface and with other noise. Then another
//! object stands under that name, for two grasps. Beside it the same grasps without memory.

use super::{Bench, GraspError, GraspResult, Own, Setup, Way, laboratory::Spread, play};
use crate::grasp::trial::TrialError;
use grip_session::{
    memory::{Memory, Remembered},
    session::Update,
};
use grip_sim::Scene;
use serde::Serialize;

/// Grasps of an object.
pub const GRASPS: u32 = 10;
/// Grasps of the object that then stands under its name.
pub const SWAPPED: u32 = 2;
/// What the objects are called.
const NAME: &str = "object";

/// One grasp of a series.
#[derive(Clone, Debug, Serialize)]
pub struct MemoryGrasp {
    /// Number in the series: 1 to 10 of the object, 11 and 12 of another one under its name.
    pub grasp: u32,
    /// Whether the memory was used.
    pub memory: bool,
    /// Force that the object was expected to be held with (N); 0 where nothing was known.
    pub expected_n: f32,
    /// Whether the memory has noticed that it is another object.
    pub noticed: bool,
    /// What became of it.
    #[serde(flatten)]
    pub result: GraspResult,
}

impl Bench {
    /// Grasps the objects that `seed` and `other` draw from `scene`, one after the other under the same name.
    ///
    /// # Errors
    /// As [`Bench::grasp`].
    pub fn remember(
        &self,
        scene: &Scene,
        seed: u64,
        other: u64,
        way: &Way,
        remembers: bool,
    ) -> Result<Vec<MemoryGrasp>, GraspError> {
        let (object, swapped) = (way.scene(scene, seed)?, way.scene(scene, other)?);
        let mut memory = Memory::default();
        let mut grasps = Vec::new();
        for grasp in 1..=GRASPS + SWAPPED {
            let object = if grasp <= GRASPS { &object } else { &swapped };
            memory.begin();
            let expected_n = memory.select(NAME).unwrap_or(0.0);
            // Numbers of one series follow those of the next one far behind.
            let place = seed.wrapping_add(1_000_000_007 * u64::from(grasp));
            let scene = object.regrasped(place)?;
            let (result, remembered) = self.grasp_once(&scene, way, expected_n, &mut memory)?;
            let noticed = matches!(remembered, Some(Remembered::Contradicted { .. }));
            grasps.push(MemoryGrasp { grasp, memory: remembers, expected_n, noticed, result });
            if !remembers {
                memory = Memory::default();
            }
        }
        Ok(grasps)
    }

    /// A grasp that begins with `expected_n` (N), and what the memory has made of it.
    fn grasp_once(
        &self,
        scene: &Scene,
        way: &Way,
        expected_n: f32,
        memory: &mut Memory,
    ) -> Result<(GraspResult, Option<Remembered>), GraspError> {
        let config = way.settings(scene, &self.config);
        let setup = Setup {
            scene,
            config: &config,
            duration: self.duration,
            line: way.line(scene),
            incident: None,
        };
        let mut remembered = None;
        let mut report = |update: Update<'_>| match update {
            Update::Step { step, .. } => memory.watch(step.command.map(|command| command.0)),
            Update::Event(event) => remembered = memory.take(&event).or_else(|| remembered.take()),
            _ => {}
        };
        let own = Own::new(&config, self.estimator.clone(), &mut report);
        let mut own = own.map_err(TrialError::from)?.expecting(expected_n);
        let outcome = play(&setup, &mut own)?;
        Ok((self.result(scene, way, &outcome), remembered))
    }
}

/// Grasps of the same number, with memory or without.
#[derive(Clone, Debug, Serialize)]
pub struct MemoryTotal {
    /// `memory`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// What the gripper feels.
    pub sensors: &'static str,
    /// Number in the series: 11 and 12 are those of another object.
    pub grasp: u32,
    /// Whether the memory was used.
    pub memory: bool,
    /// Objects.
    pub trials: usize,
    /// That fell.
    pub dropped: usize,
    /// That were crushed.
    pub crushed: usize,
    /// Of which it was noticed that they are not what their name states.
    pub noticed: usize,
    /// How far they slipped (mm).
    pub slip_mm: Spread,
    /// Largest force over the needed one.
    pub peak_ratio: Spread,
    /// Force at the end over the needed one.
    pub force_ratio: Spread,
}

/// The total of `grasps`, which agree in scene, sensors, number and memory; `None` of none.
#[must_use]
pub fn memory_total(grasps: &[&MemoryGrasp]) -> Option<MemoryTotal> {
    let first = *grasps.first()?;
    let count = |test: fn(&MemoryGrasp) -> bool| grasps.iter().filter(|one| test(one)).count();
    let spread = |value: fn(&GraspResult) -> f64| {
        Spread::of(grasps.iter().map(|one| value(&one.result)).collect())
    };
    Some(MemoryTotal {
        kind: "memory",
        scene: first.result.scene.clone(),
        sensors: first.result.sensors,
        grasp: first.grasp,
        memory: first.memory,
        trials: grasps.len(),
        dropped: count(|one| one.result.dropped),
        crushed: count(|one| one.result.crushed),
        noticed: count(|one| one.noticed),
        slip_mm: spread(|result| result.slip_mm),
        peak_ratio: spread(|result| result.force_peak_n / result.force_needed_n),
        force_ratio: spread(|result| result.force_ratio),
    })
}
