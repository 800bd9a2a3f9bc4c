//! Irregularities with the exact cotangent of each: drawn once, combined into many trials.

use super::{Exact, arc_cot, cot};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng as _, SeedableRng as _},
};
use rayon::prelude::*;

/// Seeded draws.
#[derive(Clone, Debug)]
pub struct Draw(ChaCha8Rng);

impl Draw {
    /// The stream of `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Evenly from 0 to 1.
    #[expect(clippy::cast_precision_loss, reason = "53 digits")]
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Evenly on a logarithmic scale.
    pub fn log(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// One of 0..count.
    #[expect(clippy::cast_possible_truncation, reason = "below count")]
    pub fn below(&mut self, count: usize) -> usize {
        (self.0.next_u64() % count.max(1) as u64) as usize
    }

    /// -1 or 1.
    pub fn sign(&mut self) -> f64 {
        if self.0.next_u64() & 1 == 0 { -1.0 } else { 1.0 }
    }
}

/// What kind of irregularities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// r log-uniform from 0.002 to 0.5, s from 20 um to 2 mm: machined surfaces.
    Machined,
    /// r from 1e-9 to 1e3, beside multiples of pi/2, at the seams of the evaluators, lengths down to subnormal and up to
    /// the largest numbers.
    Wide,
}

/// The width of the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// Every `f64`.
    Double,
    /// Numbers an `f32` holds exactly.
    Single,
}

/// One irregularity with its exact terms.
#[derive(Clone, Debug)]
pub struct Known {
    /// Height.
    pub delta: f64,
    /// Spacing.
    pub spacing: f64,
    /// cot(delta/s).
    pub cot: Exact,
    /// arccot(delta/s).
    pub arc_cot: Exact,
}

impl Known {
    /// The exact terms of an irregularity.
    #[must_use]
    pub fn new(lengths: (f64, f64)) -> Self {
        let (delta, spacing) = lengths;
        Self { delta, spacing, cot: cot(delta, spacing), arc_cot: arc_cot(delta, spacing) }
    }
}

/// `count` irregularities of a kind.
#[must_use]
pub fn pool(kind: Kind, width: Width, count: usize, seed: u64) -> Vec<Known> {
    let mut draw = Draw::new(seed);
    let lengths: Vec<(f64, f64)> = core::iter::repeat_with(|| match kind {
        Kind::Machined => machined(&mut draw),
        Kind::Wide => wide(&mut draw, width),
    })
    .map(|lengths| rounded(lengths, width))
    .filter(|(delta, spacing)| {
        *delta > 0.0 && *spacing > 0.0 && delta.is_finite() && spacing.is_finite()
    })
    .take(count)
    .collect();
    lengths.into_par_iter().map(Known::new).collect()
}

/// Height and spacing of a machined surface.
pub fn machined(draw: &mut Draw) -> (f64, f64) {
    let spacing = draw.log(20e-6, 2e-3);
    (spacing * draw.log(0.002, 0.5), spacing)
}

/// The numbers as the width can hold them.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "that is the rounding asked for")]
pub fn rounded(lengths: (f64, f64), width: Width) -> (f64, f64) {
    let (delta, spacing) = lengths;
    match width {
        Width::Double => (delta, spacing),
        Width::Single => (f64::from(delta as f32), f64::from(spacing as f32)),
    }
}

fn wide(draw: &mut Draw, width: Width) -> (f64, f64) {
    let spacing = draw.log(20e-6, 2e-3);
    let turns = draw.log(1.0, 600.0).floor();
    let near = 1.0 + draw.sign() * draw.log(1e-17, 1e-2);
    let r = match draw.below(10) {
        0..3 => draw.log(1e-9, 1e3),
        3 => draw.log(1e-24, 1e24),
        4 => draw.log(1e-3, 1.0),
        5 => turns * core::f64::consts::PI * near,
        6 => (turns - 0.5) * core::f64::consts::PI * near,
        7 => [0.6, core::f64::consts::FRAC_PI_4, 1.0][draw.below(3)] * near,
        8 => draw.below(64) as f64 / 64.0 + 1.0 / 64.0,
        _ => draw.log(1e-4, 2.0),
    };
    let (delta, spacing) = (spacing * r, spacing);
    if draw.below(8) > 0 {
        return (delta, spacing);
    }
    let most = if width == Width::Single { 36.0 } else { 300.0 };
    let scale = 10_f64.powf(draw.sign() * draw.unit() * most);
    (delta * scale, spacing * scale)
}
