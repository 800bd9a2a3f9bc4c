//! The slip speed with its uncertainty and its source, from what the sensors of a slip show.
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

use crate::{error::ConfigError, sample::Sample, settings::settings, units::Micros};

mod two_stylus;

pub use two_stylus::{Delay, TwoStylusDelay};

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

settings! {
    /// What is known of the sensors of speed.
    pub struct VelocityConfig as c in "velocity" {
        fixed_sigma: f32 = 0.02, 0.0..=1.0 => "Relative standard deviation of a configured speed.";
        direct_sigma_m_s: f32 = 1e-3, 0.0..=10.0 => "Standard deviation of the velocity channel (m/s).";
        travel_noise_m: f32 = 3e-7, 0.0..=0.01 => "Noise of one travel reading beside its resolution (m, rms).";
        spacing_m: f32 = 1e-3, 1e-5..=0.1 => "Distance of the second stylus behind the first, along the slip (m).";
        spacing_sigma_m: f32 = 1e-5, 0.0..=c.spacing_m => "Standard deviation of that distance (m).";
        least_correlation: f32 = 0.7, 0.1..=1.0 => "Correlation of the two styli from which their delay is believed.";
        gravity_m_s2: f32 = 4.9, 0.0..=100.0 => "Acceleration of an object that slips (m/s^2).";
        gravity_sigma_m_s2: f32 = 2.83, 0.0..=100.0 => "Its standard deviation (m/s^2).";
        onset_sigma_ms: f32 = 5.0, 0.0..=1000.0 => "Standard deviation of the time of the onset (ms).";
        gravity_longest_ms: f32 = 50.0, 0.0..=10_000.0 =>
            "How long after the notice the gravity model is believed, the force being unchanged (ms).";
    }
}

impl VelocityConfig {
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

// Moved distance (or a measured speed) and normal force in, slip speed with the mean force of the same
// stretch of time out.

/// Samples two windows can hold; bounds a window to 63 / rate.
const CAPACITY: usize = 128;
/// Steps of the shortest window: over fewer the trapezoids of a force that rises fast are too coarse.
const LEAST_STEPS: usize = 6;

settings! {
    /// Where the slip speed comes from.
    pub struct SpeedConfig as c in "observation.speed" {
        fixed_m_s: Option<f32> = None, 1e-6..=100.0 =>
            "A known constant slip speed (m/s), for recordings made on a test rig; the sensors are then not asked.";
        window_ms: f32 = 2.0, 0.1..=1000.0 => "Window of the speed estimate (ms).";
    }
}

/// Speed and force over one window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedReading {
    /// Slip speed (m/s).
    pub speed_m_s: f32,
    /// Mean normal force over the window (N).
    pub force_n: f32,
}

/// The window; cost O(1) a sample.
///
/// The speed over a window W is v = (x(t) - x(t - W)) / W and the force is averaged over the same
/// window (trapezoids: a rectangle would lead by half a sample, at 1 kHz 10 % of the needed force), so both lag by W/2 and
/// stay consistent with each other in the impulse balance. With a
/// resolution of the travel sensor q the quantisation error of v is at most q / W.
///
/// Two windows that meet give the acceleration as well ([`SpeedWindow::balance`]): second differences of the travel and of the force
/// integrated twice weight both with the same triangle, so `m a = m g - 2 mu F` holds for the two figures exactly, whatever the force did
/// meanwhile. With a deviation q of one travel reading that of a is `sqrt(6) q / W^2`.
#[derive(Clone, Copy, Debug)]
pub struct SpeedWindow {
    fixed_m_s: Option<f32>,
    len: usize,
    ring: [Entry; CAPACITY],
    next: usize,
    filled: usize,
    impulse_ns: f64,
    carried: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    t: Micros,
    travel_m: f32,
    force_n: f32,
    impulse_ns: f64,
    /// Integral of the impulse (N s^2).
    carried: f64,
}

/// Acceleration and force over two windows that meet, each reading weighted with the same triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Mean acceleration (m/s^2).
    pub acceleration_m_s2: f32,
    /// Mean normal force (N).
    pub force_n: f32,
    /// Mean speeds over the earlier and the later window (m/s).
    pub speeds_m_s: [f32; 2],
    /// Length of both windows together (s).
    pub span_s: f32,
}

