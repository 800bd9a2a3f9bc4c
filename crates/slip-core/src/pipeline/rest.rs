//! A sample at which nothing happens in; the word that few stages have to look at it, out.
//!
//! While no object is touched, the floor is known and the command stands, all that a sample can do is to wake
//! the pipeline: sensor, time and contact are checked, and that is all. While an object is held quietly, only the methods that may notice a slip
//! look at it: scene and command stay. The answer is the same as that of all stages together (test
//! `skipping_never_changes_a_step` compares every step).

use super::Pipeline;
use crate::{
    detector::SlipState, drift::Hold, fusion::Detection, grip::GripController,
    health::SensorHealth, methods::Method, sample::Sample, scene::Scene, units::Micros,
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

/// What the guard found.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rested {
    /// Every stage has to look at the sample.
    Not,
    /// Nothing happens; the statistic of the methods.
    Quiet {
        /// Slip statistic over its threshold.
        statistic: f32,
    },
    /// The rest ends: the stages up to the detection have looked at the sample.
    Ended {
        /// Time since the sample before.
        dt: Micros,
        /// Statistic and state of the stylus, where it is heard.
        stylus: Option<(f32, SlipState)>,
        /// What the methods detect together.
        detection: Option<Detection>,
    },
}

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// What samples like the last one need.
    #[inline]
    pub(super) fn rest_after(&self) -> Rest {
        let stylus = self.fusion.uses(Method::Stylus);
        let doubted = self.whiteness.is_noisy() || self.grip_force.is_numb();
        let learning = self.contact.is_learning() || stylus && self.detector.is_learning();
        let steady = !self.config.no_skip
            && self.slip.is_none()
            && self.health.health() == SensorHealth::Good
            && !doubted
            && !learning
            && self.grip.as_ref().is_none_or(GripController::is_steady);
        match self.scene {
            Scene::Idle if steady => Rest::Idle,
            // Fingers that let go, or closed on nothing.
            Scene::Moving if steady && !self.decides => Rest::Idle,
            Scene::Holding if steady && stylus && !self.detector.is_moving() => Rest::Holding,
            _ => Rest::Awake,
        }
    }

    /// The guard: what the few stages find that have to look at this `sample`, which the health check found plain.
    #[inline]
    pub(super) fn rested(&mut self, sample: &Sample, taxels: &[f32]) -> Rested {
        match self.rest_of(sample) {
            Rest::Idle => {
                self.last_t = Some(sample.t);
                Rested::Quiet { statistic: 0.0 }
            }
            Rest::Holding if taxels.is_empty() => self.hold(sample),
            Rest::Holding | Rest::Awake => Rested::Not,
        }
    }

    /// What this sample needs: [`Rest::Awake`] where it may end the rest.
    #[inline]
    fn rest_of(&self, sample: &Sample) -> Rest {
        let held = self.rest == Rest::Holding;
        let soon = self.last_t.is_some_and(|last| sample.t.since(last) <= self.gap);
        let measured = sample.travel_m.is_some();
        let updates = self.grip.as_ref().is_some_and(|grip| grip.heeds_travel(measured));
        if soon && !updates && self.contact.would_touch(sample.normal_force_n) == held {
            self.rest
        } else {
            Rest::Awake
        }
    }

    /// A sample without taxels at which the object is still held.
    #[inline]
    fn hold(&mut self, sample: &Sample) -> Rested {
        let dt = self.since_last(sample.t);
        self.health.watch_drift(sample, Hold::Still);
        self.compare_force(sample);
        if self.health.health() != SensorHealth::Good {
            let stylus = self.detect(sample);
            return Rested::Ended { dt, stylus, detection: self.fuse(sample, &[], stylus) };
        }
        let stylus = self.step_detector(sample);
        if self.detector.is_moving() {
            self.rest = Rest::Awake;
        }
        if !(stylus.is_some() && self.detector.in_block()) {
            return self.ask(sample, dt, stylus);
        }
        if let Some(travel_m) = sample.travel_m {
            self.counters.methods += 1;
            self.fusion.put_by(sample.t, travel_m);
        }
        Rested::Quiet { statistic: self.detection.map_or(0.0, |detection| detection.statistic) }
    }

    /// The same where the stylus has news.
    #[inline(never)]
    fn ask(&mut self, sample: &Sample, dt: Micros, stylus: Option<(f32, SlipState)>) -> Rested {
        let detection = self.fuse(sample, &[], stylus);
        if detection.is_some_and(|detection| detection.state != SlipState::Quiet) {
            return Rested::Ended { dt, stylus, detection };
        }
        Rested::Quiet { statistic: detection.map_or(0.0, |detection| detection.statistic) }
    }
}
