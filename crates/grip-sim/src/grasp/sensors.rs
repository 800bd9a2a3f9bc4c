//! Sensor model: one noisy [`Sample`] of the true values.
//!
//! Styli and forces carry white Gaussian noise. The moved distance stands for an optical displacement
//! sensor or a roller with encoder: Gaussian jitter, then rounding to its resolution (1 um by default).
//! Every channel draws its noise at every sample, switched on or not, so that leaving a channel out does not
//! change the others. What a sensor measures is multiplied by its gain; its noise is not. A sensor that is read more seldom than the samples
//! are taken, or late, shows its last reading ([`ReadingConfig`]).

use crate::disturbance::Disturbance;
use crate::random::{self, Purpose};
use crate::scene::{
    ACCELERATION_SPAN_M_S2, ChannelConfig, Gains, MotionConfig, ReadingConfig, STYLUS_SPAN_M,
    SceneConfig, VibrationConfig,
};
use crate::vibration::Vibration;
use rand_chacha::ChaCha8Rng;
use slip_core::sample::Sample;
use slip_core::units::Micros;
use std::collections::VecDeque;

/// What ideal sensors would show.
#[derive(Clone, Copy, Debug)]
pub(super) struct Readings {
    pub(super) t: Micros,
    pub(super) stylus_m: f64,
    /// Speed of sliding (m/s), for an accelerometer.
    pub(super) slides_m_s: f64,
    pub(super) second_m: Option<f64>,
    pub(super) force_n: f64,
    pub(super) travel_m: f64,
    pub(super) tangential_n: f64,
}

#[derive(Clone, Debug)]
pub(super) struct Sensors {
    rng: ChaCha8Rng,
    /// Of its own, so that a second stylus does not change the other channels.
    second_rng: ChaCha8Rng,
    /// Of its own, like that of the second stylus.
    tangential_rng: ChaCha8Rng,
    gains: Gains,
    channels: ChannelConfig,
    stylus_rms_m: f64,
    force_rms_n: f64,
    travel_rms_m: f64,
    travel_step_m: f64,
    tangential_rms_n: f64,
    drift_n_s: f64,
    /// Steps of the converter of stylus or accelerometer, and of the forces.
    adc: [f64; 2],
    /// Moved distance, normal and tangential force.
    slow: [Held; 3],
    robot: MotionConfig,
    seed: u64,
    motion: Option<Disturbance>,
    accelerometer: Option<VibrationConfig>,
    vibration: Option<Vibration>,
}

impl Sensors {
    pub(super) fn new(config: &SceneConfig, gains: Gains) -> Self {
        let reading = config.reading;
        let stylus_span =
            if config.vibration.is_some() { ACCELERATION_SPAN_M_S2 } else { STYLUS_SPAN_M };
        let mut sensors = Self {
            rng: random::stream(config.seed, Purpose::SensorNoise),
            second_rng: random::stream(config.seed, Purpose::SecondStylus),
            tangential_rng: random::stream(config.seed, Purpose::Tangential),
            gains,
            tangential_rms_n: config.noise.tangential_mn * 1e-3,
            channels: config.channels,
            stylus_rms_m: config.noise.stylus_um * 1e-6,
            force_rms_n: config.noise.force_mn * 1e-3,
            travel_rms_m: config.noise.travel_um * 1e-6,
            robot: config.motion,
            seed: config.seed,
            motion: None,
            accelerometer: config.vibration,
            vibration: None,
            travel_step_m: config.noise.travel_step_um * 1e-6,
            drift_n_s: reading.force_drift_mn_s * 1e-3,
            adc: [stylus_span, 1.25 * config.drive.force_max_n].map(|span| reading.adc_step(span)),
            slow: Held::of(&reading),
        };
        sensors.set_rate(config.sample_rate_hz);
        sensors
    }

    /// The motion of the robot begins anew at this sample rate. A robot that stands still costs nothing; with a
    /// reference it runs at level 0, for the noise of that sensor.
    pub(super) fn set_rate(&mut self, rate_hz: u32) {
        let MotionConfig { level, taps_per_s } = self.robot;
        let moves = level > 0.0 || taps_per_s > 0.0 || self.channels.reference;
        self.motion =
            moves.then(|| Disturbance::new(level, taps_per_s, f64::from(rate_hz), self.seed));
        let config = self.accelerometer.as_ref();
        self.vibration = config.map(|config| Vibration::new(config, f64::from(rate_hz), self.seed));
    }

