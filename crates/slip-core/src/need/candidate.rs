//! Candidates, each a needed force with a time in which the load comes: their likelihood after the readings, distribution and quantiles.

use super::{
    AHEAD_S, CREEP_M_S, FORCES, FORGET_S, Felt, Need, RAMPS, SLOPE_BLOCKS, STEP, SURFACE_SPREAD,
    TURN_LN, TURN_SPREAD,
};
use crate::estimate::G_M_S2;
use core::f32::consts::{FRAC_1_SQRT_2, LN_2, LOG2_E};

/// How much later than it comes the alarm is known (s).
const ALARM_S: f32 = 4.5e-4;
/// Longest time from the first movement to the alarm (s).
const BEFORE_ALARM_S: f32 = 0.015;
/// Smallest acceleration of an object that slips, over that of gravity.
const LEAST_A: f32 = 0.03;
/// A turn that is later than its distance by this (in the logarithm) speaks against the candidate.
const LATE_TURN: f32 = 0.35;
/// Nothing lies closer together than this (m).
const LEAST_M: f32 = 1e-7;

/// What the turns of the stylus show of the surface, the same for all candidates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    /// Of the logarithm of the distance between turns, as a sum of reciprocal variances.
    precision: f32,
    /// Reciprocal deviation of the next distance.
    sharpness: f32,
}

impl Surface {
    /// After so many turns.
    pub(super) fn after(turns: f32) -> Self {
        let precision =
            turns / (TURN_SPREAD * TURN_SPREAD) + 1.0 / (SURFACE_SPREAD * SURFACE_SPREAD);
        let sharpness = 1.0 / libm::sqrtf(TURN_SPREAD * TURN_SPREAD + 1.0 / precision);
        Self { precision, sharpness }
    }
}

/// Where an object is when the alarm comes.
#[derive(Clone, Copy, Debug)]
struct Start {
    speed_m_s: f32,
    moved_m: f32,
    load: f32,
    /// From the first movement to the alarm (s).
    before_s: f32,
}

impl Start {
    /// An object that needs `need_n` and has moved by `alarm_m` since it began to, a moment ago, under `force_n` (N).
    fn of(need_n: f32, force_n: f32, ramp_s: f32, alarm_m: f32) -> Self {
        let a0 = G_M_S2 * (1.0 - force_n / need_n).max(LEAST_A);
        let at_once_s = libm::sqrtf(2.0 * alarm_m / a0);
        let before_s = if ramp_s > 0.0 {
            libm::cbrtf(6.0 * alarm_m * ramp_s / G_M_S2).max(at_once_s)
        } else {
            at_once_s
        };
        let before_s = before_s.min(BEFORE_ALARM_S) + ALARM_S;
        let (speed_m_s, moved_m, load) = if ramp_s > 0.0 {
            // The acceleration grows with the load up to that of the whole.
            let jerk = G_M_S2 / ramp_s;
            let grows_s = before_s.min(a0 / jerk);
            let rest_s = before_s - grows_s;
            let grown_m_s = 0.5 * jerk * grows_s * grows_s;
            let moved_m = grown_m_s * (grows_s / 3.0 + rest_s) + 0.5 * a0 * rest_s * rest_s;
            (grown_m_s + a0 * rest_s, moved_m, (force_n / need_n + before_s / ramp_s).min(1.0))
        } else {
            (a0 * before_s, 0.5 * a0 * before_s * before_s, 1.0)
        };
        Self { speed_m_s, moved_m, load, before_s }
    }
}

/// What a block states to every candidate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// What is left of the sums before, and the weight of the block.
    pub(super) keep: f32,
    pub(super) w: f32,
    /// Power of the reading, with that of the noise.
    pub(super) square: f32,
    /// Power of the noise over that of all readings: the variance of the noise for a square way of 1.
    pub(super) noise: f32,
    /// Sum of the weights, and what is believed of the slope before (blocks, and blocks times its square).
    pub(super) weight: f32,
    pub(super) believed: f32,
    pub(super) prior: f32,
    /// Bounds of the square of the slope.
    pub(super) least2: f32,
    pub(super) most2: f32,
}

