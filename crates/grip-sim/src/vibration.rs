//! Model of an accelerometer in the finger: what it shows at a speed of sliding.
//!
//! Sliding excites the finger with white noise whose size grows with a power of the speed. Two of its modes (300 Hz,
//! quality 5; 900 Hz, quality 6) and a rest below 2 kHz answer, in shares that are drawn for each object; together they
//! have the rms `level * (v / 0.1 m/s)^exponent` times that of the sensor's noise. Pads that only shear excite nothing.

use crate::random::{self, Purpose};
use crate::scene::VibrationConfig;
use core::f64::consts::{PI, TAU};
use rand_chacha::ChaCha8Rng;

/// Frequencies (Hz) and qualities of the two modes.
const MODES: [(f64, f64); 2] = [(300.0, 5.0), (900.0, 6.0)];
/// Corner of the rest (Hz).
const REST_HZ: f64 = 2000.0;
/// Speed (m/s) at which the level is reached.
const SPEED_M_S: f64 = 0.1;

/// A filter with two poles that gives white noise of rms 1 back with rms 1.
#[derive(Clone, Copy, Debug, Default)]
struct TwoPoles {
    back: [f64; 2],
    gain: f64,
    last: [f64; 2],
}

impl TwoPoles {
    /// A mode at `hz` of this quality, for `rate_hz`.
    fn mode(hz: f64, quality: f64, rate_hz: f64) -> Self {
        let r = (-PI * hz / (quality * rate_hz)).exp();
        let (r2, angle) = (r * r, TAU * hz / rate_hz);
        let power = (1.0 + r2) / ((1.0 - r2) * (1.0 + r2 * r2 - 2.0 * r2 * (2.0 * angle).cos()));
        Self { back: [2.0 * r * angle.cos(), -r2], gain: 1.0 / power.sqrt(), last: [0.0; 2] }
    }

    /// What lies below `hz`.
    fn below(hz: f64, rate_hz: f64) -> Self {
        let r = (-TAU * hz / rate_hz).exp();
        Self { back: [r, 0.0], gain: (1.0 - r * r).sqrt(), last: [0.0; 2] }
    }

    fn step(&mut self, white: f64) -> f64 {
        let [first, second] = self.back;
        let [last, before] = self.last;
        let now = first * last + second * before + self.gain * white;
        self.last = [now, last];
        now
    }
}

/// The vibrating finger.
#[derive(Clone, Debug)]
pub(crate) struct Vibration {
    level: f64,
    exponent: f64,
    noise_m_s2: f64,
    shares: [f64; 3],
    filters: [TwoPoles; 3],
    rng: ChaCha8Rng,
}

impl Vibration {
    /// A finger at rest, sampled at `rate_hz`.
    pub(crate) fn new(config: &VibrationConfig, rate_hz: f64, seed: u64) -> Self {
        let mut rng = random::stream(seed, Purpose::Vibration);
        let (level, exponent) = (config.level.sample(&mut rng), config.exponent.sample(&mut rng));
        let mut shares = [(0.3, 1.0), (0.3, 1.0), (0.1, 0.4)]
            .map(|(low, high)| random::uniform(&mut rng, low, high));
        let all = shares.iter().map(|share| share * share).sum::<f64>().sqrt();
        shares.iter_mut().for_each(|share| *share /= all);
        let [first, second] = MODES.map(|(hz, quality)| TwoPoles::mode(hz, quality, rate_hz));
        let filters = [first, second, TwoPoles::below(REST_HZ, rate_hz)];
        Self { level, exponent, noise_m_s2: config.noise_m_s2, shares, filters, rng }
    }

    /// The next reading (m/s^2) at a speed of sliding (m/s), its noise included.
    pub(crate) fn next_m_s2(&mut self, slides_m_s: f64) -> f64 {
        let speed = slides_m_s.abs() / SPEED_M_S;
        let size = self.level * speed.powf(self.exponent);
        let mut reading = random::normal(&mut self.rng);
        for (filter, share) in self.filters.iter_mut().zip(self.shares) {
            reading += share * filter.step(size * random::normal(&mut self.rng));
        }
        self.noise_m_s2 * reading
    }
}

#[cfg(test)]
mod tests {
    use super::Vibration;
    use crate::scene::{Draw, VibrationConfig};

    fn rms(speed: f64, rate_hz: f64) -> f64 {
        let (level, exponent) = (Draw::Fixed(20.0), Draw::Fixed(1.0));
        let config = VibrationConfig { level, exponent, noise_m_s2: 0.05 };
        let mut vibration = Vibration::new(&config, rate_hz, 3);
        let n = 200_000;
        let squares: f64 = (0..n).map(|_| vibration.next_m_s2(speed).powi(2)).sum();
        (squares / f64::from(n)).sqrt() / config.noise_m_s2
    }

    #[test]
    fn its_size_is_that_of_the_noise_at_rest_and_the_level_at_a_tenth_of_a_metre_a_second() {
        for rate_hz in [5000.0, 10_000.0, 20_000.0] {
            assert!((rms(0.0, rate_hz) - 1.0).abs() < 0.02);
            assert!((rms(0.1, rate_hz) / 401.0_f64.sqrt() - 1.0).abs() < 0.1, "{rate_hz}");
            assert!((rms(-0.05, rate_hz) / 101.0_f64.sqrt() - 1.0).abs() < 0.1, "{rate_hz}");
        }
    }
}
