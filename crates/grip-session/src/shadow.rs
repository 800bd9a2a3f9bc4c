//! Comparison of a second model with the estimate in force after a slip: the adequate force by both. The second model moves nothing.

use crate::{model::HostEstimator, report::EventLog};
use grip_link::message::daemon::{Estimates, Unsure};
use slip_core::{
    estimate::{Features, ForceEstimate},
    units::Micros,
};

/// What a slip that has ended showed last, and what the controller made of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlipEvidence {
    /// Device time of the end.
    pub t: Micros,
    /// What a model is asked about.
    pub features: Features,
    /// What the controller had: the answer of the model in force, or the friction that was measured instead.
    pub estimate: Option<ForceEstimate>,
}

impl SlipEvidence {
    /// That of the slip that has just ended at `t`; `None` where it showed nothing.
    #[must_use]
    pub fn of(log: &EventLog, t: Micros) -> Option<Self> {
        let (features, estimate) = log.evidence();
        features.map(|features| Self { t, features, estimate })
    }

    /// Asks a second model about the same slip. Number and host time are left at 0.
    #[must_use]
    pub fn beside(&self, shadow: &HostEstimator) -> Estimates {
        let answer = shadow.estimate(&self.features).ok();
        let unsure = |estimate: Option<ForceEstimate>| estimate.is_some_and(|e| !e.is_trusted());
        Estimates {
            slip: 0,
            t: self.t,
            host: Micros(0),
            slipped_n: Some(self.features.trial_force_n).filter(|force_n| force_n.is_finite()),
            in_force_n: self.estimate.map(|estimate| estimate.force_n),
            shadow_n: answer.map(|estimate| estimate.force_n),
            unsure: Unsure::default()
                .with(Unsure::IN_FORCE, unsure(self.estimate))
                .with(Unsure::SHADOW, unsure(answer)),
        }
    }
}
