//! A needed force and a time in which the load comes in; how the object then moves, and how likely the readings are, out.

use super::{CREEP_M_S, SURFACE_SPREAD, TURN_LN, TURN_SPREAD};
use crate::estimate::G_M_S2;

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

/// What the turns of the stylus say of the surface, the same for all candidates.
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

/// One needed force with one time in which the load comes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Candidate {
    need_n: f32,
    /// Speed (m/s) and distance (m) at the end of the last block, and the share of the load that is there.
    pub(super) speed_m_s: f32,
    moved_m: f32,
    pub(super) load: f32,
    /// From the first movement to the alarm (s).
    pub(super) before_s: f32,
    /// Weighted sums over the blocks: squares of the distance, logarithms of the variances, squares of the readings over those.
    pub(super) squares: f32,
    pub(super) logs: f32,
    pub(super) misfit: f32,
    /// Mean speed in the last block (m/s).
    mean_m_s: f32,
    /// Place (m) and speed (m/s) at the extreme that is looked for, and place of the last turn (m).
    extreme_m: f32,
    extreme_m_s: f32,
    turn_m: f32,
    /// Sums over the turns: logarithm of the distance, its square, and of the change from distances to times.
    ln: f32,
    ln2: f32,
    jacobian: f32,
    /// Its probability; while a block is weighed, the logarithm.
    pub(super) p: f32,
}

impl Candidate {
    /// An object that needs `need_n` and has moved by `alarm_m` since it began to, a moment ago, under `force_n` (N).
    pub(super) fn start(need_n: f32, force_n: f32, ramp_s: f32, alarm_m: f32) -> Self {
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
        Self {
            need_n,
            speed_m_s,
            moved_m,
            load,
            before_s,
            extreme_m: moved_m,
            extreme_m_s: speed_m_s,
            turn_m: moved_m,
            ..Self::default()
        }
    }

    /// Goes on for `d_s` under `force_n` (N).
    pub(super) fn go(&mut self, force_n: f32, ramp_s: f32, d_s: f32) {
        let before_m_s = self.speed_m_s;
        let a = G_M_S2 * (self.load - force_n / self.need_n);
        self.speed_m_s = (before_m_s + a * d_s).max(0.0);
        let mean_m_s = 0.5 * (before_m_s + self.speed_m_s);
        self.moved_m += mean_m_s * d_s;
        self.mean_m_s = mean_m_s.max(CREEP_M_S);
        if ramp_s > 0.0 {
            self.load = (self.load + d_s / ramp_s).min(1.0);
        }
    }

    /// Distance of the last block, which lasted `d_s` (m).
    pub(super) fn way_m(&self, d_s: f32) -> f32 {
        self.mean_m_s * d_s
    }

    /// The stylus is further than at the extreme so far, `within_s` after the end of the last block.
    pub(super) fn extreme(&mut self, within_s: f32) {
        self.extreme_m = self.moved_m + self.speed_m_s * within_s;
        self.extreme_m_s = self.speed_m_s;
    }

    /// The stylus has turned at the extreme; the first turn of a slip begins a distance and ends none.
    pub(super) fn turn(&mut self, ends: bool) {
        if ends {
            let ln = libm::logf((self.extreme_m - self.turn_m).max(LEAST_M));
            self.ln += ln;
            self.ln2 += ln * ln;
            self.jacobian += libm::logf(self.extreme_m_s.max(CREEP_M_S)) - ln;
        }
        self.turn_m = self.extreme_m;
    }

    /// Logarithm of the likelihood of the turns so far.
    pub(super) fn turning(&self, surface: &Surface) -> f32 {
        let each = 1.0 / (TURN_SPREAD * TURN_SPREAD);
        let prior = 1.0 / (SURFACE_SPREAD * SURFACE_SPREAD);
        let sum = each * self.ln + prior * TURN_LN;
        let mean = sum / surface.precision;
        let squares = each * self.ln2 + prior * TURN_LN * TURN_LN - sum * mean;
        let open = libm::logf((self.moved_m - self.turn_m).max(LEAST_M));
        let late = ((open - mean - LATE_TURN) * surface.sharpness).max(0.0);
        self.jacobian - 0.5 * (squares + late * late)
    }
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

#[cfg(test)]
mod tests {
    use super::{super::ALARM_M, Candidate, balance};
    use crate::estimate::G_M_S2;

    /// A block as long as the whole slip is as good as many short ones, by the plain law of motion in `f64`.
    #[test]
    fn it_moves_as_the_law_states() {
        for ramp_s in [0.0_f32, 0.02, 0.06] {
            let mut candidate = Candidate::start(10.0, 1.2, ramp_s, ALARM_M);
            let (mut v, mut x) = (f64::from(candidate.speed_m_s), f64::from(candidate.moved_m));
            let mut load = f64::from(candidate.load);
            for block in 0..200_u16 {
                let force = 1.2 + 0.08 * f32::from(block);
                candidate.go(force, ramp_s, 3e-4);
                let before = v;
                v = (v + f64::from(G_M_S2) * (load - f64::from(force) / 10.0) * 3e-4).max(0.0);
                x += 0.5 * (v + before) * 3e-4;
                if ramp_s > 0.0 {
                    load = (load + 3e-4 / f64::from(ramp_s)).min(1.0);
                }
            }
            assert!((f64::from(candidate.moved_m) - x).abs() < 1e-4 * x, "{candidate:?} {x}");
            assert_eq!(candidate.speed_m_s > 0.0, v > 0.0, "{candidate:?}");
        }
    }

    /// The start is where the object is a moment after it began to move, by small steps in `f64`.
    #[test]
    fn it_starts_where_the_law_states() {
        for (need_n, ramp_s) in [(2.0_f32, 0.0_f32), (40.0, 0.0), (2.0, 0.06), (40.0, 0.02)] {
            let start = Candidate::start(need_n, 1.2, ramp_s, ALARM_M);
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