type Forces = [f32; FORCES];

/// All needed forces with one time in which the load comes: each field for all of them, so that one instruction takes several.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// Reciprocal needed force (1/N).
    per_n: Forces,
    /// Speed (m/s) and distance (m) at the end of the last block, and the share of the load that is there.
    pub(super) speed_m_s: Forces,
    moved_m: Forces,
    pub(super) load: Forces,
    /// From the first movement to the alarm (s).
    pub(super) before_s: Forces,
    /// Distance of the last block (m).
    pub(super) way_m: Forces,
    /// Weighted sums over the blocks: squares of the distance, logarithms of the variances, squares of the readings over those.
    squares: Forces,
    logs: Forces,
    misfit: Forces,
    /// Place (m) and speed (m/s) at the extreme that is looked for, and place of the last turn (m).
    extreme_m: Forces,
    extreme_m_s: Forces,
    turn_m: Forces,
    /// Sums over the turns: logarithm of the distance over the most probable one, its square, and of the change from distances to times.
    ln: Forces,
    ln2: Forces,
    jacobian: Forces,
    /// Probability; while a block is weighed, the logarithm.
    pub(super) p: Forces,
}

impl Row {
    pub(super) const EMPTY: Self = Self {
        per_n: [0.0; FORCES],
        speed_m_s: [0.0; FORCES],
        moved_m: [0.0; FORCES],
        load: [0.0; FORCES],
        before_s: [0.0; FORCES],
        way_m: [0.0; FORCES],
        squares: [0.0; FORCES],
        logs: [0.0; FORCES],
        misfit: [0.0; FORCES],
        extreme_m: [0.0; FORCES],
        extreme_m_s: [0.0; FORCES],
        turn_m: [0.0; FORCES],
        ln: [0.0; FORCES],
        ln2: [0.0; FORCES],
        jacobian: [0.0; FORCES],
        p: [0.0; FORCES],
    };

    /// Objects that have moved by `alarm_m` since they began to, a moment ago, under `force_n` (N).
    pub(super) fn start(&mut self, force_n: f32, ramp_s: f32, alarm_m: f32) {
        *self = Self::EMPTY;
        let mut need_n = force_n * libm::expf(0.5 * STEP);
        for i in 0..FORCES {
            let start = Start::of(need_n, force_n, ramp_s, alarm_m);
            self.per_n[i] = 1.0 / need_n;
            (self.speed_m_s[i], self.moved_m[i]) = (start.speed_m_s, start.moved_m);
            (self.load[i], self.before_s[i]) = (start.load, start.before_s);
            need_n *= libm::expf(STEP);
        }
        (self.extreme_m, self.extreme_m_s) = (self.moved_m, self.speed_m_s);
        self.turn_m = self.moved_m;
    }

    /// Goes on for `d_s` under `force_n` (N).
    pub(super) fn go(&mut self, force_n: f32, ramp_s: f32, d_s: f32) {
        let comes = if ramp_s > 0.0 { d_s / ramp_s } else { 0.0 };
        for i in 0..FORCES {
            let before_m_s = self.speed_m_s[i];
            let a = G_M_S2 * (self.load[i] - force_n * self.per_n[i]);
            let speed_m_s = at_least(before_m_s + a * d_s, 0.0);
            let mean_m_s = 0.5 * (before_m_s + speed_m_s);
            self.speed_m_s[i] = speed_m_s;
            self.moved_m[i] += mean_m_s * d_s;
            self.way_m[i] = at_least(mean_m_s, CREEP_M_S) * d_s;
            self.load[i] = at_most(self.load[i] + comes, 1.0);
        }
    }

