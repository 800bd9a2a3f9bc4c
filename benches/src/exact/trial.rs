//! A pool in, trials with their exact sum out: random ones, and ones steered onto the poles and zeros of the tangent.

use super::{
    BITS, Exact,
    angle::{arc_tan, tan},
    exact,
    pool::{Draw, Known, Width, rounded},
    to_f64,
};
use std::sync::LazyLock;

static HALF_PI: LazyLock<Exact> = LazyLock::new(|| Exact::pi(BITS) / exact(2.0));

/// Which sum is steered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Of the cotangents: the literal reading.
    Cots,
    /// Of the arccotangents.
    ArcCots,
}

/// The irregularities of one trial and their exact sums.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Height and spacing of each.
    pub lengths: Vec<(f64, f64)>,
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
        let mut trial =
            Self { lengths: Vec::with_capacity(n), cots: exact(0.0), arc_cots: exact(0.0) };
        for _ in 0..n {
            trial.push(&pool[draw.below(pool.len())]);
        }
        trial
    }

    fn push(&mut self, known: &Known) {
        self.lengths.push((known.delta, known.spacing));
        self.cots += &known.cot;
        self.arc_cots += &known.arc_cot;
    }

    /// The same with one more irregularity, chosen so that the sum of cotangents, or of arccotangents, comes as close as the
    /// format allows to a multiple of pi/2, or to a place just beside it.
    #[must_use]
    pub fn steered(mut self, target: Target, draw: &mut Draw, width: Width) -> Self {
        let half_pi = HALF_PI.clone();
        let beside = match draw.below(3) {
            0 => exact(0.0),
            1 => exact(draw.sign() * draw.log(1e-26, 1e-14)),
            _ => exact(draw.sign() * draw.log(1e-15, 1e-6)),
        };
        let last = match target {
            Target::Cots => {
                let wanted = draw.log(0.01, 500.0);
                // The last cotangent is j pi/2 + beside - S for the j that makes it about as large as wanted.
                let j = ((exact(wanted) + &self.cots) / &half_pi).round();
                let last = j * &half_pi + beside - &self.cots;
                if to_f64(&last) > 1e-3 { last } else { last + half_pi }
            }
            Target::ArcCots => {
                // The last arccotangent lies within 0 and pi/2.
                let j = (&self.arc_cots / &half_pi).floor() + exact(1.0);
                let last = j * half_pi + beside - &self.arc_cots;
                exact(1.0) / tan(&last)
            }
        };
        let ratio = match target {
            Target::Cots => arc_tan(&(exact(1.0) / &last)),
            Target::ArcCots => last,
        };
        if to_f64(&ratio) > 0.0 {
            self.push(&Known::new(nearest(&ratio, draw, width)));
        }
        self
    }
}

/// The lengths, of some that are tried, whose ratio comes closest to `angle`.
fn nearest(angle: &Exact, draw: &mut Draw, width: Width) -> (f64, f64) {
    let tries = (0..8).map(|_| {
        let (_, spacing) = rounded((1.0, draw.log(20e-6, 2e-3)), width);
        let lengths = rounded((to_f64(&(angle * exact(spacing))), spacing), width);
        let off = to_f64(&((exact(lengths.0) - angle * exact(spacing)) / exact(spacing))).abs();
        (off, lengths)
    });
    tries.min_by(|a, b| a.0.total_cmp(&b.0)).map_or((1.0, 1.0), |(_, lengths)| lengths)
}
