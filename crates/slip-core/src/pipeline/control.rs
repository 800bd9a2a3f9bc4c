//! The commanded force, from what is known of the slip, the force of the fingers and the time that the host allows.

use super::{Pipeline, Step, detect::Rest};
use crate::{
    alarm::Method,
    course::{Passing, Turns},
    estimate::{Estimator, Features, ForceEstimate, FrictionMeter, G_M_S2},
    grip::{GripEvent, GripInput, Sliding, SlipNow},
    health::SensorHealth,
    need::Felt,
    sample::Sample,
    units::{Micros, Newtons},
};

/// A mean over at most this long (s) states how an object slides now.
const LATELY_S: f32 = 0.01;

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// The command after this sample, of which `slip` is the step where one may be going on; `None` in a pipeline that only observes.
    #[inline]
    pub(super) fn control(
        &mut self,
        sample: &Sample,
        dt: Micros,
        slip: Option<&Step>,
    ) -> (Option<Newtons>, Option<GripEvent>) {
        let passing = self.passing();
        let Some(grip) = self.grip.as_mut() else { return (None, None) };
        let stylus = self.fusion.uses(Method::Stylus);
        if !(stylus && self.detector.is_learning()) {
            grip.grasp(sample.normal_force_n);
        }
        let travel = self.fusion.believed_travel(sample.travel_m);
        let felt = stylus && self.health.feels() && !self.whiteness.is_noisy();
        // Before an object is held the other sensors are not looked at.
        let healthy = felt || if self.decides { self.fusion.is_usable(sample.t) } else { !stylus };
        let loaded_n = if healthy { None } else { loaded_n(&mut self.friction, sample) };
        let complete = felt && self.health.health() == SensorHealth::Good;
        let impaired = stylus && !complete || !self.fusion.healthy();
        #[expect(clippy::cast_possible_truncation, reason = "the controller limits both")]
        let (dt_s, age_s) = (
            dt.as_seconds() as f32,
            sample.arrival.map_or(0.0, |arrival| arrival.age.as_seconds() as f32),
        );
        let mut input = GripInput {
            dt_s,
            passing,
            undecided: self.fusion.is_undecided(),
            alone_n: self.fusion.alone_n(),
            drifts: self.fusion.drifts(),
            travel_sigma_m: self.observation.travel_sigma_m(),
            rise_s: self.freshness.rise_s(),
            stale: self.freshness.is_stale(),
            age_s,
            travel: travel.is_some(),
            applied_n: sample.normal_force_n,
            touching: self.contact.is_touching(),
            touch_n: self.contact.touch_n(),
            healthy,
            loaded_n,
            impaired,
            slip: SlipNow::No,
            moved_m: None,
            estimate: None,
            sliding: None,
            motion: None,
            felt: None,
        };
        if let Some(step) = slip.filter(|_| self.slip.is_some()) {
            self.add_slip(sample, step, &mut input);
        }
        let Some(grip) = self.grip.as_mut() else { return (None, None) };
        (Some(Newtons(grip.step(&input))), grip.event())
    }

    /// What the controller has to know of the slip.
    fn add_slip(&self, sample: &Sample, step: &Step, input: &mut GripInput) {
        input.motion = sample.travel_m.and_then(|_| self.course.motion(sample.t));
        let sigma_m = self.observation.travel_sigma_m();
        let slides = input.motion.is_some_and(|motion| motion.slides(sigma_m));
        let stands = self.observation.advancing() == Some(false) && !self.fusion.is_undecided();
        let goes_on = self.is_fresh(sample.t) && !stands;
        input.slip = if goes_on || slides { SlipNow::Evident } else { SlipNow::Fading };
        input.felt = self.felt();
        // Without estimates the controller must not wait for one.
        let waits = self.estimator.as_ref().is_none_or(Estimator::is_trustworthy);
        input.moved_m = self.observation.moved_m(sample).filter(|_| waits);
        // An answer that nothing vouches for must not move the fingers.
        input.estimate = step.estimate.filter(ForceEstimate::is_trusted);
        input.sliding = step.features.as_ref().and_then(sliding_of);
    }

    fn felt(&self) -> Option<Felt> {
        let slip = self.slip.filter(|slip| slip.feels && slip.alone);
        slip.and_then(|_| self.need.felt())
    }

    /// Peaks and valleys that the stylus passes, where they are those of the surface: not the robot's motion, and not folded by a low rate.
    fn passing(&self) -> Option<Passing> {
        let counts =
            self.config.sample_rate.0 >= Turns::LEAST_RATE_HZ && !self.detector.is_moving();
        self.turns.passing().filter(|_| counts)
    }

    /// Holds with at least `force_n` (N) from the next sample on; see [`GripController::at_least`](crate::grip::GripController::at_least).
    pub fn at_least(&mut self, force_n: f32) {
        self.rest = Rest::Awake;
        if let Some(grip) = &mut self.grip {
            grip.at_least(force_n);
        }
    }

    /// Expects an object that is known to be held with `force_n` (N); see
    /// [`GripController::expect`](crate::grip::GripController::expect).
    pub fn expect(&mut self, force_n: f32) {
        self.rest = Rest::Awake;
        if let Some(grip) = &mut self.grip {
            grip.expect(force_n);
        }
    }

    /// Lets go of the object, until [`Pipeline::close_again`].
    pub fn release(&mut self) {
        self.rest = Rest::Awake;
        if let Some(grip) = &mut self.grip {
            grip.release();
        }
    }

    /// Ends a release: the fingers close to the trial force.
    pub fn close_again(&mut self) {
        self.rest = Rest::Awake;
        if let Some(grip) = &mut self.grip {
            grip.close_again();
        }
    }
}

/// The force (N) that the load needs by the tangential force, where that is all there is.
fn loaded_n(friction: &mut FrictionMeter, sample: &Sample) -> Option<f32> {
    friction.watch(sample.normal_force_n?, sample.tangential_n?);
    friction.loaded_n()
}

/// How the object slides. A mean over more than some milliseconds states too little of now.
fn sliding_of(features: &Features) -> Option<Sliding> {
    (features.contact_time_s <= LATELY_S).then(|| Sliding {
        force_n: features.trial_force_n,
        acceleration_g: features.slip_acceleration_m_s2 / G_M_S2,
    })
}
