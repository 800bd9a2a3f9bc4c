//! Samples of a slip in; speed, features and the network's answer out.

use super::Pipeline;
use crate::{
    event::Step,
    sample::Sample,
    velocity::{Measured, Velocity},
};

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// Follows a slip: speed, irregularities and E_sc with every sample, features and the network's
    /// answer once a millisecond.
    pub(super) fn observe(&mut self, sample: &Sample, step: &mut Step) {
        self.counters.observation += 1;
        self.velocity.push(sample);
        if let Some(travel_m) = sample.travel_m {
            self.course.push(sample.t, travel_m);
        }
        if let (Some(normal_n), Some(tangential_n)) = (sample.normal_force_n, sample.tangential_n) {
            self.friction.push(normal_n, tangential_n, self.is_fresh(sample.t));
        }
        match self.speed_of_two_styli(sample) {
            Some(Velocity { speed_m_s, sigma_m_s, .. }) => {
                self.observation.trust_speed(Some(sigma_m_s));
                self.observation.push(&Sample { velocity_m_s: Some(speed_m_s), ..*sample });
            }
            None => {
                let direct = sample.velocity_m_s.map(|_| self.config.velocity.direct_sigma_m_s);
                let configured = self.config.observation.speed.fixed_m_s.is_some();
                self.observation.trust_speed(direct.filter(|_| !configured));
                self.observation.push(sample);
            }
        }
        let Some(slip) = &mut self.slip else { return };
        if sample.t < slip.next_evidence {
            return;
        }
        slip.next_evidence = sample.t.plus(self.evidence_every);
        let since = sample.t.since(slip.since);
        step.velocity = self.velocity.velocity(self.measured(sample), since);
        step.features = self.observation.features();
        if let (Some(features), Some(estimator)) = (&step.features, &self.estimator) {
            self.counters.inferences += 1;
            let answer = estimator.estimate(features);
            self.counters.refused_estimates += u64::from(answer.is_err());
            step.estimate = answer.ok();
        }
        // Where the network has nothing to go by.
        if !step.estimate.is_some_and(|estimate| estimate.is_trusted()) {
            step.estimate = self.friction.estimate().or(step.estimate);
        }
    }

    /// The speed of the two styli, where no other sensor tells it.
    #[inline]
    fn speed_of_two_styli(&self, sample: &Sample) -> Option<Velocity> {
        if sample.travel_m.is_some() || sample.velocity_m_s.is_some() {
            return None;
        }
        sample.second_stylus?;
        self.velocity.two_styli()
    }

    fn measured(&self, sample: &Sample) -> Measured {
        let travel = self.observation.travel_speed();
        Measured {
            fixed_m_s: self.config.observation.speed.fixed_m_s,
            direct_m_s: sample.velocity_m_s,
            travel: travel.map(|(speed, window)| (speed, window, self.config.travel.resolution_m)),
        }
    }
}
