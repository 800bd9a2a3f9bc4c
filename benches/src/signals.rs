//! Simulated noisy samples of a gripper with stylus, force and travel sensor, from force and slip speed.

use grip_sim::surface::{Surface, mean_spacing};
use rand_chacha::ChaCha8Rng;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use slip_core::{Sample, units::Micros};

/// Samples per second of every signal here (Hz).
pub const RATE_HZ: f32 = 10_000.0;
/// Noise of the stylus (m, rms).
pub const STYLUS_NOISE_M: f64 = 1e-7;

const PERIOD: Micros = Micros(100);
const PERIOD_S: f64 = 1e-4;
const FORCE_NOISE_N: f64 = 5e-3;
const TRAVEL_NOISE_M: f64 = 3e-7;
const TRAVEL_STEP_M: f64 = 1e-6;
const ROUGHNESS_RA_M: f64 = 1.6e-6;
/// The stylus lands here, away from the end of the profile (m).
const LANDING_M: f64 = 1e-3;

/// A stylus on a machined surface of Ra 1.6 um; sensor noise as in the default scene of the simulator.
#[derive(Clone, Debug)]
pub struct Signals {
    noise: ChaCha8Rng,
    surface: Surface,
    next: Micros,
    travel_m: f64,
}

impl Signals {
    /// Signals that start at time zero. The same seed gives the same samples.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self {
            noise: ChaCha8Rng::seed_from_u64(seed),
            surface: Surface::new(ROUGHNESS_RA_M, mean_spacing(ROUGHNESS_RA_M, 0.0), seed),
            next: Micros(0),
            travel_m: 0.0,
        }
    }

    /// The next sample at a normal force of `force_n` (N) and a slip speed of `speed_m_s` (m/s).
    pub fn sample(&mut self, force_n: f64, speed_m_s: f64) -> Sample {
        let t = self.next;
        self.next = t.plus(PERIOD);
        self.travel_m += speed_m_s * PERIOD_S;
        let height_m = self.surface.height(LANDING_M + self.travel_m);
        let travel_m = self.travel_m + self.normal(TRAVEL_NOISE_M);
        Sample {
            normal_force_n: Some(narrow(force_n + self.normal(FORCE_NOISE_N))),
            travel_m: Some(narrow((travel_m / TRAVEL_STEP_M).round() * TRAVEL_STEP_M)),
            ..Sample::stylus(t, narrow(height_m + self.normal(STYLUS_NOISE_M)))
        }
    }

    /// The next `count` samples at one force and speed.
    pub fn stretch(&mut self, count: usize, force_n: f64, speed_m_s: f64) -> Vec<Sample> {
        (0..count).map(|_| self.sample(force_n, speed_m_s)).collect()
    }

    fn normal(&mut self, deviation: f64) -> f64 {
        let deviate: f64 = StandardNormal.sample(&mut self.noise);
        deviation * deviate
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "rounding to the precision of a sample is meant"
)]
fn narrow(value: f64) -> f32 {
    value as f32
}
