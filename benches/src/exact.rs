//! E_sc and its sums to 67 digits, from lengths of irregularities: the reference of `tests/esc.rs` and of the program `accuracy`.
//!
//! Everything goes through `dashu-float` and shares no formula with the evaluators it judges: cot is cos/sin of the ratio itself.

use dashu_float::{FBig, round::mode::HalfEven};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};
use rayon::prelude::*;

/// A number of [`BITS`] binary digits.
pub type Exact = FBig<HalfEven, 2>;
/// Height delta and spacing s of an irregularity, m.
pub type Lengths = (f64, f64);

/// 67 decimal digits.
pub const BITS: usize = 224;

/// `value` itself.
///
/// # Panics
/// For a number that is not finite.
#[must_use]
#[expect(clippy::expect_used, reason = "finite numbers are drawn only")]
pub fn exact(value: f64) -> Exact {
    Exact::try_from(value).expect("a finite number").with_precision(BITS).value()
}

/// The nearest `f64`.
#[must_use]
pub fn to_f64(value: &Exact) -> f64 {
    value.to_f64().value()
}

/// delta/s.
#[must_use]
pub fn ratio(lengths: Lengths) -> Exact {
    exact(lengths.0) / exact(lengths.1)
}

/// |got - wanted| / |wanted|; infinite where `got` is no finite number.
#[must_use]
pub fn relative_error(got: f64, wanted: &Exact) -> f64 {
    if !got.is_finite() {
        return f64::INFINITY;
    }
    to_f64(&((exact(got) - wanted) / wanted)).abs()
}

/// The sum of a term of each irregularity.
pub fn sum(lengths: &[Lengths], term: impl Fn(Lengths) -> Exact) -> Exact {
    lengths.iter().fold(exact(0.0), |sum, lengths| sum + term(*lengths))
}

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
        (self.0.next_u64() % count as u64) as usize
    }

    /// -1 or 1.
    pub fn sign(&mut self) -> f64 {
        if self.below(2) == 0 { -1.0 } else { 1.0 }
    }

    /// Ratio log-uniform from 0.002 to 0.5, spacing from 20 um to 2 mm.
    pub fn machined(&mut self) -> Lengths {
        let spacing = self.log(20e-6, 2e-3);
        (spacing * self.log(0.002, 0.5), spacing)
    }

    /// Ratios from 1e-24 to 1e24, beside multiples of pi/2, at the seams of the evaluators; lengths down to subnormal and up to the
    /// largest numbers, at most 10^`most`.
    pub fn wide(&mut self, most: f64) -> Lengths {
        let spacing = self.log(20e-6, 2e-3);
        let turns = self.log(1.0, 600.0).floor();
        let near = 1.0 + self.sign() * self.log(1e-17, 1e-2);
        let r = match self.below(10) {
            0..3 => self.log(1e-9, 1e3),
            3 => self.log(1e-24, 1e24),
            4 => self.log(1e-3, 1.0),
            5 => turns * core::f64::consts::PI * near,
            6 => (turns - 0.5) * core::f64::consts::PI * near,
            7 => [0.6, core::f64::consts::FRAC_PI_4, 1.0][self.below(3)] * near,
            8 => (self.below(64) + 1) as f64 / 64.0,
            _ => self.log(1e-4, 2.0),
        };
        let many = 10_f64.powf(self.sign() * self.unit() * most);
        let scale = if self.below(8) > 0 { 1.0 } else { many };
        (spacing * r * scale, spacing * scale)
    }
}

/// An irregularity with its exact terms.
#[derive(Clone, Debug)]
pub struct Known {
    lengths: Lengths,
    /// cot(delta/s).
    cot: Exact,
    /// The angle below pi/2 whose cotangent is delta/s.
    arc_cot: Exact,
}

impl Known {
    /// The exact terms of an irregularity.
    #[must_use]
    pub fn new(lengths: Lengths) -> Self {
        let (sin, cos) = ratio(lengths).sin_cos();
        let arc_cot = (exact(lengths.1) / exact(lengths.0)).atan();
        Self { lengths, cot: cos / sin, arc_cot }
    }
}

/// The lengths as an `f32` holds them, where `single`.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "that is the rounding asked for")]
pub fn narrowed(lengths: Lengths, single: bool) -> Lengths {
    let narrow = |x: f64| if single { f64::from(x as f32) } else { x };
    (narrow(lengths.0), narrow(lengths.1))
}

/// `count` irregularities, machined or `wide`, in `f32` where `single`.
#[must_use]
pub fn pool(wide: bool, single: bool, count: usize, seed: u64) -> Vec<Known> {
    let mut draw = Draw::new(seed);
    let most = if single { 36.0 } else { 300.0 };
    let drawn = || if wide { draw.wide(most) } else { draw.machined() };
    let lengths: Vec<Lengths> = core::iter::repeat_with(drawn)
        .map(|lengths| narrowed(lengths, single))
        .filter(|(delta, spacing)| [*delta, *spacing].iter().all(|x| *x > 0.0 && x.is_finite()))
        .take(count)
        .collect();
    lengths.into_par_iter().map(Known::new).collect()
}

/// The irregularities of one trial and their exact sums.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Height and spacing of each.
    pub lengths: Vec<Lengths>,
    /// Sum of cotangents.
    pub cots: Exact,
    /// Sum of arccotangents.
    pub arc_cots: Exact,
}

impl Trial {
    /// `n` irregularities of the pool.
    ///
    /// # Panics
    /// For an empty pool.
    #[must_use]
    pub fn random(pool: &[Known], n: usize, draw: &mut Draw) -> Self {
        let mut trial = Self { lengths: Vec::new(), cots: exact(0.0), arc_cots: exact(0.0) };
        (0..n).for_each(|_| trial.push(&pool[draw.below(pool.len())]));
        trial
    }

    /// One irregularity more.
    pub fn push(&mut self, known: &Known) {
        self.lengths.push(known.lengths);
        self.cots += &known.cot;
        self.arc_cots += &known.arc_cot;
    }
}

#[cfg(test)]
mod tests {
    use super::{BITS, Exact, exact, to_f64};

    /// Machin's formula for pi, and tan(a + b) far beyond one turn: no function is checked against itself.
    #[test]
    fn tangents_and_arctangents_have_the_digits_that_are_stated() {
        let [one, four] = [1.0, 4.0].map(exact);
        let machin = &four * (&one / exact(5.0)).atan() - (&one / exact(239.0)).atan();
        assert!(to_f64(&(four * machin - Exact::pi(BITS))).abs() < 1e-65);
        for (a, b) in [(0.7, 0.3), (1.5, 2000.25), (1e-9, 512.0), (40_000.5, 3.0)] {
            let [a, b] = [a, b].map(exact);
            let ((sin, cos), tan, sum) = (a.sin_cos(), b.tan(), (&a + &b).tan());
            let wanted = (&sin + &cos * &tan) / (cos - sin * tan);
            assert!(to_f64(&(sum / wanted - &one)).abs() < 1e-55, "{a} + {b}");
        }
    }
}
