//! Simulated samples of a held object, moving robot and slips at will, repeatable by seed.
//!
//! Stylus: height of the surface under it, the robot's own motion ([`grip_sim::disturbance`]) and 0.1 um of noise. A slip is
//! 1 to 4 jumps of 1 to 6 um along the surface within 30 ms, then motion with a constant acceleration of 1 to 8 m/s^2.

use grip_sim::{
    disturbance::Disturbance,
    surface::{Surface, mean_spacing},
};
use rand_chacha::ChaCha8Rng;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use slip_core::{Sample, units::Micros};

const STYLUS_NOISE_M: f64 = 1e-7;
const HELD_N: f32 = 3.0;
/// Time before gross slip in which the jumps come (s).
pub(super) const INCIPIENT_S: f64 = 0.03;
/// A jump is over after about this (s).
const JUMP_S: f64 = 3e-4;

/// The robot around the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotConfig {
    /// Samples per second.
    pub rate_hz: f64,
    /// Size of the motion; 1 is a robot arm at full motion, on for half of the time.
    pub level: f64,
    /// Taps a second.
    pub taps_per_s: f64,
    /// Whether there is a motion reference.
    pub reference: bool,
}

impl Default for RobotConfig {
    fn default() -> Self {
        Self { rate_hz: 10_000.0, level: 1.0, taps_per_s: 0.2, reference: true }
    }
}

/// What goes on at the stylus.
#[derive(Clone, Debug)]
pub struct Hand {
    config: RobotConfig,
    rng: ChaCha8Rng,
    motion: Disturbance,
    surface: Surface,
    ra_um: f64,
    index: u64,
    seed: u64,
    slip: Option<Slip>,
    at_m: f64,
    /// Keeps the stylus where it is when the object under it is another one.
    offset_m: f64,
    slips: u64,
}

#[derive(Clone, Debug)]
struct Slip {
    elapsed_s: f64,
    jumps: Vec<(f64, f64)>,
    acceleration_m_s2: f64,
    start_m: f64,
}

impl Hand {
    /// A hand with seed `seed`; objects have a roughness of `ra_um` (um).
    #[must_use]
    pub fn new(config: RobotConfig, ra_um: f64, seed: u64) -> Self {
        let ra = ra_um * 1e-6;
        Self {
            config,
            rng: ChaCha8Rng::seed_from_u64(seed ^ 0x5eed),
            motion: Disturbance::new(config.level, config.taps_per_s, config.rate_hz, seed),
            surface: Surface::new(ra, mean_spacing(ra, 0.0), seed),
            ra_um,
            index: 0,
            seed,
            slip: None,
            at_m: 1e-3,
            offset_m: 0.0,
            slips: 0,
        }
    }

    /// Samples per second.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        self.config.rate_hz
    }

    /// How strongly the robot moves now.
    #[must_use]
    pub fn envelope(&self) -> f64 {
        self.motion.envelope()
    }

    /// Height of the object under the stylus (m), without noise and motion.
    pub fn height_m(&mut self) -> f64 {
        self.offset_m + self.surface.height(self.at_m)
    }

    /// One draw of the uniform distribution over 0 to 1.
    pub fn uniform(&mut self) -> f64 {
        StandardUniform.sample(&mut self.rng)
    }

    /// Begins a slip of a new object; gross slip starts 30 ms from now.
    pub fn begin_slip(&mut self) {
        self.slips += 1;
        let ra = self.ra_um * 1e-6;
        let deviate: f64 = StandardNormal.sample(&mut self.rng);
        let seed = self.seed.wrapping_mul(1000).wrapping_add(self.slips);
        let before = self.offset_m + self.surface.height(self.at_m);
        self.surface = Surface::new(ra, mean_spacing(ra, deviate), seed);
        self.at_m = 1e-3 * (1.0 + self.uniform());
        self.offset_m = before - self.surface.height(self.at_m);
        let count = 1.0 + (4.0 * self.uniform()).floor();
        let mut jumps = Vec::new();
        while (jumps.len() as f64) < count {
            jumps.push((INCIPIENT_S * self.uniform(), 1e-6 * (1.0 + 5.0 * self.uniform())));
        }
        self.slip = Some(Slip {
            elapsed_s: 0.0,
            jumps,
            acceleration_m_s2: 1.0 + 7.0 * self.uniform(),
            start_m: self.at_m,
        });
    }

    /// The object stops where it is.
    pub fn end_slip(&mut self) {
        self.slip = None;
    }

    /// The next sample.
    pub fn sample(&mut self) -> Sample {
        self.index += 1;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a time")]
        let t = Micros((self.index as f64 / self.config.rate_hz * 1e6).round() as u64);
        if let Some(slip) = &mut self.slip {
            slip.elapsed_s += 1.0 / self.config.rate_hz;
            self.at_m = slip.position_m();
        }
        let height = self.height_m();
        let motion = self.motion.next_sample();
        let noise: f64 = StandardNormal.sample(&mut self.rng);
        Sample {
            normal_force_n: Some(HELD_N),
            reference: self.config.reference.then_some(motion.reference_m as f32),
            ..Sample::stylus(t, (height + motion.stylus_m + STYLUS_NOISE_M * noise) as f32)
        }
    }
}

impl Slip {
    fn position_m(&self) -> f64 {
        let t = self.elapsed_s;
        let jumped: f64 = self
            .jumps
            .iter()
            .filter(|(at, _)| t > *at)
            .map(|(at, size)| size * (1.0 - (-(t - at) / JUMP_S).exp()))
            .sum();
        let gross = (t - INCIPIENT_S).max(0.0);
        self.start_m + jumped + 0.5 * self.acceleration_m_s2 * gross * gross
    }
}
