//! Independent streams of random numbers, by seed and purpose.

use rand_chacha::ChaCha8Rng;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

/// What a stream is for: draws of one purpose never shift those of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    Object = 1,
    Surface = 2,
    SensorNoise = 3,
    TrainingRow = 4,
    Motion = 5,
    SecondStylus = 6,
    Load = 7,
    Gain = 8,
    Tangential = 9,
    SensorFault = 10,
    Vibration = 11,
    Texture = 12,
}

/// The generator of `purpose` under `seed`.
pub(crate) fn stream(seed: u64, purpose: Purpose) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(purpose as u64);
    rng
}

/// One draw of N(0, 1).
pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// `median * exp(spread * N(0, 1))`.
pub(crate) fn lognormal(rng: &mut ChaCha8Rng, median: f64, spread: f64) -> f64 {
    median * (spread * normal(rng)).exp()
}

/// Uniform between `low` and `high`; `low` where they are equal.
pub(crate) fn uniform(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    let share: f64 = StandardUniform.sample(rng);
    low + (high - low) * share
}

/// Uniform in the logarithm between two positive bounds.
pub(crate) fn log_uniform(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    uniform(rng, low.ln(), high.ln()).exp()
}

/// `first` or one of `others`, each equally likely (reservoir sampling).
pub(crate) fn pick(rng: &mut ChaCha8Rng, first: f64, others: &[f64]) -> f64 {
    let mut chosen = first;
    for (count, &value) in (2_u32..).zip(others) {
        if uniform(rng, 0.0, f64::from(count)) < 1.0 {
            chosen = value;
        }
    }
    chosen
}
