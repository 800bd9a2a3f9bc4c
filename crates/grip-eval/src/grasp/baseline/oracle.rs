//! Oracle, a bound for every controller: from the first sample of a slip on it applies the force that the object will need in truth.

use super::ForceLaw;
use crate::grasp::play::Setup;
use grip_sim::Truth;
use slip_core::Sample;

/// Rounding of a time stamp (s).
const TICK_S: f64 = 1e-6;

/// Knows mass, friction and everything that will act on the object, and is shown where the slip begins. It applies the trial force until
/// the sample in which the object began to slip has arrived over the line, and `factor` times the largest force that the hold will need
/// from then on. Drive, line and force limits are those of every other law; what the sensors read does not matter to it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Oracle {
    trial_n: f64,
    hold_n: f64,
    slips_from_s: Option<f64>,
    acts: bool,
}

impl Oracle {
    /// Force over the needed one, where nobody asks for another.
    pub(crate) const FACTOR: f64 = 1.3;

    pub(crate) fn new(setup: &Setup<'_>, factor: f64) -> Self {
        let scene = setup.scene.config();
        let lift_s = 1e-3 * scene.drive.approach_ms + scene.lift_at_s;
        let hold_s = (setup.duration.as_seconds() - lift_s).max(0.0);
        Self {
            trial_n: f64::from(setup.config.grip.trial_force_n),
            hold_n: factor * setup.scene.force_needed_n(hold_s),
            slips_from_s: None,
            acts: false,
        }
    }
}

impl ForceLaw for Oracle {
    fn learn(&mut self, _sample: &Sample) {}

    fn witness(&mut self, truth: &Truth) {
        // A slip within the last batch may be over already.
        if self.slips_from_s.is_none() && (truth.slipping || truth.stable_after_s > 0.0) {
            self.slips_from_s = Some(truth.time_s);
        }
    }

    fn force_n(&mut self, sample: &Sample) -> f64 {
        let arrived = |from_s: f64| sample.t.as_seconds() > from_s - TICK_S;
        self.acts |= self.slips_from_s.is_some_and(arrived);
        if self.acts { self.hold_n } else { self.trial_n }
    }

    fn slips(&self) -> u64 {
        u64::from(self.acts)
    }
}
