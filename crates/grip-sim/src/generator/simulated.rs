//! The simulated slip of an object under a trial force, from its onset to a given travel.

use super::Slip;
use crate::grasp::{Grasp, LANDING_M};
use crate::scene::{Object, Scene, SceneError};

/// Touch, settle, then hand over the weight at once; no sensor is read.
pub(super) fn base_scene() -> Result<Scene, SceneError> {
    Scene::from_toml(
        "name = \"trial grasp\"\nlift_at_s = 0.05\nlift_ramp_s = 0.0\n[drive]\napproach_ms = 1.0\n",
    )
}

/// Plays the trial grasp sample by sample. The drive has settled to exp(-10) of the trial force at the lift.
pub(super) fn slip(base: &Scene, object: Object, trial_n: f64, travel_m: f64) -> Slip {
    let mut grasp = Grasp::new(&base.clone().with_object(object));
    let period_s = grasp.period_s();
    while !grasp.truth().slipping {
        grasp.step_sample(trial_n);
    }
    let onset = grasp.truth();
    let (mut impulse, mut last) = (0.0, onset);
    while last.travel_m - onset.travel_m < travel_m && !last.dropped() {
        grasp.step_sample(trial_n);
        let now = grasp.truth();
        impulse += 0.5 * (last.applied_n + now.applied_n) * period_s;
        last = now;
    }
    let time_s = last.time_s - onset.time_s;
    Slip {
        travel_m: last.travel_m - onset.travel_m,
        speed_m_s: last.speed_m_s - onset.speed_m_s,
        gained_m_s: last.speed_m_s - onset.speed_m_s,
        time_s,
        force_n: impulse / time_s,
        start_m: LANDING_M + onset.travel_m,
    }
}
