//! What is known of the slip in, the commanded force out, by the force of the fingers and the time that the host allows.

use super::{Pipeline, detect::Rest};
use crate::{
    alarm::Method,
    estimate::FrictionMeter,
    grip::{GripEvent, GripInput, GripState, SlipNow},
    health::SensorHealth,
    sample::Sample,
    units::{Micros, Newtons},
};

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// The command after this sample; `None` in a pipeline that only observes.
    #[inline]
    pub(super) fn control(
        &mut self,
        sample: &Sample,
        dt: Micros,
    ) -> (Option<Newtons>, Option<GripEvent>) {
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
        #[expect(clippy::cast_possible_truncation, reason = "the controller limits it")]
        let (dt_s, late_s) = (dt.as_seconds() as f32, self.freshness.late_s());
        let mut input = GripInput {
            dt_s,
            rise_s: self.freshness.rise_s(),
            stale: self.freshness.is_stale(),
            late_s,
            travel: travel.is_some(),
            applied_n: sample.normal_force_n,
            touching: self.contact.is_touching(),
            touch_n: self.contact.touch_n(),
            healthy,
            loaded_n,
            impaired,
            slip: SlipNow::No,
            moved_m: None,
            forecast: None,
            predicted_n: 0.0,
            dead_s: 0.0,
            lag_s: 0.0,
        };
        if self.slip.is_some() || grip.state() == GripState::Slipping {
            self.add_slip(sample, &mut input);
        }
        let Some(grip) = self.grip.as_mut() else { return (None, None) };
        (Some(Newtons(grip.step(&input))), grip.event())
    }

    /// What the controller has to know of the slip.
    fn add_slip(&self, sample: &Sample, input: &mut GripInput) {
        let forecast = *self.load.forecast();
        let evident = self.is_fresh(sample.t) || forecast.moves;
        input.slip = match self.slip {
            Some(_) if evident => SlipNow::Evident,
            Some(_) => SlipNow::Fading,
            None => SlipNow::No,
        };
        input.moved_m = self.observation.moved_m(sample);
        input.forecast = Some(forecast);
        if let Some(grip) = &self.grip {
            let drive = grip.drive();
            input.lag_s = drive.drive_lag_s();
            input.dead_s = drive.line_dead_s(input.late_s);
            input.predicted_n = drive.on_way_n();
        }
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
