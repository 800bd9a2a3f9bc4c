//! Simulation of a gripper around a simple object: what its sensors show under commands.

use slip_core::{
    Pipeline, PipelineConfig, Sample, Step,
    units::{Hertz, Micros},
};

pub(crate) type Bare = Pipeline<&'static [f32]>;

const G: f64 = 9.806_65;
/// Period and height of the texture (m).
const TEXTURE_M: (f64, f64) = (4e-4, 8e-6);
/// Lag of the fingers behind the command (s).
const LAG_S: f64 = 0.005;

/// An object of which friction and weight are described by one number, the force that just holds it. It leaves its support at
/// `lifted_s` and slides where the fingers press less.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Object {
    pub(crate) needed_n: f64,
    pub(crate) lifted_s: f64,
    rate_hz: f64,
    first_us: u64,
    index: u64,
    noise: u32,
    pub(crate) applied_n: f64,
    pub(crate) speed_m_s: f64,
    pub(crate) travel_m: f64,
}

impl Object {
    pub(crate) fn new(rate_hz: f64, needed_n: f64, lifted_s: f64) -> Self {
        Self {
            needed_n,
            lifted_s,
            rate_hz,
            first_us: 0,
            index: 0,
            noise: 1,
            applied_n: 0.0,
            speed_m_s: 0.0,
            travel_m: 0.0,
        }
    }

    /// The same on a clock that shows `us` at the first sample.
    pub(crate) fn starting_at(self, us: u64) -> Self {
        Self { first_us: us, ..self }
    }

    /// Time since the first sample (s).
    pub(crate) fn t_s(&self) -> f64 {
        self.index as f64 / self.rate_hz
    }

    /// The next sample, with the fingers driven by `command_n`.
    pub(crate) fn sample(&mut self, command_n: f64) -> Sample {
        let dt_s = 1.0 / self.rate_hz;
        self.applied_n += (command_n - self.applied_n) * (dt_s / LAG_S).min(1.0);
        if self.t_s() > self.lifted_s {
            let gain = G * (1.0 - self.applied_n / self.needed_n) * dt_s;
            let speed = (self.speed_m_s + gain).max(0.0);
            self.travel_m += 0.5 * (self.speed_m_s + speed) * dt_s;
            self.speed_m_s = speed;
        }
        self.noise = self.noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = 3.4e-7 * (f64::from(self.noise) / f64::from(u32::MAX) - 0.5);
        let phase = core::f64::consts::TAU * self.travel_m / TEXTURE_M.0;
        let t = Micros(self.first_us + (self.t_s() * 1e6).round() as u64);
        self.index += 1;
        Sample {
            normal_force_n: Some(self.applied_n as f32),
            travel_m: Some(self.travel_m as f32),
            ..Sample::stylus(t, (1e-4 + TEXTURE_M.1 * phase.sin() + noise) as f32)
        }
    }
}

/// A pipeline that grips an object, sample by sample.
#[derive(Debug)]
pub(crate) struct Loop {
    pub(crate) pipeline: Bare,
    pub(crate) object: Object,
    pub(crate) command_n: f32,
}

impl Loop {
    pub(crate) fn new(object: Object) -> Self {
        let config = PipelineConfig::gripping(Hertz(object.rate_hz as f32));
        Self { pipeline: Bare::new(config, None).unwrap(), object, command_n: 0.0 }
    }

    /// One sample as the sensors should show it, changed by `fault`.
    pub(crate) fn step(&mut self, fault: impl FnOnce(Sample) -> Sample) -> Step {
        let sample = fault(self.object.sample(f64::from(self.command_n)));
        let step = self.pipeline.handle(&sample);
        self.command_n = step.command.unwrap().0;
        assert!(self.command_n.is_finite() && step.statistic.is_finite(), "{step:?}");
        step
    }

    /// Steps without a fault up to the time `t_s`; gives those with an event.
    pub(crate) fn run_until(&mut self, t_s: f64) -> Vec<Step> {
        let mut events = Vec::new();
        while self.object.t_s() < t_s {
            let step = self.step(|sample| sample);
            events.extend(step.event.map(|_| step));
        }
        events
    }
}
