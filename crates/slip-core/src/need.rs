//! Readings of one stylus and the grip force during a slip in; the force that the object needs, as a distribution, out.
//!
//! One stylus cannot tell how fast an object slides, since the surface is not known. It tells the *course* of the speed: the heights change by more
//! from block to block, and peaks and valleys follow each other faster, the faster it slides. And the course follows from the force that is needed:
//! an object that needs `N` and is pressed with `F` has the acceleration `g (L - F/N)`, where `L` is the share of its load that is there yet.
//! So each of [`CANDIDATES`] pairs of a needed force and a time in which the load comes predicts a speed for each block, and is as likely as that
//! explains the readings:
//!
//! - *Amplitude*: the difference of two block means has the variance `k^2 (v d)^2` and the noise on top, with one slope `k` of the surface for all
//!   blocks, within [`SLOPE`].
//! - *Turns*: between two turns of the stylus lies a distance that is log-normal with one median for all, within some hundred micrometres.
//!
//! After the stop the balance of impulse holds whatever the surface: the needed force is the mean force of the slip.
//!
//! Everything forgets with [`FORGET_S`]. Cost: 72 candidates a block of 0.3 ms, each with three logarithms and one exponential.

use crate::estimate::G_M_S2;

/// Needed forces that are tried, each larger than the one before by [`STEP`] in the logarithm, from the force at the alarm on.
const FORCES: usize = 24;
const STEP: f32 = 0.21;
/// Times in which the load may come (s), with their probabilities.
const RAMPS: [(f32, f32); 3] = [(0.0, 0.5), (0.02, 0.25), (0.06, 0.25)];
/// Pairs of both.
pub const CANDIDATES: usize = FORCES * RAMPS.len();
/// A needed force is as probable as its ratio to the force at the alarm to this power.
const PRIOR: f32 = -0.3;

/// Length of a block (s).
const BLOCK_S: f32 = 3e-4;
/// Block means that are kept, to see whether the stylus stands.
const KEPT: usize = 40;
/// Distance that the object has moved when the alarm comes (m), and how much later that is known (s).
const ALARM_M: f32 = 6e-6;
const ALARM_S: f32 = 4.5e-4;
/// Longest time from the first movement to the alarm (s).
const BEFORE_ALARM_S: f32 = 0.015;
/// Smallest acceleration of an object that slips, over that of gravity.
const LEAST_A: f32 = 0.03;
/// Speed below which a block says as much as at this one (m/s).
const CREEP_M_S: f32 = 5e-4;
/// Bounds of the slope of a surface (rms).
const SLOPE: [f32; 2] = [0.005, 0.3];
/// Distance in which the heights of a surface change (m): blocks that are closer say the same.
const CHANGES_M: f32 = 1e-4;
/// Time constant of all sums (s).
const FORGET_S: f32 = 0.08;
/// Spread of the logarithm of the distance between turns on one surface, and of its median over surfaces; the logarithm of the latter's median of 100 um (m).
const TURN_SPREAD: f32 = 0.45;
const SURFACE_SPREAD: f32 = 0.8;
const TURN_LN: f32 = -9.210_34;
/// A turn that is later than its distance by this (in the logarithm) speaks against the candidate.
const LATE_TURN: f32 = 0.35;
/// How far ahead the needed force is told (s).
const AHEAD_S: f32 = 4e-3;
/// The object stands where the block means stay within this many deviations of their noise ...
const STILL: f32 = 8.5;
/// ... for so many blocks, and for so many where peaks are hardly above the noise.
const STILL_BLOCKS: usize = 20;
const STILL_BLOCKS_FAINT: usize = 38;
/// It moves where they go further than this many deviations within so many blocks.
const MOVING: f32 = 7.5;
const MOVING_BLOCKS: usize = 8;
/// A mean swing below this many deviations of the noise is faint.
const FAINT: f32 = 25.0;
/// After a stop for this long (s) ...
const AGAIN_S: f32 = 0.3;
/// ... only a swing of this share of the mean one is a slip again, and pads that swing are none.
const AGAIN: f32 = 0.5;
/// The range of the swing since the stop is forgotten in this time (s).
const AGAIN_TAU_S: f32 = 0.06;
/// First answer to a slip, and to one that follows another, over the force at the alarm.
const FIRST: f32 = 1.4;
const FIRST_AGAIN: f32 = 1.15;
/// Squared differences of readings over those of the noise: above these the stylus moves fast, vibrates, and is not still.
const FAST: f32 = 6.7;
const VIBRATES: f32 = 3.3;
const NOT_STILL: f32 = 2.3;
const ALARMS: f32 = 4.4;

