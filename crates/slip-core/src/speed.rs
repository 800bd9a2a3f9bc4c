//! Moved distance (or a measured speed) and normal force in, slip speed with the mean force of the same
//! stretch of time out.
//!
//! The speed over a window W is v = (x(t) - x(t - W)) / W and the force is averaged over the same
//! window (trapezoids: a rectangle would lead by half a sample, at 1 kHz 10 % of the needed force), so both lag by W/2 and
//! stay consistent with each other in the impulse balance. With a
//! resolution of the travel sensor q the quantisation error of v is at most q / W.

use crate::units::Micros;

/// Samples the window can hold; bounds the window to 128 / rate.
const CAPACITY: usize = 128;

/// Where the slip speed comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct SpeedConfig {
    /// A known constant slip speed (m/s), for recordings made on a test rig; the sensors are then not asked.
    pub fixed_m_s: Option<f32>,
    /// Window of the speed estimate (ms).
    pub window_ms: f32,
}

impl Default for SpeedConfig {
    fn default() -> Self {
        Self { fixed_m_s: None, window_ms: 4.0 }
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
#[derive(Clone, Copy, Debug)]
pub struct SpeedWindow {
    fixed_m_s: Option<f32>,
    len: usize,
    ring: [Entry; CAPACITY],
    next: usize,
    filled: usize,
    impulse_ns: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    t: Micros,
    travel_m: f32,
    force_n: f32,
    impulse_ns: f64,
}

impl SpeedWindow {
    /// A window for samples at `rate_hz`; it holds at least 4 and at most 127 steps.
    #[must_use]
    pub fn new(config: SpeedConfig, rate_hz: f32) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped; the cast saturates"
        )]
        let len = (config.window_ms * 1e-3 * rate_hz).clamp(4.0, 127.0) as usize;
        Self {
            fixed_m_s: config.fixed_m_s,
            len,
            ring: [Entry::default(); CAPACITY],
            next: 0,
            filled: 0,
            impulse_ns: 0.0,
        }
    }

    /// Length of the window (s) for samples at `rate_hz`.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "at most 127")]
    pub fn span_s(&self, rate_hz: f32) -> f32 {
        self.len as f32 / rate_hz
    }

    /// Forgets the window.
    pub fn reset(&mut self) {
        self.next = 0;
        self.filled = 0;
        self.impulse_ns = 0.0;
    }

    /// Takes the next sample's travel (m) and force (N); `None` until the window is full.
    #[inline]
    pub fn push(&mut self, t: Micros, travel_m: f32, force_n: f32) -> Option<SpeedReading> {
        let index = |steps_back: usize| (self.next + CAPACITY - steps_back) % CAPACITY;
        if self.filled > 0 {
            let previous = self.ring[index(1)];
            let mean_n = 0.5 * (f64::from(previous.force_n) + f64::from(force_n));
            self.impulse_ns += mean_n * t.since(previous.t).as_seconds();
        }
        let now = Entry { t, travel_m, force_n, impulse_ns: self.impulse_ns };
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
mod tests {
    use super::{SpeedConfig, SpeedWindow};
    use crate::units::Micros;

    #[test]
    fn follows_an_accelerating_object_with_half_a_window_of_lag() {
        let mut window = SpeedWindow::new(SpeedConfig::default(), 10_000.0);
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

    #[test]
    fn a_low_rate_keeps_four_steps() {
        let mut window = SpeedWindow::new(SpeedConfig::default(), 100.0);
        for i in 0..4_u8 {
            assert_eq!(window.push(Micros(u64::from(i) * 10_000), f32::from(i) * 1e-3, 1.0), None);
        }
        let reading = window.push(Micros(40_000), 4e-3, 1.0).unwrap();
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
