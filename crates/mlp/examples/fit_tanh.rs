//! Nothing in, the coefficients of `mlp::tanh::rational` out: `cargo run --release -p mlp --example fit_tanh [SECONDS]`.
//!
//! 1. In double precision, `tanh(x / 2) / (x / 2)` is approximated by `P(x^2) / Q(x^2)` with degrees 2 and 3, so that the
//!    largest relative error over `1 / cosh x`, which is that of the final tanh, is least: linear least squares, each
//!    point weighted by its error before (Lawson), until the largest errors are equal.
//! 2. P and Q are multiplied by a common random factor from 1 to 2 and rounded to single precision; single units in the
//!    last place are moved as long as the largest error over a sample falls, with and without fused multiply-add. Points
//!    that prove bad for a good candidate join the sample.
//!
//! The search is random but seeded; it ends by time, so a faster machine may find a better set.
#![expect(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a search that ends by the clock and prints"
)]
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "rounding is the task"
)]

use core::time::Duration;
use std::time::Instant;

/// Where the argument saturates.
const END: f64 = 9.0;
/// Coefficients: three of P, then four of Q.
const COUNT: usize = 7;
type Coefficients = [f32; COUNT];

/// Least squares by Householder reflections.
#[expect(clippy::needless_range_loop, reason = "rows and columns as in the books")]
fn least_squares(mut rows: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let (m, n) = (rows.len(), rows[0].len());
    for j in 0..n {
        let norm = rows[j..].iter().map(|row| row[j] * row[j]).sum::<f64>().sqrt();
        let alpha = if rows[j][j] > 0.0 { -norm } else { norm };
        let mut v: Vec<f64> = rows[j..].iter().map(|row| row[j]).collect();
        v[0] -= alpha;
        let square: f64 = v.iter().map(|x| x * x).sum();
        for k in j..n {
            let d = 2.0 / square * (j..m).map(|i| v[i - j] * rows[i][k]).sum::<f64>();
            (j..m).for_each(|i| rows[i][k] -= d * v[i - j]);
        }
        let d = 2.0 / square * (j..m).map(|i| v[i - j] * right[i]).sum::<f64>();
        (j..m).for_each(|i| right[i] -= d * v[i - j]);
    }
    let mut x = vec![0.0; n];
    for j in (0..n).rev() {
        let known: f64 = (j + 1..n).map(|k| rows[j][k] * x[k]).sum();
        x[j] = (right[j] - known) / rows[j][j];
    }
    x
}

/// P and Q with Q(0) = 1 and the largest weighted error.
fn minimax() -> ([f64; COUNT], f64) {
    let points = 1500;
    let angle = |i: usize| core::f64::consts::PI * (i as f64 + 0.5) / points as f64;
    let xs: Vec<f64> = (0..points).map(|i| END * 0.5 * (1.0 - angle(i).cos())).collect();
    let f: Vec<f64> = xs.iter().map(|x| (x / 2.0).tanh() / x * 2.0).collect();
    let (mut weights, mut q) = (vec![1.0_f64; points], vec![1.0_f64; points]);
    let (mut best, mut least) = ([0.0; COUNT], f64::MAX);
    for _ in 0..600 {
        let (mut rows, mut right) = (Vec::new(), Vec::new());
        for i in 0..points {
            let s = (xs[i] / END).powi(2);
            let g = weights[i].sqrt() / (xs[i].cosh() * f[i] * q[i]);
            let powers = [1.0, s, s * s, s, s * s, s * s * s];
            rows.push(
                (0..6).map(|k| if k < 3 { powers[k] * g } else { -f[i] * powers[k] * g }).collect(),
            );
            right.push(f[i] * g);
        }
        let c = least_squares(rows, right);
        let mut errors = vec![0.0_f64; points];
        for i in 0..points {
            let s = (xs[i] / END).powi(2);
            q[i] = ((c[5] * s + c[4]) * s + c[3]) * s + 1.0;
            errors[i] = (((c[2] * s + c[1]) * s + c[0]) / (q[i] * f[i]) - 1.0).abs() / xs[i].cosh();
        }
        let worst = errors.iter().copied().fold(0.0, f64::max);
        if worst < least {
            let e = END * END;
            least = worst;
            best = [
                c[0],
                c[1] / e,
                c[2] / e.powi(2),
                1.0,
                c[3] / e,
                c[4] / e.powi(2),
                c[5] / e.powi(3),
            ];
        }
        let mean = weights.iter().zip(&errors).map(|(w, e)| w * e).sum::<f64>() / points as f64;
        weights.iter_mut().zip(&errors).for_each(|(w, e)| *w *= (e / mean).max(1e-3));
        let total = weights.iter().sum::<f64>() / points as f64;
        weights.iter_mut().for_each(|w| *w /= total);
    }
    (best, least)
}