    /// Logarithms of the likelihoods of the blocks so far, of which `block` is the last.
    pub(super) fn weigh(&mut self, block: &Block) {
        let Block { keep, w, square, noise, weight, believed, prior, least2, most2 } = *block;
        let reciprocal = 1.0 / (weight + believed);
        for i in 0..FORCES {
            let way2 = self.way_m[i] * self.way_m[i];
            let squares = self.squares[i] * keep + w * way2;
            let variance = way2 + squares * noise;
            let logs = self.logs[i] * keep + w * ln(variance);
            let misfit = self.misfit[i] * keep + w * square / variance;
            let k2 = at_most(at_least((misfit + prior) * reciprocal, least2), most2);
            (self.squares[i], self.logs[i], self.misfit[i]) = (squares, logs, misfit);
            self.p[i] = -0.5 * (logs + weight * ln(k2) + misfit / k2);
        }
    }

    /// The stylus is further than at the extreme so far, `within_s` after the end of the last block.
    pub(super) fn extreme(&mut self, within_s: f32) {
        for i in 0..FORCES {
            self.extreme_m[i] = self.moved_m[i] + self.speed_m_s[i] * within_s;
        }
        self.extreme_m_s = self.speed_m_s;
    }

    /// The stylus has turned at the extreme; the first turn of a slip begins a distance and ends none.
    pub(super) fn turn(&mut self, ends: bool) {
        if ends {
            for i in 0..FORCES {
                let way_ln = ln(at_least(self.extreme_m[i] - self.turn_m[i], LEAST_M));
                let over = way_ln - TURN_LN;
                self.ln[i] += over;
                self.ln2[i] += over * over;
                self.jacobian[i] += ln(at_least(self.extreme_m_s[i], CREEP_M_S)) - way_ln;
            }
        }
        self.turn_m = self.extreme_m;
    }

    /// Adds the logarithms of the likelihoods of the turns so far to those of the blocks.
    pub(super) fn weigh_turns(&mut self, surface: &Surface) {
        let each = 1.0 / (TURN_SPREAD * TURN_SPREAD);
        let deviation2 = 1.0 / surface.precision;
        for i in 0..FORCES {
            let sum = each * self.ln[i];
            let mean = sum * deviation2;
            let squares = each * self.ln2[i] - sum * mean;
            let open = ln(at_least(self.moved_m[i] - self.turn_m[i], LEAST_M)) - TURN_LN;
            let late = at_least((open - mean - LATE_TURN) * surface.sharpness, 0.0);
            self.p[i] += self.jacobian[i] - 0.5 * (squares + late * late);
        }
    }
}

/// As `f32::max` of numbers, in one instruction for several.
pub(super) fn at_least(x: f32, low: f32) -> f32 {
    if x > low { x } else { low }
}

/// As `f32::min` of numbers, in one instruction for several.
fn at_most(x: f32, high: f32) -> f32 {
    if x < high { x } else { high }
}

/// The needed force `N` (N) by the impulse (N s) over a time (s), where the load comes in `ramp_s` and is that of `from_n` (N) at first: the mean force
/// is `N` times the mean share of the load that is there.
pub(super) fn balance(impulse: f32, lasted_s: f32, from_n: f32, ramp_s: f32) -> f32 {
    let mean_n = (impulse / lasted_s).max(from_n);
    if ramp_s <= 0.0 {
        return mean_n;
    }
    // The whole load is there before the end: `N D - T (N - F)^2 / 2 N = impulse`.
    let a = lasted_s - 0.5 * ramp_s;
    let b = from_n * ramp_s - impulse;
    let whole_n = (libm::sqrtf(b * b + 2.0 * a * ramp_s * from_n * from_n) - b) / (2.0 * a);
    if a > 0.0 && lasted_s > (1.0 - from_n / whole_n) * ramp_s {
        return whole_n.max(from_n);
    }
    // It is not: `F D + N D^2 / 2 T = impulse`.
    (2.0 * ramp_s * (impulse - from_n * lasted_s) / (lasted_s * lasted_s)).max(from_n)
}

// Posterior of the needed force after a block, from the power of the block; its quantiles.

/// The logarithm of a likelihood over the best one from which on it adds nothing to the sums, not even in their last bit; the exponential
/// of less is slow where it is no normal number.
const NEGLIGIBLE: f32 = -80.0;