/// What the slip says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Felt {
    /// Whether the object moves; a slip that has not ended may have stopped.
    pub moves: bool,
    /// Force when it began to move (N).
    pub from_n: f32,
    /// First answer over that force.
    pub first: f32,
    /// Time since it began to move (s).
    pub since_s: f32,
    /// 10 % quantile of the force that is needed within the next milliseconds (N).
    pub low_n: f32,
    /// Its median (N).
    pub median_n: f32,
    /// Whether the stylus vibrates now.
    pub vibrates: bool,
    /// Whether the stylus vibrates more than any candidate explains.
    pub unexplained: bool,
    /// Needed force by the balance of impulse (N), once the object has stopped.
    pub held_n: Option<f32>,
}

/// One needed force with one time in which the load comes.
#[derive(Clone, Copy, Debug, Default)]
struct Candidate {
    need_n: f32,
    speed_m_s: f32,
    moved_m: f32,
    load: f32,
    /// From the first movement to the alarm (s).
    before_s: f32,
    /// Weighted squares of the distance of a block, logarithms of the variances, squares over variances.
    squares: f32,
    logs: f32,
    misfit: f32,
    /// Place and speed at the extreme that is looked for; place of the last turn.
    extreme_m: f32,
    extreme_m_s: f32,
    turn_m: f32,
    /// Sums of the logarithm of the distance between turns, of its square, and of the change of variables.
    ln: f32,
    ln2: f32,
    jacobian: f32,
    /// Probability.
    p: f32,
}

/// A stylus that goes up and down.
#[derive(Clone, Copy, Debug, Default)]
struct Swings {
    /// 1 up, -1 down, 0 not known yet.
    direction: i8,
    high: f32,
    low: f32,
    last: f32,
    begun: bool,
    first_seen: bool,
    mean: f32,
    turns: f32,
}

/// The distribution over [`CANDIDATES`].
#[derive(Clone, Copy, Debug)]
pub struct Need {
    candidates: [Candidate; CANDIDATES],
    /// White noise of the readings (rms, m), time of a sample (s) and samples of a block.
    sigma: f32,
    dt_s: f32,
    samples: u16,
    /// The block that is filled.
    filled: u16,
    sum_m: f32,
    sum_n: f32,
    differences: f32,
    last_m: Option<f32>,
    mean_m: Option<f32>,
    fast: f32,
    /// Means of two blocks each and the impulse at their end, newest at `at`.
    means: [f32; KEPT],
    impulses: [f32; KEPT],
    at: usize,
    kept: usize,
    impulse: f32,
    weighted: f32,
    power: f32,
    weight: f32,
    speed_m_s: f32,
    swings: Swings,
    /// Mean swing of the slip before the last stop, and since when it stands (s).
    swing_before: f32,
    rested_s: f32,
    rest_low: f32,
    rest_high: f32,
    moves: bool,
    waits: bool,
    from_n: f32,
    first: f32,
    since_s: f32,
    felt: Option<Felt>,
}