/// An argument, its rounded tanh, what rounding took from it, and the reciprocal of its last place.
#[derive(Clone, Copy)]
struct Point {
    x: f32,
    rounded: f32,
    rest: f32,
    per_ulp: f32,
}

fn point(x: f32) -> Point {
    let reference = f64::from(x).tanh();
    let rounded = reference as f32;
    let per_ulp = 1.0 / (f32::from_bits(rounded.to_bits() + 1) - rounded);
    let rest = ((f64::from(rounded) - reference) * f64::from(per_ulp)) as f32;
    Point { x, rounded, rest, per_ulp }
}

/// `a b + c`; fused through double precision, which rounds twice only in one case of 2^29.
fn multiply_add<const FUSED: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FUSED { (f64::from(a) * f64::from(b) + f64::from(c)) as f32 } else { a * b + c }
}

fn error<const FUSED: bool>(c: &Coefficients, point: &Point) -> f32 {
    let f = multiply_add::<FUSED>;
    let x = point.x.min(END as f32);
    let u = x * x;
    let n = x * f(f(c[2], u, c[1]), u, c[0]);
    let q = f(f(f(c[6], u, c[5]), u, c[4]), u, c[3]);
    let y = ((n * (q + q)) / f(n, n, q * q)).min(1.0);
    ((y - point.rounded) * point.per_ulp + point.rest).abs()
}

/// Largest error over the points, at most a little above `enough`.
fn largest(c: &Coefficients, points: &[Point], enough: f32) -> f32 {
    let mut largest = 0.0_f32;
    for some in points.chunks(4096) {
        for point in some {
            largest = largest.max(error::<true>(c, point)).max(error::<false>(c, point));
        }
        if largest > enough {
            break;
        }
    }
    largest
}

struct Random(u64);

impl Random {
    fn next(&mut self, below: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 % below as u64).unwrap_or(0)
    }
}

/// Moves coefficients by single places as long as that helps.
fn polish(mut c: Coefficients, sample: &[Point], random: &mut Random) -> (Coefficients, f32) {
    let (mut least, mut stale) = (largest(&c, sample, f32::MAX), 0);
    while stale < 400 {
        let mut moved = c;
        for _ in 0..=random.next(3) {
            let at = 1 + random.next(COUNT - 1);
            let places = [-3_i32, -2, -1, 1, 2, 3][random.next(6)];
            moved[at] = f32::from_bits(moved[at].to_bits().wrapping_add_signed(places));
        }
        moved[0] = 0.5 * moved[3];
        let error = largest(&moved, sample, least);
        stale += 1;
        if error < least {
            (c, least, stale) = (moved, error, 0);
        }
    }
    (c, least)
}

fn main() {
    let seconds = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(60);
    let (ideal, weighted) = minimax();
    println!("largest error of the unrounded coefficients over 1 / cosh x: {weighted:.2e}");
    let bits = 0.02_f32.to_bits()..9.5_f32.to_bits();
    let all: Vec<Point> = bits.step_by(3).map(f32::from_bits).map(point).collect();
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let mut sample: Vec<Point> = (0..200_000).map(|_| all[random.next(all.len())]).collect();
    let (start, mut least) = (Instant::now(), f32::MAX);
    while start.elapsed() < Duration::from_secs(seconds) {
        let factor = 1.0 + random.next(1 << 30) as f64 / f64::from(1 << 30);
        let mut c: Coefficients =
            core::array::from_fn(|k| (ideal[k] * factor * if k < 3 { 0.5 } else { 1.0 }) as f32);
        c[0] = 0.5 * c[3];
        let (c, on_sample) = polish(c, &sample, &mut random);
        if on_sample >= least {
            continue;
        }
        let on_all = largest(&c, &all, least);
        if on_all < least {
            least = on_all;
            println!("{least:.4} ulp: P {:?} Q {:?}", &c[..3], &c[3..]);
        }
        let bad = |p: &&Point| error::<true>(&c, p).max(error::<false>(&c, p)) > 0.93 * least;
        let mut grown: Vec<Point> = all.iter().filter(bad).take(3000).copied().collect();
        grown.append(&mut sample);
        grown.truncate(400_000);
        sample = grown;
    }
}