impl Balance {
    /// Deviation of the acceleration (m/s^2) where one reading of the travel has the deviation `travel_m` (m).
    #[must_use]
    pub fn acceleration_sigma(&self, travel_m: f32) -> f32 {
        let window_s = 0.5 * self.span_s;
        2.449_49 * travel_m / (window_s * window_s)
    }
}

impl SpeedWindow {
    /// A window for samples at `rate_hz`; it holds at least 6 and at most 63 steps.
    #[must_use]
    pub fn new(config: SpeedConfig, rate_hz: f32) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped; the cast saturates"
        )]
        let len = (config.window_ms * 1e-3 * rate_hz).clamp(LEAST_STEPS as f32, 63.0) as usize;
        Self {
            fixed_m_s: config.fixed_m_s,
            len,
            ring: [Entry::default(); CAPACITY],
            next: 0,
            filled: 0,
            impulse_ns: 0.0,
            carried: 0.0,
        }
    }

    /// Length of the window (s) for samples at `rate_hz`.
    #[must_use]
    pub fn span_s(&self, rate_hz: f32) -> f32 {
        self.len as f32 / rate_hz
    }

    /// Forgets the window.
    pub fn reset(&mut self) {
        self.next = 0;
        self.filled = 0;
        self.impulse_ns = 0.0;
        self.carried = 0.0;
    }

    /// Acceleration and force over the last two windows; where less has been seen since the slip was noticed, over two halves of that, down to
    /// `shortest_s` together (s).
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "differences were taken in f64")]
    pub fn balance(&self, shortest_s: f32) -> Option<Balance> {
        let len = self.len.min(self.filled.saturating_sub(1) / 2);
        if len < LEAST_STEPS {
            return None;
        }
        let back = |steps: usize| self.ring[(self.next + 2 * CAPACITY - 1 - steps) % CAPACITY];
        let (last, middle, first) = (back(0), back(len), back(2 * len));
        let early_s = middle.t.since(first.t).as_seconds();
        let late_s = last.t.since(middle.t).as_seconds();
        let slope = |from: f64, to: f64, span_s: f64| (to - from) / span_s;
        let travel = |entry: &Entry| f64::from(entry.travel_m);
        let speeds = [
            slope(travel(&first), travel(&middle), early_s),
            slope(travel(&middle), travel(&last), late_s),
        ];
        let impulses = [
            slope(first.carried, middle.carried, early_s),
            slope(middle.carried, last.carried, late_s),
        ];
        let half_s = 0.5 * (early_s + late_s);
        let balance = Balance {
            acceleration_m_s2: ((speeds[1] - speeds[0]) / half_s) as f32,
            force_n: ((impulses[1] - impulses[0]) / half_s) as f32,
            speeds_m_s: speeds.map(|speed| speed as f32),
            span_s: (2.0 * half_s) as f32,
        };
        let finite = balance.acceleration_m_s2.is_finite() && balance.force_n.is_finite();
        (finite && balance.span_s >= shortest_s).then_some(balance)
    }

    /// Takes the next sample's travel (m) and force (N); `None` until the window is full.
    #[inline]
    pub fn push(&mut self, t: Micros, travel_m: f32, force_n: f32) -> Option<SpeedReading> {
        let index = |steps_back: usize| (self.next + CAPACITY - steps_back) % CAPACITY;
        if self.filled > 0 {
            let previous = self.ring[index(1)];
            let mean_n = 0.5 * (f64::from(previous.force_n) + f64::from(force_n));
            let dt_s = t.since(previous.t).as_seconds();
            self.carried += dt_s * (self.impulse_ns + 0.5 * mean_n * dt_s);
            self.impulse_ns += mean_n * dt_s;
        }
        let (impulse_ns, carried) = (self.impulse_ns, self.carried);
        let now = Entry { t, travel_m, force_n, impulse_ns, carried };
        let oldest = self.ring[index(self.len)];
        self.ring[self.next % CAPACITY] = now;
        self.next = (self.next + 1) % CAPACITY;
        self.filled = (self.filled + 1).min(CAPACITY);
        if self.filled <= self.len {
            return None;
        }
        let span = t.since(oldest.t).as_seconds();
        let speed = f64::from(travel_m - oldest.travel_m) / span;
        let force = (now.impulse_ns - oldest.impulse_ns) / span;
        #[expect(clippy::cast_possible_truncation, reason = "differences were taken in f64")]
        let reading = SpeedReading { speed_m_s: speed as f32, force_n: force as f32 };
        (reading.speed_m_s.is_finite() && reading.force_n.is_finite()).then_some(reading)
    }

    /// The reading of a gripper whose speed is known or measured: no window is needed.
    #[must_use]
    #[inline]
    pub fn direct(&self, velocity_m_s: Option<f32>, force_n: f32) -> Option<SpeedReading> {
        let speed_m_s = self.fixed_m_s.or(velocity_m_s)?;
        Some(SpeedReading { speed_m_s, force_n })
    }
}