impl Need {
    /// What a block states whose power is `square` with that of the noise, `noise`, and that weighs `w`: the candidates go on under `force_n` (N).
    pub(super) fn believe(&mut self, square: f32, noise: f32, w: f32, force_n: f32) {
        let d_s = self.block_s;
        let keep = libm::expf(-d_s / FORGET_S);
        self.power = self.power * keep + w * (square - noise);
        self.weight = self.weight * keep + w;
        let [least, most] = self.law.slope;
        let block = Block {
            keep,
            w,
            square,
            noise: noise / self.signal(noise, w),
            weight: self.weight,
            believed: SLOPE_BLOCKS,
            prior: SLOPE_BLOCKS * least * most,
            least2: least * least,
            most2: most * most,
        };
        let surface = Surface::after(self.swings.count());
        let extreme_s = self.extreme_s.take();
        let mut best = f32::NEG_INFINITY;
        for (row, (ramp_s, ramp_ln)) in self.rows.iter_mut().zip(RAMPS) {
            if let Some(extreme_s) = extreme_s {
                row.extreme(extreme_s);
            }
            row.go(force_n, ramp_s, d_s);
            row.weigh(&block);
            if self.law.turns {
                row.weigh_turns(&surface);
            }
            for p in &mut row.p {
                *p += ramp_ln;
                best = at_least(best, *p);
            }
        }
        self.conclude(best);
    }

    /// Weighted squares of the readings without noise, of which some are left where the noise is `noise` and the last block weighs `w`.
    pub(super) fn signal(&self, noise: f32, w: f32) -> f32 {
        (self.power + 1e-3 * noise).max(0.05 * noise * w)
    }

    /// From the logarithms of the likelihoods, of which `best` is the largest, to probabilities and quantiles.
    fn conclude(&mut self, best: f32) {
        const BINS: usize = 64;
        /// Width of a bin in the logarithm of the needed force over that at the alarm.
        const BIN: f32 = STEP * (FORCES as f32 + 1.0) / BINS as f32;
        let mut bins = [0.0_f32; BINS];
        let mut all = 0.0;
        for row in &mut self.rows {
            for p in &mut row.p {
                let ln = *p - best;
                *p = if ln < NEGLIGIBLE { 0.0 } else { exp(ln) };
            }
            all += row.p.iter().sum::<f32>();
        }
        let mut speed_m_s = 0.0;
        for (row, (ramp_s, _)) in self.rows.iter_mut().zip(RAMPS) {
            let mut need_ln = -0.5 * STEP;
            for ((p, speed), load) in row.p.iter_mut().zip(&row.speed_m_s).zip(&row.load) {
                need_ln += STEP;
                if *p <= 0.0 {
                    continue;
                }
                *p /= all;
                speed_m_s += *p * speed;
                let mut now = need_ln;
                if ramp_s > 0.0 && *load < 1.0 {
                    now += ln((load + AHEAD_S / ramp_s).min(1.0));
                }
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "from 0, and beyond the last there is none"
                )]
                let bin = (now / BIN).max(0.0) as usize;
                if let Some(bin) = bins.get_mut(bin.min(BINS - 1)) {
                    *bin += *p;
                }
            }
        }
        self.speed_m_s = speed_m_s;
        let from_n = self.felt.from_n;
        let quantile = |share: f32| {
            let (mut sum, mut ln) = (0.0, 0.0);
            for p in bins {
                if sum + p >= share {
                    ln += BIN * (share - sum) / p;
                    break;
                }
                sum += p;
                ln += BIN;
            }
            from_n * libm::expf(ln)
        };
        self.felt = Felt { low_n: quantile(0.1), median_n: quantile(0.5), ..self.felt };
    }
}

// Logarithm and exponential without a branch or a table, so that a loop over candidates takes several at once. Within 3e-7 of the exact value.

