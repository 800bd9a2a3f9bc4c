//! Rows of a table of grippers and sensors, from grasps of the same objects by several controllers.
//!
//! A cell is a gripper with a set of sensors ([`grip_sim::scene::Part`]). In it every law grasps the objects of the same seeds over the same
//! drive, line and sensors. What the oracle loses, no controller that waits for the slip can be asked to hold; so each law has a count of
//! what it loses of the objects that the oracle keeps.

use super::{GraspResult, Law, Total, total};
use crate::score::interval::{Interval, share};
use serde::Serialize;
use std::collections::BTreeSet;

/// A law in a cell.
#[derive(Clone, Debug, Serialize)]
pub struct MatrixRow {
    /// `matrix`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Name of the gripper.
    pub gripper: String,
    /// Name of its sensors.
    pub sensing: String,
    /// What became of the objects.
    #[serde(flatten)]
    pub total: Total,
    /// Exact interval (95 %) of the share of lost objects.
    pub lost_share: Interval,
    /// Objects that the oracle keeps whole.
    pub kept_by_oracle: usize,
    /// Those of them that this law lost.
    pub lost_of_kept: usize,
    /// Exact interval (95 %) of that share.
    pub lost_of_kept_share: Interval,
}

/// A row for each of `laws`; `grasps` are those of one cell.
#[must_use]
pub fn rows(gripper: &str, sensing: &str, laws: &[Law], grasps: &[GraspResult]) -> Vec<MatrixRow> {
    let of = |law: Law| grasps.iter().filter(move |grasp| grasp.law == law.name());
    let lost = |grasp: &GraspResult| grasp.dropped || grasp.crushed;
    let kept: BTreeSet<u64> =
        of(Law::Oracle).filter(|grasp| !lost(grasp)).map(|grasp| grasp.seed).collect();
    let row = |&law: &Law| {
        let total = total(gripper, &of(law).collect::<Vec<_>>());
        let of_kept = of(law).filter(|grasp| lost(grasp) && kept.contains(&grasp.seed)).count();
        MatrixRow {
            kind: "matrix",
            gripper: gripper.to_owned(),
            sensing: sensing.to_owned(),
            lost_share: share(total.lost, total.trials),
            kept_by_oracle: kept.len(),
            lost_of_kept: of_kept,
            lost_of_kept_share: share(of_kept, kept.len()),
            total,
        }
    };
    laws.iter().map(row).collect()
}

/// Whether gripd loses no more objects than any older law in the cell of these `rows`; the oracle is no law.
#[must_use]
pub fn own_is_first(rows: &[MatrixRow]) -> bool {
    let is = |row: &MatrixRow, law: Law| row.total.law == law.name();
    let Some(own) = rows.iter().find(|row| is(row, Law::Own)) else { return false };
    let mut others = rows.iter().filter(|row| !is(row, Law::Own) && !is(row, Law::Oracle));
    others.all(|other| own.total.lost <= other.total.lost)
}

#[cfg(test)]
mod tests {
    use super::{own_is_first, rows};
    use crate::grasp::{Bench, GraspResult, Law, Way};
    use grip_session::{config::HostConfig, model};
    use grip_sim::scene;
    use slip_core::units::Micros;

    fn grasp(law: Law, seed: u64, dropped: bool) -> GraspResult {
        let bench = Bench {
            config: HostConfig::default(),
            estimator: model::default_estimator().unwrap(),
            duration: Micros(20_000),
        };
        let way = Way { law, ..Way::default() };
        let scene = scene::load("default").unwrap();
        GraspResult { dropped, crushed: false, ..bench.grasp(&scene, seed, &way).unwrap() }
    }

    #[test]
    fn only_what_the_oracle_keeps_counts_against_a_law() {
        let laws = [Law::Own, Law::Fft, Law::Oracle];
        // The oracle loses 2; gripd loses 2 and 3, fft only 2 or all of them.
        let fates = |fft: [bool; 3]| {
            let own = [false, true, true].map(|lost| (Law::Own, lost));
            let oracle = [false, true, false].map(|lost| (Law::Oracle, lost));
            let all = [own, fft.map(|lost| (Law::Fft, lost)), oracle];
            let one = |fates: [(Law, bool); 3]| {
                (1..).zip(fates).map(|(seed, (law, lost))| grasp(law, seed, lost))
            };
            all.into_iter().flat_map(one).collect::<Vec<_>>()
        };
        let better = rows("g", "s", &laws, &fates([false, true, false]));
        let counts = |rows: &[super::MatrixRow]| {
            rows.iter()
                .map(|row| (row.total.lost, row.lost_of_kept, row.kept_by_oracle))
                .collect::<Vec<_>>()
        };
        assert_eq!(counts(&better), [(2, 1, 2), (1, 0, 2), (1, 0, 2)]);
        assert!(!own_is_first(&better));
        assert!(own_is_first(&rows("g", "s", &laws, &fates([true; 3]))));
        assert!(!own_is_first(&[]));
    }
}
