//! True values in, one noisy [`Sample`] out.
//!
//! Styli and forces carry white Gaussian noise. The moved distance stands for an optical displacement
//! sensor or a roller with encoder: Gaussian jitter, then rounding to its resolution (1 um by default).
//! Every channel draws its noise at every sample, switched on or not, so that leaving a channel out does not
//! change the others. What a sensor measures is multiplied by its gain; its noise is not.

use crate::disturbance::Disturbance;
use crate::random::{self, Purpose};
use crate::scene::{ChannelConfig, Gains, MotionConfig, SceneConfig, VibrationConfig};
use crate::vibration::Vibration;
use rand_chacha::ChaCha8Rng;
use slip_core::sample::Sample;
use slip_core::units::Micros;

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
    robot: MotionConfig,
    seed: u64,
    motion: Option<Disturbance>,
    accelerometer: Option<VibrationConfig>,
    vibration: Option<Vibration>,
}

impl Sensors {
    pub(super) fn new(config: &SceneConfig, gains: Gains) -> Self {
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
        let force = gains.force * ideal.force_n + self.force_rms_n * random::normal(&mut self.rng);
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
        Sample {
            second_stylus: second.map(narrow),
            normal_force_n: self.channels.force.then_some(narrow(force)),
            tangential_n: tangential.map(narrow),
            travel_m: self.channels.travel.then_some(narrow(travel)),
            reference: self.channels.reference.then_some(narrow(reference)),
            ..Sample::stylus(ideal.t, narrow(vibration_m_s2.unwrap_or(stylus)))
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a sensor reading has the 24 bits of an f32")]
pub(crate) fn narrow(value: f64) -> f32 {
    value as f32
}
