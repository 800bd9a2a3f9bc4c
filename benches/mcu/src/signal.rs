//! Simulated noisy samples at 10 kHz from force and slip speed: a stylus on asperities of 5.6 um, about 200 um apart.

use slip_core::{Sample, units::Micros};

/// Samples a second (Hz).
pub const RATE_HZ: f32 = 10_000.0;
const PERIOD_US: u64 = 100;
const HEIGHT_M: f32 = 5.6e-6;
const SPACING_M: f32 = 2e-4;

/// The signal and its place on the surface.
#[derive(Debug)]
pub struct Signal {
    next_us: u64,
    travel_m: f32,
    start_m: f32,
    spacing_m: f32,
    height_m: f32,
    random: u32,
}

impl Signal {
    /// From time zero.
    pub fn new() -> Self {
        Self {
            next_us: 0,
            travel_m: 0.0,
            start_m: 0.0,
            spacing_m: SPACING_M,
            height_m: HEIGHT_M,
            random: 1,
        }
    }

    /// The next sample.
    pub fn sample(&mut self, force_n: f32, speed_m_s: f32) -> Sample {
        let t = Micros(self.next_us);
        self.next_us += PERIOD_US;
        self.travel_m += speed_m_s / RATE_HZ;
        while self.travel_m >= self.start_m + self.spacing_m {
            self.start_m += self.spacing_m;
            self.spacing_m = SPACING_M * (1.0 + 0.3 * self.noise());
            self.height_m = HEIGHT_M * (1.0 + 0.3 * self.noise());
        }
        let u = (self.travel_m - self.start_m) / self.spacing_m;
        let hump = 4.0 * u * (1.0 - u);
        let stylus = self.height_m * hump * hump + 1.7e-7 * self.noise();
        Sample {
            normal_force_n: Some(force_n + 9e-3 * self.noise()),
            travel_m: Some(self.travel_m + 5e-7 * self.noise()),
            ..Sample::stylus(t, stylus)
        }
    }

    /// Uniform in -1..1 (xorshift, G. Marsaglia 2003).
    fn noise(&mut self) -> f32 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 17;
        self.random ^= self.random << 5;
        let unit = (self.random >> 8) as f32 / 8_388_608.0;
        unit - 1.0
    }
}
