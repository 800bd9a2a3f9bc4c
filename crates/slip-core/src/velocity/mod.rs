//! What the sensors of a slip show in; the slip speed with its uncertainty and where it comes from out.
//!
//! | source | speed | uncertainty (1 sigma) |
//! |---|---|---|
//! | fixed | as configured | `fixed_sigma` of it |
//! | direct | the velocity channel | `direct_sigma_m_s` |
//! | travel | (x(t) - x(t - W)) / W, the mean over the window | sqrt(2 (q^2 / 12 + noise^2)) / W for resolution q |
//! | two styli | spacing / delay, see [`TwoStylusDelay`] | from height and width of the correlation peak, with that of the spacing |
//! | gravity | a t from the first notice on | sqrt((sigma_a t)^2 + (a sigma_t)^2) |
//!
//! Rule: a fixed speed wins; else of the direct one, the travel and the two styli the one with the smallest uncertainty; else,
//! for [`VelocityConfig::gravity_longest_ms`] after the notice, gravity. The gravity model knows neither friction nor force:
//! an object that slips accelerates with anything from 0 to g, so a is g/2 with the deviation of a uniform
//! distribution, g / sqrt(12), unless the configuration knows better. It is therefore shown, and never used for the force.

mod two_stylus;

pub use two_stylus::{Delay, TwoStylusDelay};

use crate::{error::ConfigError, sample::Sample, units::Micros};
pub use slip_msg::SpeedSource;

/// A slip speed and how far it may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Velocity {
    /// Slip speed (m/s).
    pub speed_m_s: f32,
    /// Its standard deviation (m/s).
    pub sigma_m_s: f32,
    /// Where it comes from.
    pub source: SpeedSource,
}

/// What is known of the sensors of speed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct VelocityConfig {
    /// Relative standard deviation of a configured speed.
    pub fixed_sigma: f32,
    /// Standard deviation of the velocity channel (m/s).
    pub direct_sigma_m_s: f32,
    /// Noise of one travel reading beside its resolution (m, rms).
    pub travel_noise_m: f32,
    /// Distance of the second stylus behind the first, along the slip (m).
    pub spacing_m: f32,
    /// Standard deviation of that distance (m).
    pub spacing_sigma_m: f32,
    /// Correlation of the two styli from which their delay is believed.
    pub least_correlation: f32,
    /// Acceleration of an object that slips (m/s^2).
    pub gravity_m_s2: f32,
    /// Its standard deviation (m/s^2).
    pub gravity_sigma_m_s2: f32,
    /// Standard deviation of the time of the onset (ms).
    pub onset_sigma_ms: f32,
    /// How long after the notice the gravity model is believed, the force being unchanged (ms).
    pub gravity_longest_ms: f32,
}

impl Default for VelocityConfig {
    fn default() -> Self {
        Self {
            fixed_sigma: 0.02,
            direct_sigma_m_s: 1e-3,
            travel_noise_m: 3e-7,
            spacing_m: 1e-3,
            spacing_sigma_m: 1e-5,
            least_correlation: 0.7,
            gravity_m_s2: 4.9,
            gravity_sigma_m_s2: 2.83,
            onset_sigma_ms: 5.0,
            gravity_longest_ms: 50.0,
        }
    }
}