/// The natural logarithm of a normal number above 0. With `x = 2^e (1 + s) / (1 - s)` it is `e ln 2 + 2 artanh s`, and `s` is below 0.172.
#[inline(always)]
pub(super) fn ln(x: f32) -> f32 {
    const MANTISSA: u32 = 0x007f_ffff;
    let low = FRAC_1_SQRT_2.to_bits();
    let over = x.to_bits().wrapping_sub(low);
    #[expect(clippy::cast_possible_wrap, reason = "-127 to 128")]
    let exponent = ((over as i32) >> 23) as f32;
    let m = f32::from_bits((over & MANTISSA).wrapping_add(low));
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let series = 1.0 + s2 * (1.0 / 3.0 + s2 * (1.0 / 5.0 + s2 * (1.0 / 7.0 + s2 * (1.0 / 9.0))));
    exponent * LN_2 + 2.0 * s * series
}

/// The exponential of a number from -80 to 80, by the first terms of its series about the nearest power of two.
#[inline(always)]
pub(super) fn exp(x: f32) -> f32 {
    /// What is added to this is rounded to whole numbers.
    const ROUNDS: f32 = 12_582_912.0;
    /// `ln 2` in two parts, of which the first has few digits.
    const LN_2_HIGH: f32 = 0.693_359_4;
    const LN_2_LOW: f32 = -2.121_944_4e-4;
    let rounded = x * LOG2_E + ROUNDS;
    let whole = rounded - ROUNDS;
    let t = (x - whole * LN_2_HIGH) - whole * LN_2_LOW;
    let series = 1.0 / 24.0 + t * (1.0 / 120.0 + t * (1.0 / 720.0));
    let series = 1.0 + t * (1.0 + t * (0.5 + t * (1.0 / 6.0 + t * series)));
    let power = rounded.to_bits().wrapping_sub(ROUNDS.to_bits()).wrapping_add(127) << 23;
    series * f32::from_bits(power)
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::{
        super::{ALARM_M, CREEP_M_S, RAMPS, STEP},
        Block, FORCES, LATE_TURN, LEAST_M, Row, SURFACE_SPREAD, Start, Surface, TURN_LN,
        TURN_SPREAD, balance,
    };
    use crate::estimate::G_M_S2;
    use std::vec::Vec;

    /// One candidate by plain arithmetic in `f64`, one block after the other, with sums that are made anew for each.
    #[derive(Debug)]
    struct Plain {
        need_n: f64,
        ramp_s: f64,
        v: f64,
        x: f64,
        load: f64,
        /// Distance of each block.
        ways: Vec<f64>,
        extreme: (f64, f64),
        turn_m: f64,
        /// Distance and speed of each turn but for the first one.
        turns: Vec<(f64, f64)>,
    }

    impl Plain {
        fn go(&mut self, force_n: f64, d_s: f64) {
            let before = self.v;
            let a = f64::from(G_M_S2) * (self.load - force_n / self.need_n);
            self.v = (before + a * d_s).max(0.0);
            let mean = 0.5 * (before + self.v);
            self.x += mean * d_s;
            self.ways.push(mean.max(f64::from(CREEP_M_S)) * d_s);
            if self.ramp_s > 0.0 {
                self.load = (self.load + d_s / self.ramp_s).min(1.0);
            }
        }

        fn turn(&mut self, ends: bool) {
            let (extreme_m, extreme_m_s) = self.extreme;
            if ends {
                let distance = (extreme_m - self.turn_m).max(f64::from(LEAST_M));
                self.turns.push((distance, extreme_m_s.max(f64::from(CREEP_M_S))));
            }
            self.turn_m = extreme_m;
        }

        /// Logarithm of the likelihood of `squares` with the weights `w`, of which each block leaves `keep`, and the power of the noise over that of all.
        fn blocks(&self, squares: &[f64], w: f64, keep: f64, noise: &[f64], block: &Block) -> f64 {
            let (mut sum, mut logs, mut misfit, mut weight) = (0.0, 0.0, 0.0, 0.0);
            for ((way, square), noise) in self.ways.iter().zip(squares).zip(noise) {
                sum = sum * keep + w * way * way;
                let variance = way * way + sum * noise;
                logs = logs * keep + w * libm::log(variance);
                misfit = misfit * keep + w * square / variance;
                weight = weight * keep + w;
            }
            let k2 = (misfit + f64::from(block.prior)) / (weight + f64::from(block.believed));
            let k2 = k2.max(f64::from(block.least2)).min(f64::from(block.most2));
            -0.5 * (logs + weight * libm::log(k2) + misfit / k2)
        }

        /// That of the turns: distances are log-normal about a median that is not known, and the last one is open.
        fn turning(&self) -> f64 {
            let each = f64::from(1.0 / (TURN_SPREAD * TURN_SPREAD));
            let prior = f64::from(1.0 / (SURFACE_SPREAD * SURFACE_SPREAD));
            let (mut sum, mut squares) =
                (prior * f64::from(TURN_LN), prior * f64::from(TURN_LN * TURN_LN));
            let (mut precision, mut jacobian) = (prior, 0.0);
            for (distance, speed) in &self.turns {
                let ln = libm::log(*distance);
                (sum, squares, precision) =
                    (sum + each * ln, squares + each * ln * ln, precision + each);
                jacobian += libm::log(*speed) - ln;
            }
            let mean = sum / precision;
            let open = libm::log((self.x - self.turn_m).max(f64::from(LEAST_M)));
            let deviation = libm::sqrt(1.0 / each + 1.0 / precision);
            let late = ((open - mean - f64::from(LATE_TURN)) / deviation).max(0.0);
            jacobian - 0.5 * (squares - sum * mean + late * late)
        }
    }

    /// All candidates at once are as likely as each of them by plain arithmetic, with turns that come late and in time, in a slip that stops and goes on.
    #[test]
    fn a_row_is_as_likely_as_each_of_its_candidates_by_plain_arithmetic() {
        const D_S: f32 = 3e-4;
        let (mut stopped, mut late) = (0, 0);
        for ((ramp_s, _), every) in RAMPS.into_iter().zip([3_u16, 7, 40]) {
            let mut row = Row::EMPTY;
            row.start(1.2, ramp_s, ALARM_M);
            let mut need_n = 1.2 * libm::expf(0.5 * STEP);
            let mut all = Vec::new();
            for _ in 0..FORCES {
                let start = Start::of(need_n, 1.2, ramp_s, ALARM_M);
                let (v, x) = (f64::from(start.speed_m_s), f64::from(start.moved_m));
                let (need, ramp_s, load) =
                    (f64::from(need_n), f64::from(ramp_s), f64::from(start.load));
                let (ways, turns) = (Vec::new(), Vec::new());
                all.push(Plain {
                    need_n: need,
                    ramp_s,
                    v,
                    x,
                    load,
                    ways,
                    extreme: (x, v),
                    turn_m: x,
                    turns,
                });
                need_n *= libm::expf(STEP);
            }
            let (mut turns, mut squares, mut noises, mut weight) =
                (0.0, Vec::new(), Vec::new(), 0.0);
            let (keep, w) = (0.996_f32, 0.3_f32);
            for i in 0..300_u16 {
                let force_n = if i < 150 { 1.2 } else { 9.0 };
                let square = 1e-12 * f32::from(1 + i % 5);
                let noise = 2e-2 / f32::from(1 + i);
                weight = weight * keep + w;
                squares.push(f64::from(square));
                noises.push(f64::from(noise));
                if i % every == 0 {
                    row.extreme(1e-4);
                    row.turn(i > 0);
                    turns += f32::from(u8::from(i > 0));
                    for one in &mut all {
                        one.extreme = (one.x + one.v * 1e-4, one.v);
                        one.turn(i > 0);
                    }
                }
                let block = Block {
                    keep,
                    w,
                    square,
                    noise,
                    weight,
                    believed: 0.25,
                    prior: 3.75e-4,
                    least2: 2.5e-5,
                    most2: 0.09,
                };
                row.go(force_n, ramp_s, D_S);
                row.weigh(&block);
                row.weigh_turns(&Surface::after(turns));
                for ((one, p), speed_m_s) in all.iter_mut().zip(row.p).zip(row.speed_m_s) {
                    one.go(f64::from(force_n), f64::from(D_S));
                    let exact =
                        one.blocks(&squares, f64::from(w), f64::from(keep), &noises, &block)
                            + one.turning();
                    assert!((f64::from(p) - exact).abs() < 0.05, "{ramp_s} {i}: {p} {exact}");
                    assert!((f64::from(speed_m_s) - one.v).abs() < 1e-5 + 1e-4 * one.v, "{one:?}");
                    stopped += u32::from(one.v <= 0.0);
                    late += u32::from(one.x - one.turn_m > 2e-4);
                }
            }
        }
        assert!(stopped > 1000 && late > 1000, "both ways: {stopped} {late}");
    }

    /// The start is where the object is a moment after it began to move, by small steps in `f64`.
    #[test]
    fn it_starts_where_the_law_states() {
        for (need_n, ramp_s) in [(2.0_f32, 0.0_f32), (40.0, 0.0), (2.0, 0.06), (40.0, 0.02)] {
            let start = Start::of(need_n, 1.2, ramp_s, ALARM_M);
            let (mut v, mut x) = (0.0_f64, 0.0_f64);
            let full = 1.0 - f64::from(1.2 / need_n);
            let steps = 20_000;
            let dt = f64::from(start.before_s) / f64::from(steps);
            for i in 0..steps {
                let t = (f64::from(i) + 0.5) * dt;
                let a = if ramp_s > 0.0 { (t / f64::from(ramp_s)).min(full) } else { full };
                x += v * dt;
                v += f64::from(G_M_S2) * a * dt;
            }
            assert!((f64::from(start.speed_m_s) - v).abs() < 2e-3 * v, "{start:?} {v}");
            assert!((f64::from(start.moved_m) - x).abs() < 2e-3 * x, "{start:?} {x}");
        }
    }

    #[test]
    fn the_balance_of_impulse_gives_the_needed_force_back() {
        for ramp_s in [0.0_f64, 0.02, 0.06] {
            let (need, from) = (8.0_f64, 1.2_f64);
            let (mut v, mut t, mut impulse) = (0.0_f64, 0.0_f64, 0.0_f64);
            let dt = 1e-6;
            loop {
                let load = if ramp_s > 0.0 { (from / need + t / ramp_s).min(1.0) } else { 1.0 };
                let force = from + 400.0 * (t - 0.004).max(0.0);
                v += f64::from(G_M_S2) * (load - force / need) * dt;
                impulse += force * dt;
                t += dt;
                if v <= 0.0 && t > 0.005 {
                    break;
                }
            }
            #[expect(clippy::cast_possible_truncation, reason = "a test")]
            let reported = balance(impulse as f32, t as f32, from as f32, ramp_s as f32);
            assert!((reported - 8.0).abs() < 0.05, "{ramp_s}: {reported}");
        }
    }
}

#[cfg(test)]
mod logarithm_tests {
    use super::{exp, ln};

    /// Every 4,099th normal number.
    #[test]
    fn the_logarithm_is_that_of_libm() {
        for bits in (f32::MIN_POSITIVE.to_bits()..=f32::MAX.to_bits()).step_by(4099) {
            let x = f32::from_bits(bits);
            let exact = libm::log(f64::from(x));
            let error = (f64::from(ln(x)) - exact).abs();
            assert!(error <= 3e-7 * exact.abs().max(0.3), "{x}: {} for {exact}", ln(x));
        }
        assert_eq!(ln(1.0).to_bits(), 0.0_f32.to_bits());
    }

    #[test]
    fn the_exponential_is_that_of_libm() {
        for i in -800_000..=800_000_i32 {
            #[expect(clippy::cast_possible_truncation, reason = "a test")]
            let x = (f64::from(i) * 1e-4) as f32;
            let exact = libm::exp(f64::from(x));
            assert!((f64::from(exp(x)) - exact).abs() <= 3e-7 * exact, "{x}: {} {exact}", exp(x));
        }
    }
}