impl Default for Need {
    fn default() -> Self {
        Self {
            candidates: [Candidate::default(); CANDIDATES],
            sigma: 0.0,
            dt_s: 0.0,
            samples: 1,
            filled: 0,
            sum_m: 0.0,
            sum_n: 0.0,
            differences: 0.0,
            last_m: None,
            mean_m: None,
            fast: 0.0,
            means: [0.0; KEPT],
            impulses: [0.0; KEPT],
            at: 0,
            kept: 0,
            impulse: 0.0,
            weighted: 0.0,
            power: 0.0,
            weight: 0.0,
            speed_m_s: 0.02,
            swings: Swings::default(),
            swing_before: 0.0,
            rested_s: f32::INFINITY,
            rest_low: 0.0,
            rest_high: 0.0,
            moves: false,
            waits: false,
            from_n: 0.0,
            first: FIRST,
            since_s: 0.0,
            felt: None,
        }
    }
}

impl Need {
    /// An alarm `since_s` after the last sample of the slip before; `sigma` is the white noise of the readings (rms, m).
    pub fn begin(&mut self, sigma: f32, since_s: f32, force_n: f32, dt_s: f32) {
        let (swing_before, rested_s) = (self.swing_before, self.rested_s + since_s);
        let again = rested_s < AGAIN_S && swing_before > 0.0;
        *self = Self { sigma, dt_s, swing_before, rested_s, ..Self::default() };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to some hundred")]
        let samples = libm::roundf(BLOCK_S / dt_s.max(1e-6)).clamp(1.0, 300.0) as u16;
        self.samples = samples;
        if again {
            self.waits = true;
            self.felt = Some(Felt {
                moves: false,
                from_n: force_n,
                first: FIRST_AGAIN,
                since_s: 0.0,
                low_n: force_n,
                median_n: force_n,
                vibrates: false,
                unexplained: false,
                held_n: None,
            });
        } else {
            self.start(force_n, FIRST);
        }
    }

    /// What the slip says so far; `None` before there is anything to say.
    #[must_use]
    pub fn felt(&self) -> Option<Felt> {
        self.felt
    }

    /// Takes the next reading (m) and the force of a finger (N).
    pub fn push(&mut self, x_m: f32, force_n: f32) {
        let last = self.last_m.replace(x_m).unwrap_or(x_m);
        self.sum_m += x_m;
        self.sum_n += force_n;
        self.differences += (x_m - last) * (x_m - last);
        self.filled += 1;
        if self.moves {
            self.swing(x_m);
        }
        if self.filled < self.samples {
            return;
        }
        let n = f32::from(self.filled);
        let (mean_m, mean_n) = (self.sum_m / n, self.sum_n / n);
        let fast = n * self.differences;
        (self.filled, self.sum_m, self.sum_n, self.differences) = (0, 0.0, 0.0, 0.0);
        self.block(mean_m, mean_n, fast);
    }

    fn block_s(&self) -> f32 {
        self.dt_s * f32::from(self.samples)
    }

    /// Square of the deviation of a squared difference of readings, as `fast` has it.
    fn noise_fast(&self) -> f32 {
        let n = f32::from(self.samples);
        2.0 * n * n * self.sigma * self.sigma
    }

    /// Deviation of the mean of two blocks.
    fn noise_mean(&self) -> f32 {
        self.sigma / libm::sqrtf(2.0 * f32::from(self.samples))
    }

    /// The object begins to move under `force_n` (N).
    fn start(&mut self, force_n: f32, first: f32) {
        let force_n = force_n.max(1e-3);
        (self.moves, self.waits, self.from_n, self.first) = (true, false, force_n, first);
        (self.since_s, self.impulse, self.weighted, self.power, self.weight) = (0.0, 0.0, 0.0, 0.0, 0.0);
        self.speed_m_s = 0.02;
        self.kept = 0;
        self.swings = Swings::default();
        let places = self.candidates.chunks_exact_mut(FORCES).zip(RAMPS);
        for (forces, (ramp_s, _)) in places {
            for (j, place) in forces.iter_mut().enumerate() {
                #[expect(clippy::cast_precision_loss, reason = "a small number")]
                let need_n = force_n * libm::expf(STEP * (j as f32 + 0.5));
                *place = Candidate::start(need_n, force_n, ramp_s);
            }
        }
        self.felt = Some(Felt {
            moves: true,
            from_n: force_n,
            first,
            since_s: 0.0,
            low_n: force_n,
            median_n: force_n,
            vibrates: true,
            unexplained: false,
            held_n: None,
        });
    }

