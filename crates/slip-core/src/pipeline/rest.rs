//! A sample at which nothing happens in; the word that few stages have to look at it, out.
//!
//! While no object is touched, the floor is known and the command stands, all that a sample can do is to wake
//! the pipeline: sensor, time and contact are checked, and that is all. While an object is held quietly, only the methods that may notice a slip
//! look at it: scene and command stay. The answer is the same as that of all stages together (test
//! `skipping_never_changes_a_step` compares every step).

use super::Pipeline;
use crate::{
    detector::SlipState, drift::Hold, event::Step, fusion::Told, health::SensorHealth,
    methods::Method, sample::Sample, scene::Scene, units::Micros,
};

/// What a sample like the last one needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Rest {
    /// Every stage of its scene.
    #[default]
    Awake,
    /// The methods that may notice a slip: an object is held and nothing happens.
    Holding,
    /// No stage: nothing is touched.
    Idle,
}

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// What samples like the last one need.
    #[inline]
    pub(super) fn rest_after(&self) -> Rest {
        let stylus = self.fusion.uses(Method::Stylus);
        let doubted = self.whiteness.is_noisy() || self.grip_force.is_numb();
        let steady = !self.config.no_skip
            && self.slip.is_none()
            && self.health.health() == SensorHealth::Good
            && !doubted
            && !(stylus && self.detector.is_learning())
            && self.grip.is_none_or(|grip| grip.is_steady());
        match self.scene {
            Scene::Idle if steady => Rest::Idle,
            Scene::Holding if steady && stylus && !self.detector.is_moving() => Rest::Holding,
            _ => Rest::Awake,
        }
    }

    /// What this sample, found plain by the health check, needs: [`Rest::Awake`] where it may end the rest.
    #[inline]
    pub(super) fn rest_of(&self, sample: &Sample) -> Rest {
        let held = self.rest == Rest::Holding;
        let soon = self.last_t.is_some_and(|last| sample.t.since(last) <= self.gap);
        let news = sample.travel_m.is_some() && self.grip.is_some_and(|grip| grip.awaits_travel());
        if soon && !news && self.contact.would_touch(sample.normal_force_n) == held {
            self.rest
        } else {
            Rest::Awake
        }
    }

    /// The step of a sample without taxels at which the object is still held.
    pub(super) fn hold(&mut self, sample: &Sample) -> Step {
        let dt = self.since_last(sample.t);
        self.health.watch_drift(sample, Hold::Still);
        self.compare_force(sample);
        if self.health.health() != SensorHealth::Good {
            self.rest = Rest::Awake;
            return self.examine(sample, &[], dt);
        }
        let felt = self.feel_for_slip(sample);
        if self.detector.is_moving() {
            self.rest = Rest::Awake;
        }
        if !(felt.is_some() && self.detector.in_block()) {
            return self.ask(sample, dt, felt);
        }
        if let Some(travel_m) = sample.travel_m {
            self.counters.methods += 1;
            self.fusion.put_by(sample.t, travel_m);
        }
        let statistic = self.told.map_or(0.0, |told| told.statistic);
        Step { statistic, ..self.unchanged(sample.t) }
    }

    /// The same where the stylus has news.
    #[inline(never)]
    fn ask(&mut self, sample: &Sample, dt: Micros, felt: Option<(f32, SlipState)>) -> Step {
        let told = self.join(sample, &[], felt);
        match told {
            Some(Told { state: SlipState::Incipient | SlipState::Gross, .. }) => {
                self.conclude(sample, dt, felt, told)
            }
            _ => Step {
                statistic: told.map_or(0.0, |told| told.statistic),
                ..self.unchanged(sample.t)
            },
        }
    }
}