#[cfg(test)]
mod tests;

#[cfg(test)]
#[expect(clippy::cast_possible_truncation, reason = "test signal")]
mod speed_tests {
    use super::{SpeedConfig, SpeedWindow};
    use crate::units::Micros;

    #[test]
    fn follows_an_accelerating_object_with_half_a_window_of_lag() {
        let config = SpeedConfig { window_ms: 4.0, ..SpeedConfig::default() };
        let mut window = SpeedWindow::new(config, 10_000.0);
        for i in 0..1000_u16 {
            let t = f32::from(i) * 1e-4;
            let force = 2.0 + 100.0 * t;
            let reading = window.push(Micros(u64::from(i) * 100), 0.5 * 3.0 * t * t, force);
            assert_eq!(reading.is_some(), i >= 40);
            if let Some(reading) = reading {
                assert!((reading.speed_m_s - 3.0 * (t - 0.002)).abs() < 2e-4);
                assert!((reading.force_n - (2.0 + 100.0 * (t - 0.002))).abs() < 1e-4);
            }
        }
    }

    /// An object that needs 10 N under a force that rises by 400 N/s, read at times that are not even.
    #[test]
    fn second_differences_keep_the_impulse_balance_while_the_force_rises() {
        let mut window = SpeedWindow::new(SpeedConfig::default(), 10_000.0);
        let mut first = None;
        for i in 0..300_u64 {
            let micros = 100 * i + 30 * (i % 3);
            let t = 1e-6 * micros as f64;
            let force = 2.0 + 400.0 * t;
            let travel = 9.81 * (0.5 * 0.8 * t * t - 40.0 * t * t * t / 6.0);
            window.push(Micros(micros), travel as f32, force as f32);
            let Some(balance) = window.balance(3e-3) else { continue };
            first = first.or(Some(i));
            let needed = balance.force_n / (1.0 - balance.acceleration_m_s2 / 9.81);
            assert!((needed / 10.0 - 1.0).abs() < 2e-3, "{needed} N at {t} s: {balance:?}");
        }
        assert_eq!(first, Some(30), "3 ms suffice");
        let sigma = window.balance(0.0).unwrap().acceleration_sigma(4e-7);
        assert!((sigma - 0.245).abs() < 1e-2, "4e-7 m over 2 ms: {sigma}");
    }

    #[test]
    fn a_low_rate_keeps_six_steps() {
        let mut window = SpeedWindow::new(SpeedConfig::default(), 100.0);
        for i in 0..6_u8 {
            assert_eq!(window.push(Micros(u64::from(i) * 10_000), f32::from(i) * 1e-3, 1.0), None);
        }
        let reading = window.push(Micros(60_000), 6e-3, 1.0).unwrap();
        assert!((reading.speed_m_s - 0.1).abs() < 1e-6);
    }

    #[test]
    fn a_known_speed_needs_no_sensor() {
        let config = SpeedConfig { fixed_m_s: Some(0.025), ..SpeedConfig::default() };
        let window = SpeedWindow::new(config, 2200.0);
        assert_eq!(window.direct(None, 1.0).unwrap().speed_m_s, 0.025);
        assert_eq!(SpeedWindow::new(SpeedConfig::default(), 2200.0).direct(None, 1.0), None);
    }
}