    /// Peaks and valleys, reading by reading; a new extreme or turn is taken into all candidates.
    fn swing(&mut self, x: f32) {
        let least = (5.0 * self.sigma).max(0.25 * self.swings.mean);
        let within_s = f32::from(self.filled) * self.dt_s;
        let swings = &mut self.swings;
        if !swings.begun {
            (swings.begun, swings.high, swings.low, swings.last) = (true, x, x, x);
        }
        let mut extreme = false;
        if swings.direction >= 0 && x > swings.high {
            (swings.high, extreme) = (x, true);
        }
        if swings.direction <= 0 && x < swings.low {
            (swings.low, extreme) = (x, true);
        }
        if swings.direction == 0 {
            if x - swings.low > least {
                (swings.direction, swings.high, extreme) = (1, x, true);
            } else if swings.high - x > least {
                (swings.direction, swings.low, extreme) = (-1, x, true);
            }
        } else {
            let turned = if swings.direction > 0 { swings.high - x } else { x - swings.low };
            if turned > least {
                let top = if swings.direction > 0 { swings.high } else { swings.low };
                let size = (top - swings.last).abs();
                let counts = swings.first_seen;
                if counts {
                    swings.mean = if swings.mean == 0.0 { size } else { swings.mean + 0.3 * (size - swings.mean) };
                    swings.turns += 1.0;
                }
                (swings.last, swings.first_seen) = (top, true);
                swings.direction = -swings.direction;
                if swings.direction > 0 {
                    swings.high = x;
                } else {
                    swings.low = x;
                }
                for candidate in &mut self.candidates {
                    candidate.turn(counts);
                }
                extreme = true;
            }
        }
        if extreme {
            for candidate in &mut self.candidates {
                candidate.extreme_m = candidate.moved_m + candidate.speed_m_s * within_s;
                candidate.extreme_m_s = candidate.speed_m_s;
            }
        }
    }

    fn block(&mut self, mean_m: f32, force_n: f32, fast: f32) {
        let block_s = self.block_s();
        let before_m = self.mean_m.replace(mean_m).unwrap_or(mean_m);
        let middle_m = 0.5 * (mean_m + before_m);
        self.fast = 0.8 * self.fast + 0.2 * fast;
        self.impulse += force_n * block_s;
        self.at = (self.at + 1) % KEPT;
        if let (Some(mean), Some(impulse)) = (self.means.get_mut(self.at), self.impulses.get_mut(self.at)) {
            (*mean, *impulse) = (middle_m, self.impulse);
        }
        self.kept = (self.kept + 1).min(KEPT);
        if self.moves {
            self.since_s += block_s;
            self.weigh(mean_m - before_m, fast, force_n);
            if self.stands() {
                self.stop(force_n, middle_m);
            }
        } else {
            self.rest(middle_m, force_n);
        }
    }

    /// Whether it moves again after a stop.
    fn rest(&mut self, middle_m: f32, force_n: f32) {
        self.rested_s += self.block_s();
        if self.kept <= 2 {
            (self.rest_low, self.rest_high) = (middle_m, middle_m);
        }
        let back = self.block_s() / AGAIN_TAU_S * (self.rest_high - self.rest_low);
        self.rest_low = (self.rest_low + back).min(middle_m);
        self.rest_high = (self.rest_high - back).max(middle_m);
        let again = if self.rested_s < AGAIN_S { AGAIN * self.swing_before } else { 0.0 };
        let swings = self.rest_high - self.rest_low > (9.0 * self.noise_mean()).max(again);
        if swings || self.fast > ALARMS * self.noise_fast() {
            let faint = self.swing_before < FAINT * self.noise_mean();
            self.start(force_n, if faint { FIRST } else { FIRST_AGAIN });
        }
    }

