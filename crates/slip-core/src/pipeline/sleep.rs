//! A sample at which nothing happens in; the word that no stage has to look at it, out.
//!
//! While no object is touched, the floor is known and the command stands, all that a sample can do is to wake
//! the pipeline. What is checked here for each of them is the sensor's health, the time and the contact, and the answer is the
//! same as that of all stages together (test `skipping_never_changes_a_step` compares every step).

use super::Pipeline;
use crate::{health::Health, methods::Method, sample::Sample, scene::Scene};

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// Whether samples like the last one change nothing but the time.
    #[inline]
    pub(super) fn may_sleep(&self) -> bool {
        self.scene == Scene::Idle
            && !self.config.no_skip
            && self.health.health() == Health::Good
            && !(self.fusion.uses(Method::Stylus) && self.detector.is_learning())
            && self.grip.is_none_or(|grip| grip.is_steady())
    }

    /// Whether the pipeline sleeps and this sample, found plain by the health check, does not wake it.
    #[inline]
    pub(super) fn sleeps_through(&mut self, sample: &Sample) -> bool {
        let Some(last_t) = self.last_t.filter(|_| self.asleep) else { return false };
        if sample.t.since(last_t) > self.gap || self.contact.would_touch(sample.normal_force_n) {
            return false;
        }
        self.last_t = Some(sample.t);
        true
    }
}