impl VelocityConfig {
    /// # Errors
    /// The first value outside its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        ConfigError::within("velocity.fixed_sigma", self.fixed_sigma, 0.0, 1.0)?;
        ConfigError::within("velocity.direct_sigma_m_s", self.direct_sigma_m_s, 0.0, 10.0)?;
        ConfigError::within("velocity.travel_noise_m", self.travel_noise_m, 0.0, 0.01)?;
        ConfigError::within("velocity.spacing_m", self.spacing_m, 1e-5, 0.1)?;
        ConfigError::within("velocity.spacing_sigma_m", self.spacing_sigma_m, 0.0, self.spacing_m)?;
        ConfigError::within("velocity.least_correlation", self.least_correlation, 0.1, 1.0)?;
        ConfigError::within("velocity.gravity_m_s2", self.gravity_m_s2, 0.0, 100.0)?;
        ConfigError::within("velocity.gravity_sigma_m_s2", self.gravity_sigma_m_s2, 0.0, 100.0)?;
        ConfigError::within("velocity.onset_sigma_ms", self.onset_sigma_ms, 0.0, 1000.0)?;
        ConfigError::within("velocity.gravity_longest_ms", self.gravity_longest_ms, 0.0, 10_000.0)
    }

    /// The configured speed.
    #[must_use]
    pub fn fixed(&self, speed_m_s: f32) -> Velocity {
        let sigma_m_s = self.fixed_sigma * speed_m_s;
        Velocity { speed_m_s, sigma_m_s, source: SpeedSource::Fixed }
    }

    /// The reading of a velocity sensor.
    #[must_use]
    pub fn direct(&self, speed_m_s: f32) -> Velocity {
        Velocity { speed_m_s, sigma_m_s: self.direct_sigma_m_s, source: SpeedSource::Direct }
    }

    /// Deviation of one reading of a travel sensor of resolution `resolution_m` (m).
    #[must_use]
    pub fn travel_sigma_m(&self, resolution_m: f32) -> f32 {
        let noise_m = self.travel_noise_m;
        libm::sqrtf(resolution_m * resolution_m / 12.0 + noise_m * noise_m)
    }

    /// A mean speed over `window_s` from a travel sensor of resolution `resolution_m`.
    #[must_use]
    pub fn travel(&self, speed_m_s: f32, window_s: f32, resolution_m: f32) -> Velocity {
        let sigma_m_s = core::f32::consts::SQRT_2 * self.travel_sigma_m(resolution_m) / window_s;
        Velocity { speed_m_s, sigma_m_s, source: SpeedSource::Travel }
    }

    /// The speed that belongs to a delay between the styli.
    #[must_use]
    pub fn two_styli(&self, delay: Delay) -> Velocity {
        let speed_m_s = self.spacing_m / delay.seconds;
        let (late, apart) = (delay.sigma_s / delay.seconds, self.spacing_sigma_m / self.spacing_m);
        let sigma_m_s = speed_m_s * libm::sqrtf(late * late + apart * apart);
        Velocity { speed_m_s, sigma_m_s, source: SpeedSource::TwoStyli }
    }

    /// The gravity model, `since_notice` after the first notice; `None` where the force may have changed.
    #[must_use]
    pub fn gravity(&self, since_notice: Micros) -> Option<Velocity> {
        if since_notice > Micros::from_ms(self.gravity_longest_ms) {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, reason = "some milliseconds")]
        let t = since_notice.as_seconds() as f32;
        let (by_a, by_t) =
            (self.gravity_sigma_m_s2 * t, self.gravity_m_s2 * 1e-3 * self.onset_sigma_ms);
        let sigma_m_s = libm::sqrtf(by_a * by_a + by_t * by_t);
        Some(Velocity { speed_m_s: self.gravity_m_s2 * t, sigma_m_s, source: SpeedSource::Gravity })
    }
}

/// What measured the speed of one sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct Measured {
    /// The configured speed (m/s).
    pub fixed_m_s: Option<f32>,
    /// The velocity channel (m/s).
    pub direct_m_s: Option<f32>,
    /// The mean over the window (m/s), its length (s) and the resolution of the sensor (m).
    pub travel: Option<(f32, f32, f32)>,
}

/// The speed of one slip.
#[derive(Clone, Copy, Debug)]
pub struct VelocityMeter {
    config: VelocityConfig,
    styli: TwoStylusDelay,
    /// Samples from one look at the correlation to the next, about a millisecond.
    every: u32,
    left: u32,
    latest: Option<Velocity>,
}

impl VelocityMeter {
    /// A meter for samples at `rate_hz`.
    ///
    /// # Errors
    /// Where a value of the configuration is outside its range.
    pub fn new(config: VelocityConfig, rate_hz: f32) -> Result<Self, ConfigError> {
        config.check()?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped; the cast saturates"
        )]
        let every = (1e-3 * rate_hz).clamp(1.0, 1e6) as u32;
        let styli = TwoStylusDelay::new(rate_hz, config.least_correlation);
        Ok(Self { config, styli, every, left: every, latest: None })
    }

    /// Begins with the next sample.
    pub fn begin(&mut self) {
        self.styli.reset();
        self.left = self.every;
        self.latest = None;
    }

    /// Takes the next sample of the slip.
    #[inline]
    pub fn push(&mut self, sample: &Sample) {
        let Some(second) = sample.second_stylus else { return };
        self.styli.push(sample.stylus, second);
        self.left -= 1;
        if self.left == 0 {
            self.left = self.every;
            self.latest = self.styli.delay().map(|delay| self.config.two_styli(delay));
        }
    }

    /// The speed of the two styli alone, at most a millisecond old.
    #[must_use]
    #[inline]
    pub fn two_styli(&self) -> Option<Velocity> {
        self.latest
    }

    /// The speed by the rule of this module; `since_notice` is the time since the slip was noticed.
    #[must_use]
    pub fn velocity(&self, measured: Measured, since_notice: Micros) -> Option<Velocity> {
        let config = &self.config;
        if let Some(fixed_m_s) = measured.fixed_m_s {
            return Some(config.fixed(fixed_m_s));
        }
        let direct = measured.direct_m_s.map(|v| config.direct(v));
        let travel = measured.travel.map(|(v, window_s, q)| config.travel(v, window_s, q));
        let candidates = [direct, travel, self.two_styli()];
        let best = candidates
            .into_iter()
            .flatten()
            .filter(|v| v.speed_m_s.is_finite())
            .min_by(|a, b| a.sigma_m_s.total_cmp(&b.sigma_m_s));
        best.or_else(|| config.gravity(since_notice))
    }
}

#[cfg(test)]
mod tests;