    /// Whether the stylus stands.
    fn stands(&self) -> bool {
        let faint = self.swings.mean > 0.0 && self.swings.mean < FAINT * self.noise_mean();
        let blocks = if faint { STILL_BLOCKS_FAINT } else { STILL_BLOCKS };
        if self.since_s < 0.0035 + 0.5 * STILL_BLOCKS as f32 * self.block_s() || self.kept < blocks {
            return false;
        }
        if self.fast > NOT_STILL * self.noise_fast() {
            return false;
        }
        self.range_m(blocks) < STILL * self.noise_mean()
    }

    /// Range of the last block means (m).
    fn range_m(&self, blocks: usize) -> f32 {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for back in 0..blocks.min(self.kept) {
            let mean = self.means.get((self.at + KEPT - back) % KEPT).copied().unwrap_or(0.0);
            (low, high) = (low.min(mean), high.max(mean));
        }
        high - low
    }

    /// The object has stopped: the needed force by the balance of impulse.
    fn stop(&mut self, force_n: f32, middle_m: f32) {
        let faint = self.swings.mean > 0.0 && self.swings.mean < FAINT * self.noise_mean();
        let back = if faint { 35 } else { STILL_BLOCKS - 3 };
        let back = back.min(self.kept - 1);
        let impulse = self.impulses.get((self.at + KEPT - back) % KEPT).copied().unwrap_or(self.impulse);
        let lasted_s = (self.since_s - back as f32 * self.block_s()).max(1e-3);
        let (mut ln, mut all) = (0.0, 0.0);
        for (forces, (ramp_s, _)) in self.candidates.chunks_exact(FORCES).zip(RAMPS) {
            let p: f32 = forces.iter().map(|candidate| candidate.p).sum();
            if p < 1e-3 {
                continue;
            }
            let before_s: f32 = forces.iter().map(|candidate| candidate.p * candidate.before_s).sum();
            let before_s = before_s / p;
            let need_n = balance(impulse + self.from_n * before_s, lasted_s + before_s, self.from_n, ramp_s);
            ln += p * libm::logf(need_n);
            all += p;
        }
        let held_n = if all > 0.0 { libm::expf(ln / all) } else { force_n };
        let held_n = held_n.max(self.from_n);
        let range = self.swings.high - self.swings.low;
        self.swing_before = if self.swings.mean > 0.0 { self.swings.mean } else { 0.5 * range };
        (self.moves, self.rested_s) = (false, 0.0);
        (self.rest_low, self.rest_high) = (middle_m, middle_m);
        if let Some(felt) = &mut self.felt {
            (felt.moves, felt.held_n, felt.since_s) = (false, Some(held_n), self.since_s);
        }
    }