    pub(super) fn read(&mut self, ideal: Readings) -> Sample {
        let motion = self.motion.as_mut().map(Disturbance::next_sample).unwrap_or_default();
        let gains = self.gains;
        let stylus = gains.stylus * (ideal.stylus_m + motion.stylus_m)
            + self.stylus_rms_m * random::normal(&mut self.rng);
        let drift_n = self.drift_n_s * ideal.t.as_seconds();
        let force = gains.force * ideal.force_n
            + drift_n
            + self.force_rms_n * random::normal(&mut self.rng);
        let travel =
            gains.travel * ideal.travel_m + self.travel_rms_m * random::normal(&mut self.rng);
        let travel = (travel / self.travel_step_m).round() * self.travel_step_m;
        let second = ideal.second_m.map(|second_m| {
            gains.stylus * (second_m + motion.stylus_m)
                + self.stylus_rms_m * random::normal(&mut self.second_rng)
        });
        let tangential = self.channels.tangential.then(|| {
            gains.tangential * ideal.tangential_n
                + self.tangential_rms_n * random::normal(&mut self.tangential_rng)
        });
        let vibration = self.vibration.as_mut();
        let vibration_m_s2 =
            vibration.map(|vibration| gains.stylus * vibration.next_m_s2(ideal.slides_m_s));
        let reference = gains.stylus * motion.reference_m;
        let ([stylus_step, force_step], t) = (self.adc, ideal.t);
        let [held_travel, held_force, held_tangential] = &mut self.slow;
        let travel = held_travel.show(t, travel);
        let force = held_force.show(t, on_step(force, force_step));
        let tangential =
            tangential.map(|tangential| held_tangential.show(t, on_step(tangential, force_step)));
        let stylus = on_step(vibration_m_s2.unwrap_or(stylus), stylus_step);
        Sample {
            second_stylus: second.map(|second| narrow(on_step(second, stylus_step))),
            normal_force_n: self.channels.force.then_some(narrow(force)),
            tangential_n: tangential.map(narrow),
            travel_m: self.channels.travel.then_some(narrow(travel)),
            reference: self.channels.reference.then_some(narrow(reference)),
            ..Sample::stylus(t, narrow(stylus))
        }
    }
}

/// On the nearest multiple of `step`, where there is one.
fn on_step(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}

/// A sensor that is read seldom or late.
#[derive(Clone, Debug, Default)]
struct Held {
    period: Micros,
    delay: Micros,
    next: Micros,
    shown: f64,
    /// Readings that are not shown yet, and when.
    ahead: VecDeque<(Micros, f64)>,
}

impl Held {
    /// Of moved distance, normal and tangential force.
    fn of(config: &ReadingConfig) -> [Self; 3] {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 1e6 us")]
        let micros = |seconds: f64| Micros((1e6 * seconds).round() as u64);
        let period = |hz: f64| if hz > 0.0 { micros(1.0 / hz) } else { Micros(0) };
        let delay = micros(1e-3 * config.travel_delay_ms);
        let travel = Self { period: period(config.travel_hz), delay, ..Self::default() };
        let force = Self { period: period(config.force_hz), ..Self::default() };
        [travel, force.clone(), force]
    }

    /// What is shown at `t`, where an ideal sensor would read `value`.
    fn show(&mut self, t: Micros, value: f64) -> f64 {
        if t >= self.next {
            self.next = t.plus(self.period);
            self.ahead.push_back((t.plus(self.delay), value));
        }
        while let Some((_, due)) = self.ahead.pop_front_if(|(at, _)| *at <= t) {
            self.shown = due;
        }
        self.shown
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a sensor reading has the 24 bits of an f32")]
pub(crate) fn narrow(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::Held;
    use crate::scene::ReadingConfig;
    use slip_core::units::Micros;

    #[test]
    fn a_seldom_and_late_sensor_shows_what_an_array_of_the_past_does() {
        let config =
            ReadingConfig { travel_hz: 500.0, travel_delay_ms: 3.0, ..ReadingConfig::default() };
        let [mut travel, mut force, _] = Held::of(&config);
        let past: Vec<f64> = (0..1000_u32).map(|i| f64::from(i).powf(1.3)).collect();
        for ((i, &value), sample) in past.iter().enumerate().zip(1..) {
            let t = Micros(100 * sample);
            // Every 20th sample is a reading, shown 30 samples later.
            let expected = i.checked_sub(30).map_or(0.0, |read| past[read / 20 * 20]);
            assert_eq!(travel.show(t, value), expected, "{i}");
            assert_eq!(force.show(t, value), value);
        }
    }
}
