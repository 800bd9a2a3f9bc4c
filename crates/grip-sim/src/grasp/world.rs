//! The constants of a scene's run, and what acts on the object at a time.

use crate::actuator::ActuatorConfig;
use crate::friction::LuGreConfig;
use crate::scene::{Acting, Load, Object, Scene};

/// Constants of the run, in SI.
#[derive(Clone, Copy, Debug)]
pub(super) struct World {
    pub(super) object: Object,
    /// What happens during the hold; `None` where the weight is all.
    load: Option<Load>,
    pub(super) lift_after_s: f64,
    ramp_s: f64,
    pub(super) finger_m: f64,
    pub(super) sink_m_n: f64,
    step_max_s: f64,
    pub(super) step_s: f64,
    pub(super) steps_per_sample: u32,
    pub(super) steps_per_ms: u32,
}

impl World {
    pub(super) fn of(scene: &Scene) -> Self {
        let config = scene.config();
        let mut world = Self {
            object: scene.object(),
            load: Some(scene.load()).filter(|load| !load.is_still()),
            lift_after_s: config.lift_at_s,
            ramp_s: config.lift_ramp_s,
            finger_m: config.finger_length_mm * 1e-3,
            sink_m_n: config.pad.sink_um_n * 1e-6,
            step_max_s: config.step_us * 1e-6,
            step_s: 0.0,
            steps_per_sample: 1,
            steps_per_ms: 1,
        };
        world.set_rate(config.sample_rate_hz);
        world
    }

    /// Divides the sample period into the fewest steps that are short enough.
    pub(super) fn set_rate(&mut self, rate_hz: u32) {
        let period_s = 1.0 / f64::from(rate_hz);
        self.steps_per_sample = steps(period_s, self.step_max_s);
        self.step_s = period_s / f64::from(self.steps_per_sample);
        self.steps_per_ms = steps(1e-3, self.step_s);
    }

    /// What acts `since_lift` (s); `None` where nothing but the weight ever does.
    pub(super) fn acting(&self, since_lift: f64) -> Option<Acting> {
        self.load.map(|load| load.at(since_lift))
    }

    /// Share of the weight that the support has handed over.
    pub(super) fn share(&self, since_lift: f64) -> f64 {
        if since_lift < self.ramp_s { since_lift / self.ramp_s } else { 1.0 }
    }

    /// Acceleration by the weight alone (m/s^2).
    pub(super) fn weight(&self, since_lift: f64) -> f64 {
        self.share(since_lift) * self.object.gravity_m_s2
    }
}

/// Fewest steps of at most `step_s` that make `time_s`. The margin keeps a quotient like 10.000000000000002 at 10.
fn steps(time_s: f64, step_s: f64) -> u32 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "1 to 10^6: at most 1 s in steps of at least 1 us"
    )]
    let count = (time_s / step_s - 1e-9).ceil().max(1.0) as u32;
    count
}

pub(super) fn drive_of(scene: &Scene) -> ActuatorConfig {
    scene.config().drive.actuator()
}

pub(super) fn contact_of(scene: &Scene) -> LuGreConfig {
    let pad = scene.config().pad;
    LuGreConfig {
        stiffness_n_m: pad.shear_n_mm * 1e3,
        damping_n_s_m: pad.damping_n_s_m,
        kinetic: scene.object().friction,
        static_ratio: scene.object().friction_ratio,
        stribeck_m_s: pad.stribeck_mm_s * 1e-3,
        elastic_share: pad.elastic_share,
    }
}