    /// One block of a slip: `difference_m` of the block means, `fast` by the squares of the differences of readings, and the mean force (N).
    fn weigh(&mut self, difference_m: f32, fast: f32, force_n: f32) {
        let d = self.block_s();
        let n2 = 2.0 * self.sigma * self.sigma / f32::from(self.samples);
        let noise_fast = self.noise_fast();
        // Means over a block blur what is fast.
        let square = if self.fast > FAST * noise_fast {
            (fast - noise_fast).max(0.0) + n2
        } else {
            difference_m * difference_m
        };
        let w = (self.speed_m_s * d / CHANGES_M).clamp(0.03, 1.0);
        let keep = libm::expf(-d / FORGET_S);
        self.power = self.power * keep + w * (square - n2);
        self.weight = self.weight * keep + w;
        let [least, most] = [SLOPE[0] * SLOPE[0], SLOPE[1] * SLOPE[1]];
        let prior = 0.25 * SLOPE[0] * SLOPE[1];
        let surface = Surface {
            precision: self.swings.turns / (TURN_SPREAD * TURN_SPREAD) + 1.0 / (SURFACE_SPREAD * SURFACE_SPREAD),
        };
        let late = 1.0 / libm::sqrtf(TURN_SPREAD * TURN_SPREAD + 1.0 / surface.precision);
        let mut best = f32::NEG_INFINITY;
        for (forces, (ramp_s, ramp_p)) in self.candidates.chunks_exact_mut(FORCES).zip(RAMPS) {
            let ramp_ln = libm::logf(ramp_p);
            for (j, candidate) in forces.iter_mut().enumerate() {
                let v = candidate.go(force_n, ramp_s, d);
                let m = v * v * d * d;
                candidate.squares = candidate.squares * keep + w * m;
                let slope = (self.power + 1e-3 * n2).max(0.05 * n2 * w) / candidate.squares;
                let u = m + n2 / slope;
                candidate.logs = candidate.logs * keep + w * libm::logf(u);
                candidate.misfit = candidate.misfit * keep + w * square / u;
                let k2 = ((candidate.misfit + prior) / (self.weight + 0.25)).clamp(least, most);
                let amplitude = -0.5 * (candidate.logs + self.weight * libm::logf(k2) + candidate.misfit / k2);
                #[expect(clippy::cast_precision_loss, reason = "a small number")]
                let prior_ln = ramp_ln + PRIOR * STEP * (j as f32 + 0.5);
                candidate.p = prior_ln + amplitude + candidate.turning(&surface, late);
                best = best.max(candidate.p);
            }
        }
        self.conclude(best);
    }

    /// From the logarithms of the likelihoods to probabilities and quantiles.
    fn conclude(&mut self, best: f32) {
        const BINS: usize = 64;
        const BIN: f32 = STEP * (FORCES as f32 + 1.0) / BINS as f32;
        let mut bins = [0.0_f32; BINS];
        let (mut all, mut speed) = (0.0, 0.0);
        for candidate in &mut self.candidates {
            candidate.p = libm::expf(candidate.p - best);
            all += candidate.p;
        }
        let from_ln = libm::logf(self.from_n);
        for (forces, (ramp_s, _)) in self.candidates.chunks_exact_mut(FORCES).zip(RAMPS) {
            for (j, candidate) in forces.iter_mut().enumerate() {
                candidate.p /= all;
                speed += candidate.p * candidate.speed_m_s;
                #[expect(clippy::cast_precision_loss, reason = "a small number")]
                let mut ln = STEP * (j as f32 + 0.5);
                if ramp_s > 0.0 && candidate.load < 1.0 && candidate.p > 1e-4 {
                    ln += libm::logf((candidate.load + AHEAD_S / ramp_s).min(1.0));
                }
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
                let bin = (ln / BIN).clamp(0.0, BINS as f32 - 1.0) as usize;
                if let Some(bin) = bins.get_mut(bin) {
                    *bin += candidate.p;
                }
            }
        }
        self.speed_m_s = speed;
        let quantile = |share: f32| {
            let (mut sum, mut ln) = (0.0, 0.0);
            for (i, p) in bins.iter().enumerate() {
                if sum + p >= share {
                    #[expect(clippy::cast_precision_loss, reason = "a small number")]
                    let place = i as f32;
                    ln = BIN * (place + (share - sum) / p);
                    break;
                }
                sum += p;
            }
            libm::expf(from_ln + ln)
        };
        let unexplained = speed < 0.01 && self.fast > VIBRATES * self.noise_fast();
        self.felt = Some(Felt {
            moves: true,
            from_n: self.from_n,
            first: self.first,
            since_s: self.since_s,
            low_n: quantile(0.1),
            median_n: quantile(0.5),
            vibrates: self.range_m(MOVING_BLOCKS) > MOVING * self.noise_mean(),
            unexplained,
            held_n: None,
        });
    }
}

