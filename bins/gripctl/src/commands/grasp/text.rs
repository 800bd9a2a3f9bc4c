//! Lines for people about grasps and totals.

use crate::{
    output::{self, or_dash},
    table,
};
use grip_eval::grasp::{GraspResult, Total};

pub(super) fn grasp(grasp: &GraspResult) -> String {
    let fate = match grasp {
        GraspResult { dropped: true, .. } => "dropped",
        GraspResult { crushed: true, .. } => "crushed",
        GraspResult { held: true, .. } => "held",
        _ => "not lifted",
    };
    format!(
        "{:18} {:22} seed {:4}  {fate:8} slip {:6.2} mm in {:2} slips, force {:6.2} N of {:6.2} N needed (x {:.2}), peak {:6.2} N",
        grasp.scene,
        way(grasp.law, grasp.sensors, grasp.stress),
        grasp.seed,
        grasp.slip_mm,
        grasp.slips,
        grasp.force_final_n,
        grasp.force_needed_n,
        grasp.force_ratio,
        grasp.force_peak_n
    )
}

/// The line of a scene whose objects were grasped in one way.
pub(super) fn total(total: &Total) -> String {
    format!(
        "{:18} {} grasps: {} dropped ({} of them holdable), {} crushed; slip median {} mm, 95 % {} mm; final force over needed median {}, 95 % {}; within 1.0-1.6: {}, within 1.0-1.4: {}; peak over needed median {}, 95 % {}; slips median {}, forces tried median {}, stable after {} s; highest force {:.1} N; with room: {}",
        total.scene,
        total.trials,
        total.dropped,
        total.dropped_holdable,
        total.crushed,
        or_dash(total.slip_mm.p50, 2),
        or_dash(total.slip_mm.p95, 2),
        or_dash(total.force_ratio.p50, 2),
        or_dash(total.force_ratio.p95, 2),
        total.within_1_6,
        total.within_1_4,
        or_dash(total.peak_ratio.p50, 2),
        or_dash(total.peak_ratio.p95, 2),
        or_dash(total.slips.p50, 0),
        or_dash(total.forces_tried.p50, 0),
        or_dash(total.stable_s.p50, 2),
        total.peak_n,
        with_room(total)
    )
}

/// A title, a row for each way of grasping, and an empty line.
pub(super) fn table(totals: &[Total]) -> anyhow::Result<()> {
    let (name, trials) = totals.first().map_or(("", 0), |total| (&total.scene, total.trials));
    output::line(&format!("{name}: {trials} grasps each; median / 95 %"))?;
    let way = ["law", "sensors", "stress", "dropped", "crushed", "slip_mm"];
    let forces = ["peak/needed=peak_ratio", "final/needed=force_ratio", "1.0-1.4=within_1_4"];
    let room = ["with room=roomy", "lost=roomy_lost", "1.0-1.4=roomy_within_1_4"];
    let columns = [&way[..], &forces, &["slips", "stable_s"], &room].concat();
    table::print(totals, &columns)?;
    Ok(output::line("")?)
}

/// Of the objects that can be held with something to spare: how many were lost, and how many are held well.
fn with_room(total: &Total) -> String {
    let Total { roomy, roomy_lost, roomy_within_1_4, .. } = total;
    format!("{roomy_lost} of {roomy} lost, {roomy_within_1_4} within 1.0-1.4")
}

/// Law, sensors and trouble, without what goes without saying.
pub(super) fn way(law: &str, sensors: &str, stress: &str) -> String {
    let mut name = law.to_owned();
    if sensors != "scene" {
        name = format!("{name}, {sensors}");
    }
    if stress != "none" {
        name = format!("{name}, {stress}");
    }
    name
}
