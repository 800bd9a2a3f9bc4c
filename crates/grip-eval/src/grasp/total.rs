//! Results of single grasps, and their totals.

use crate::score::Quantiles;
use serde::Serialize;

/// One grasp.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GraspResult {
    /// `grasp`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// Who commanded the force.
    pub law: &'static str,
    /// What the gripper felt.
    pub sensors: &'static str,
    /// What went wrong.
    pub stress: &'static str,
    /// Seed of object and noise.
    pub seed: u64,
    /// Lifted, whole, and still in the fingers.
    pub held: bool,
    /// Fallen out of the fingers.
    pub dropped: bool,
    /// Pressed harder than it bears.
    pub crushed: bool,
    /// For a dropped object: whether a controller that knows everything would have kept it.
    pub holdable: Option<bool>,
    /// Needs at least 30 % less than what crushes it, and at most 1 / 1.2 of what the gripper can do.
    pub roomy: bool,
    /// How far it slipped (mm).
    pub slip_mm: f64,
    /// Slips that were noticed.
    pub slips: u64,
    /// Forces that were tried until the object was held: the first one and one for each slip that was answered; `None` from older laws.
    pub forces_tried: Option<u32>,
    /// What the object moved while slips were answered, as far as it was measured (mm).
    pub tried_mm: f32,
    /// From the lift to the end of the last slip (s).
    pub stable_s: f64,
    /// Largest force that it needed during the hold (N).
    pub force_needed_n: f64,
    /// Force that it needs at the end (N).
    pub needed_end_n: f64,
    /// Force at the end (N).
    pub force_final_n: f64,
    /// Largest force (N).
    pub force_peak_n: f64,
    /// Force that crushes it (N).
    pub crush_n: f64,
    /// Final over needed force.
    pub force_ratio: f64,
    /// Largest force commanded (N).
    pub peak_command_n: f32,
}

/// All grasps of a scene, done in one way.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Total {
    /// Name of the scene.
    pub scene: String,
    /// Who commanded the force.
    pub law: &'static str,
    /// What the gripper felt.
    pub sensors: &'static str,
    /// What went wrong.
    pub stress: &'static str,
    /// Grasps.
    pub trials: usize,
    /// Objects that fell.
    pub dropped: usize,
    /// Objects that were crushed.
    pub crushed: usize,
    /// Objects that fell, were crushed, or both.
    pub lost: usize,
    /// Dropped although a controller that knows everything would have kept it.
    pub dropped_holdable: usize,
    /// Objects that need at least 30 % less than what crushes them, and that the gripper can hold.
    pub roomy: usize,
    /// Those of them that fell.
    pub roomy_dropped: usize,
    /// Those of them that were crushed.
    pub roomy_crushed: usize,
    /// Those of them that fell, were crushed, or both.
    pub roomy_lost: usize,
    /// Those of them with a final force within 1.0 to 1.4 of the needed one.
    pub roomy_within_1_4: usize,
    /// How far objects slipped (mm); fallen ones are not counted here and below.
    pub slip_mm: Quantiles,
    /// Final over needed force.
    pub force_ratio: Quantiles,
    /// Largest over needed force.
    pub peak_ratio: Quantiles,
    /// Final force within 1.0 to 1.6 of the needed one.
    pub within_1_6: usize,
    /// Final force within 1.0 to 1.4 of the needed one.
    pub within_1_4: usize,
    /// Highest force that was commanded or applied (N).
    pub peak_n: f64,
    /// Slips that were noticed.
    pub slips: Quantiles,
    /// Forces that were tried.
    pub forces_tried: Quantiles,
    /// From the lift to the end of the last slip (s).
    pub stable_s: Quantiles,
}

/// The totals of `grasps`, which were done in the same way, under the name `scene`.
#[must_use]
pub fn total(scene: &str, grasps: &[&GraspResult]) -> Total {
    let count =
        |test: &dyn Fn(&GraspResult) -> bool| grasps.iter().filter(|grasp| test(grasp)).count();
    let of_kept = |value: &dyn Fn(&GraspResult) -> f64| {
        let kept = grasps.iter().filter(|grasp| !grasp.dropped);
        Quantiles::of(kept.map(|grasp| value(grasp)).collect())
    };
    let within = |grasp: &GraspResult, high: f64| (1.0..=high).contains(&grasp.force_ratio);
    let way = grasps.first();
    let slips = Quantiles::of(grasps.iter().map(|grasp| grasp.slips as f64).collect());
    Total {
        scene: scene.to_owned(),
        law: way.map_or("", |grasp| grasp.law),
        sensors: way.map_or("", |grasp| grasp.sensors),
        stress: way.map_or("", |grasp| grasp.stress),
        trials: grasps.len(),
        dropped: count(&|grasp| grasp.dropped),
        crushed: count(&|grasp| grasp.crushed),
        lost: count(&|grasp| grasp.dropped || grasp.crushed),
        dropped_holdable: count(&|grasp| grasp.holdable == Some(true)),
        roomy: count(&|grasp| grasp.roomy),
        roomy_dropped: count(&|grasp| grasp.roomy && grasp.dropped),
        roomy_crushed: count(&|grasp| grasp.roomy && grasp.crushed),
        roomy_lost: count(&|grasp| grasp.roomy && (grasp.dropped || grasp.crushed)),
        roomy_within_1_4: count(&|grasp| grasp.roomy && within(grasp, 1.4)),
        slip_mm: of_kept(&|grasp| grasp.slip_mm),
        force_ratio: of_kept(&|grasp| grasp.force_ratio),
        peak_ratio: of_kept(&|grasp| grasp.force_peak_n / grasp.force_needed_n),
        within_1_6: count(&|grasp| within(grasp, 1.6)),
        within_1_4: count(&|grasp| within(grasp, 1.4)),
        peak_n: grasps
            .iter()
            .map(|grasp| grasp.force_peak_n.max(f64::from(grasp.peak_command_n)))
            .fold(0.0, f64::max),
        slips,
        forces_tried: Quantiles::of(
            grasps.iter().filter_map(|grasp| grasp.forces_tried).map(f64::from).collect(),
        ),
        stable_s: of_kept(&|grasp| grasp.stable_s),
    }
}