/// What all candidates share of the turns.
struct Surface {
    precision: f32,
}

/// The needed force (N) by the impulse (N s) over a time (s), where the load comes in `ramp_s` and is that of `from_n` (N) at first.
fn balance(impulse: f32, lasted_s: f32, from_n: f32, ramp_s: f32) -> f32 {
    let mut need_n = (impulse / lasted_s).max(from_n);
    if ramp_s > 0.0 {
        for _ in 0..20 {
            let load = (from_n / need_n).min(1.0);
            let comes_s = (1.0 - load) * ramp_s;
            let loaded_s = if lasted_s > comes_s {
                lasted_s - 0.5 * (1.0 - load) * comes_s
            } else {
                load * lasted_s + 0.5 * lasted_s * lasted_s / ramp_s
            };
            need_n = 0.5 * need_n + 0.5 * (impulse / loaded_s.max(1e-6)).max(from_n);
        }
    }
    need_n
}

impl Candidate {
    /// An object that needs `need_n` and has begun to move under `force_n` (N) a moment ago.
    fn start(need_n: f32, force_n: f32, ramp_s: f32) -> Self {
        let a0 = G_M_S2 * (1.0 - force_n / need_n).max(LEAST_A);
        let at_once_s = libm::sqrtf(2.0 * ALARM_M / a0);
        let ramps = ramp_s > 0.0;
        let before_s = if ramps { libm::cbrtf(6.0 * ALARM_M * ramp_s / G_M_S2).max(at_once_s) } else { at_once_s };
        let before_s = before_s.min(BEFORE_ALARM_S) + ALARM_S;
        let (speed_m_s, moved_m, load) = if ramps {
            let rate = G_M_S2 / ramp_s;
            let grows_s = before_s.min(a0 / rate);
            let rest_s = before_s - grows_s;
            (
                0.5 * rate * grows_s * grows_s + a0 * rest_s,
                rate * grows_s * grows_s * grows_s / 6.0
                    + 0.5 * rate * grows_s * grows_s * rest_s
                    + 0.5 * a0 * rest_s * rest_s,
                (force_n / need_n + before_s / ramp_s).min(1.0),
            )
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

    /// Goes on for `d` seconds under `force_n` (N), and what its speed was on the mean (m/s).
    fn go(&mut self, force_n: f32, ramp_s: f32, d: f32) -> f32 {
        let before_m_s = self.speed_m_s;
        self.speed_m_s = (before_m_s + G_M_S2 * (self.load - force_n / self.need_n) * d).max(0.0);
        let mean = 0.5 * (before_m_s + self.speed_m_s);
        self.moved_m += mean * d;
        if ramp_s > 0.0 {
            self.load = (self.load + d / ramp_s).min(1.0);
        }
        mean.max(CREEP_M_S)
    }

    /// The stylus has turned at the extreme.
    fn turn(&mut self, counts: bool) {
        if counts {
            let ln = libm::logf((self.extreme_m - self.turn_m).max(1e-7));
            self.ln += ln;
            self.ln2 += ln * ln;
            self.jacobian += libm::logf(self.extreme_m_s.max(CREEP_M_S)) - ln;
        }
        self.turn_m = self.extreme_m;
    }

    /// Logarithm of the likelihood of the turns so far.
    fn turning(&self, surface: &Surface, late: f32) -> f32 {
        let i = 1.0 / (TURN_SPREAD * TURN_SPREAD);
        let p = 1.0 / (SURFACE_SPREAD * SURFACE_SPREAD);
        let m = TURN_LN;
        let b = i * self.ln + p * m;
        let mean = b / surface.precision;
        let open = libm::logf((self.moved_m - self.turn_m).max(1e-7));
        let missed = ((open - mean - LATE_TURN) * late).max(0.0);
        self.jacobian - 0.5 * (i * self.ln2 + p * m * m - b * mean) - 0.5 * missed * missed
    }
}
