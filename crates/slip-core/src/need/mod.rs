//! Distribution of the force that the object needs, from readings of one stylus and the grip force during a slip.
//!
//! One stylus cannot show how fast an object slides, since the surface is not known. It shows the *course* of the speed: the faster the object, the
//! more the heights change from block to block, and the faster peaks and valleys follow each other. And the course follows from the needed
//! force: an object that needs `N` and is pressed with `F` has the acceleration `g (L - F/N)`, where `L` is the share of its load that is there.
//! Each of [`CANDIDATES`] pairs of a needed force and a time in which the load comes predicts a speed for each block of 0.3 ms, and is as likely as
//! that explains the readings:
//!
//! - *Amplitude*: the difference of two block means has the variance `k^2 (v d)^2`, and that of the noise on top, with one slope `k` of the surface
//!   for all blocks, between 0.005 and 0.3. Without these bounds "stopped, and infinitely rough" explains everything.
//! - *Turns*: the distance between two turns of the stylus is log-normal with one median for the whole surface.
//!
//! After the stop the balance of impulse holds whatever the surface: the needed force is the mean force of the slip.
//!
//! An accelerometer in the finger shows the course by its power alone (`vibration`).
//!
//! Sums forget within 80 ms. A block costs three logarithms and one exponential a candidate.

mod candidate;
mod readings;

use crate::{
    sample::Signal,
    turns::{Turn, Turns},
};
use core::f32::consts::LN_2;

use candidate::{Row, balance};
use readings::{History, Vibration};

/// Needed forces that are tried, each larger than the one before by [`STEP`] in the logarithm, from the force at the alarm on; all as probable.
const FORCES: usize = 24;
const STEP: f32 = 0.21;
/// Times in which the load may come (s), with the logarithms of their probabilities 1/2, 1/4, 1/4.
const RAMPS: [(f32, f32); 3] = [(0.0, -LN_2), (0.02, -2.0 * LN_2), (0.06, -2.0 * LN_2)];
/// Pairs of both.
pub const CANDIDATES: usize = FORCES * RAMPS.len();

/// Kept readings that are made up for with each new one.
const CATCH_UP: usize = 16;
/// Length of a block (s).
const BLOCK_S: f32 = 3e-4;
/// Block means that are kept, to see whether the stylus stands.
const KEPT: usize = 40;
/// Speed below which a block states as much as at this one (m/s).
const CREEP_M_S: f32 = 5e-4;
/// Bounds of the slope of a surface (rms), and the weight of what is believed of it before (blocks).
const SLOPE: [f32; 2] = [0.005, 0.3];
const SLOPE_BLOCKS: f32 = 0.25;
/// Distance that the object has moved when the alarm comes (m).
const ALARM_M: f32 = 6e-6;
/// Distance in which the heights of a surface change (m): blocks that are closer state the same, down to this share.
const CHANGES_M: f32 = 1e-4;
const LEAST_SHARE: f32 = 0.03;
/// Time constant of all sums (s).
const FORGET_S: f32 = 0.08;
/// Spread of the logarithm of the distance between turns on one surface, and of its median over surfaces; that of all is 100 um (logarithm, m).
const TURN_SPREAD: f32 = 0.45;
const SURFACE_SPREAD: f32 = 0.8;
const TURN_LN: f32 = -9.210_34;
/// How far ahead the needed force is reported (s).
const AHEAD_S: f32 = 4e-3;

/// The object stands where the block means stay within this many deviations of their noise ...
const STILL: f32 = 8.5;
/// ... for so many blocks, and for so many where peaks are hardly above the noise. The last of them but three were already still.
const STILL_BLOCKS: usize = 20;
const STILL_BLOCKS_FAINT: usize = 38;
const UNSETTLED_BLOCKS: usize = 3;
/// It moves where they go further than this many deviations within so many blocks.
const MOVING: f32 = 7.5;
const MOVING_BLOCKS: usize = 8;
/// A mean swing below this many deviations of the noise is faint.
const FAINT: f32 = 25.0;
/// Squared differences of readings over those of the noise: the stylus is so fast that block means blur it, vibrates, moves again, and is not still.
const FAST: f32 = 6.7;
const VIBRATES: f32 = 3.3;
const ALARMS: f32 = 4.4;
const NOT_STILL: f32 = 2.3;
/// Weight of the last block in them.
const SMOOTHING: f32 = 0.2;
/// After a stop for this long (s) only a swing of this share of the mean one is a slip again: pads swing.
const AGAIN_S: f32 = 0.3;
const AGAIN: f32 = 0.5;
/// The range since the stop is forgotten in this time (s); what exceeds this many deviations of the noise is movement.
const AGAIN_TAU_S: f32 = 0.06;
const AGAIN_NOISES: f32 = 9.0;
/// What then passes fewer peaks than this within the mean swing was a swing of the pads; so often at most, since nothing else shows it.
const SWUNG_TURNS: f32 = 2.0;
const SWUNG_SPAN: f32 = 1.1;
const SWUNG_TIMES: u8 = 2;
/// First answer to a slip, and to one that follows a stop, over the force at the alarm.
const FIRST: f32 = 1.4;
const FIRST_AGAIN: f32 = 1.15;
/// An object that is slower than this by all candidates (m/s) does not explain a stylus that vibrates.
const SLOW_M_S: f32 = 0.01;
/// Speed that weighs the first block (m/s).
const FIRST_M_S: f32 = 0.02;

/// What the slip shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "what is seen, each by itself")]
pub struct Felt {
    /// Whether the object moves; in a slip that has not ended it may have stopped.
    pub moves: bool,
    /// Force when it began to move (N).
    pub from_n: f32,
    /// First answer over that force.
    pub first: f32,
    /// Whether it began soon after a stop.
    pub again: bool,
    /// Time since it began to move (s).
    pub since_s: f32,
    /// 10 % quantile of the force that is needed within the next milliseconds (N).
    pub low_n: f32,
    /// Its median (N).
    pub median_n: f32,
    /// Peaks and valleys passed since it began to move.
    pub turns: f32,
    /// Whether the stylus moves now.
    pub vibrates: bool,
    /// Whether it moves more than any likely candidate explains.
    pub unexplained: bool,
    /// Needed force by the balance of impulse (N), once the object has stopped; that of the stop before where only the pads have swung.
    pub held_n: Option<f32>,
    /// Whether that is so.
    pub swung: bool,
}

/// Noise of the readings, by what is made of them.
#[derive(Clone, Copy, Debug, Default)]
struct Noise {
    /// One reading (rms).
    sigma: f32,
    /// Mean of two blocks (rms).
    mean: f32,
    /// Difference of two block means, squared.
    difference: f32,
    /// Squared differences of readings, on the scale of the line above.
    fast: f32,
}

/// How a signal follows the speed.
#[derive(Clone, Copy, Debug)]
struct Law {
    /// Bounds of the root of the power over the speed, for a block.
    slope: [f32; 2],
    /// Distance that the object has moved when the alarm comes (m).
    alarm_m: f32,
    /// Whether peaks and valleys count.
    turns: bool,
}

/// The law of a stylus.
const HEIGHTS: Law = Law { slope: SLOPE, alarm_m: ALARM_M, turns: true };

/// An alarm.
#[derive(Clone, Copy, Debug)]
pub struct Alarm {
    /// What the readings are.
    pub signal: Signal,
    /// White noise of the readings (rms, their unit), above 0.
    pub sigma: f32,
    /// Force of a finger (N).
    pub force_n: f32,
    /// Time between two readings (s).
    pub dt_s: f32,
    /// Since the end of the slip before (s), infinite where there was none.
    pub rested_s: f32,
}

/// What a stop leaves behind.
#[derive(Clone, Copy, Debug, Default)]
struct Stopped {
    /// Mean swing of the slip (m), and needed force (N); 0 before the first stop.
    swing_m: f32,
    held_n: f32,
    /// How often pads have swung since.
    swung: u8,
    /// Time since (s), and range of the readings (m).
    since_s: f32,
    low_m: f32,
    high_m: f32,
}

/// The distribution over [`CANDIDATES`].
#[derive(Clone, Copy, Debug)]
pub struct Need {
    /// The candidates, by the time in which their load comes.
    rows: [Row; RAMPS.len()],
    signal: Signal,
    law: Law,
    vibration: Vibration,
    noise: Noise,
    /// Time (s) and samples of a block.
    block_s: f32,
    samples: u16,
    /// The block that is filled.
    filled: u16,
    sum_m: f32,
    differences: f32,
    last_m: Option<f32>,
    mean_m: Option<f32>,
    /// Squared differences of readings, smoothed.
    fast: f32,
    /// Means of two blocks each and the impulse at their end, the newest at `at`; how many there are.
    means: [f32; KEPT],
    impulses: [f32; KEPT],
    at: usize,
    kept: usize,
    impulse: f32,
    /// Weighted squares of the readings without noise, and the weights.
    power: f32,
    weight: f32,
    speed_m_s: f32,
    swings: Turns,
    /// When in this block the stylus was at the extreme (s); `None` where it was before.
    extreme_s: Option<f32>,
    /// Whether it follows a stop, and the range of the readings (m).
    again: bool,
    low_m: f32,
    high_m: f32,
    stopped: Stopped,
    felt: Felt,
    history: History,
}

impl Default for Need {
    fn default() -> Self {
        Self {
            rows: [Row::EMPTY; RAMPS.len()],
            signal: Signal::default(),
            law: HEIGHTS,
            vibration: Vibration::default(),
            noise: Noise::default(),
            block_s: BLOCK_S,
            samples: 1,
            filled: 0,
            sum_m: 0.0,
            differences: 0.0,
            last_m: None,
            mean_m: None,
            fast: 0.0,
            means: [0.0; KEPT],
            impulses: [0.0; KEPT],
            at: 0,
            kept: 0,
            impulse: 0.0,
            power: 0.0,
            weight: 0.0,
            speed_m_s: FIRST_M_S,
            swings: Turns::NEW,
            extreme_s: None,
            again: false,
            low_m: 0.0,
            high_m: 0.0,
            stopped: Stopped::default(),
            felt: Felt::default(),
            history: History::default(),
        }
    }
}

impl Need {
    /// An alarm: what came before shows nothing more, but for the last stop.
    pub fn begin(&mut self, alarm: &Alarm) {
        let Alarm { signal, sigma, force_n, dt_s, rested_s } = *alarm;
        let since_s = self.stopped.since_s + rested_s;
        let again = since_s < AGAIN_S && self.stopped.swing_m > 0.0;
        let stopped = if again { Stopped { since_s, ..self.stopped } } else { Stopped::default() };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 300")]
        let samples = libm::roundf(BLOCK_S / dt_s.max(1e-6)).clamp(1.0, 300.0) as u16;
        let n = f32::from(samples);
        let variance = sigma * sigma;
        let noise = Noise {
            sigma,
            mean: sigma / libm::sqrtf(2.0 * n),
            difference: 2.0 * variance / n,
            fast: 2.0 * n * n * variance,
        };
        self.signal = signal;
        self.law = match signal {
            Signal::Displacement => HEIGHTS,
            Signal::Vibration => readings::law(n * dt_s),
        };
        self.vibration.begin();
        // In place: a copy of all this would not fit on the stack of a microcontroller.
        (self.noise, self.samples, self.block_s, self.stopped) =
            (noise, samples, n * dt_s, stopped);
        (self.filled, self.sum_m, self.differences, self.fast) = (0, 0.0, 0.0, 0.0);
        (self.last_m, self.mean_m, self.again, self.kept) = (None, None, false, 0);
        self.history.clear();
        if again {
            // Nothing is answered before it is known to move.
            self.felt = Felt { from_n: force_n, first: 1.0, ..Felt::default() };
        } else {
            self.start(force_n, FIRST);
        }
    }

    /// What the slip shows so far; `None` while another sensor shows, and after that until this has caught up.
    #[must_use]
    pub fn felt(&self) -> Option<Felt> {
        self.history.is_empty().then_some(self.felt)
    }

    /// Keeps the next reading (m) and the force of a finger (N) for later: another sensor shows how the object moves.
    #[inline]
    pub fn keep(&mut self, x_m: f32, force_n: f32) {
        self.history.keep(x_m, force_n);
    }

    /// Takes the next reading (m) and the force of a finger (N), after those that were kept: 16 of them with each new one.
    pub fn push(&mut self, x_m: f32, force_n: f32) {
        if self.history.is_empty() {
            self.take(x_m, force_n);
            return;
        }
        self.history.keep(x_m, force_n);
        for _ in 0..CATCH_UP {
            let Some((x_m, force_n)) = self.history.next() else { break };
            self.take(x_m, force_n);
        }
    }

    /// One reading, in its order.
    #[inline]
    fn take(&mut self, x_m: f32, force_n: f32) {
        if self.signal == Signal::Vibration {
            self.take_vibration(x_m, force_n);
            return;
        }
        let last_m = self.last_m.replace(x_m).unwrap_or(x_m);
        self.sum_m += x_m;
        self.differences += (x_m - last_m) * (x_m - last_m);
        self.filled += 1;
        if self.felt.moves {
            self.swing(x_m);
        }
        if self.filled >= self.samples {
            let n = f32::from(self.filled);
            let (mean_m, fast) = (self.sum_m / n, n * self.differences);
            (self.filled, self.sum_m, self.differences) = (0, 0.0, 0.0);
            self.block(mean_m, fast, force_n);
        }
    }

    /// One reading of a vibration, in deviations of its noise: so no unit matters.
    fn take_vibration(&mut self, x: f32, force_n: f32) {
        let dt_s = self.block_s / f32::from(self.samples);
        let without = self.vibration.without_mean(x / self.noise.sigma, dt_s);
        self.sum_m += without * without;
        self.filled += 1;
        if self.filled >= self.samples {
            let power = self.sum_m / f32::from(self.filled);
            (self.filled, self.sum_m) = (0, 0.0);
            self.block_of_vibration(power, force_n);
        }
    }

    /// The object begins to move under `force_n` (N).
    fn start(&mut self, force_n: f32, first: f32) {
        let force_n = force_n.max(1e-3);
        (self.impulse, self.power, self.weight, self.kept) = (0.0, 0.0, 0.0, 0);
        self.speed_m_s = FIRST_M_S;
        (self.swings, self.extreme_s) = (Turns::NEW, None);
        self.vibration.start();
        for (row, (ramp_s, _)) in self.rows.iter_mut().zip(RAMPS) {
            row.start(force_n, ramp_s, self.law.alarm_m);
        }
        let (low_n, median_n) = (force_n, force_n);
        self.felt = Felt {
            moves: true,
            from_n: force_n,
            first,
            again: self.again,
            low_n,
            median_n,
            vibrates: true,
            ..Felt::default()
        };
    }

    /// Peaks and valleys, reading by reading.
    fn swing(&mut self, x_m: f32) {
        let within_s = self.block_s * f32::from(self.filled) / f32::from(self.samples);
        let seen = self.swings.push(x_m, self.noise.sigma);
        if seen == Turn::Between {
            return;
        }
        // Within a block the candidates stand: of its extremes only the last before a turn and the last of all count.
        let before_s = self.extreme_s.replace(within_s);
        if let Turn::Turned { ends } = seen {
            for row in &mut self.rows {
                if let Some(before_s) = before_s {
                    row.extreme(before_s);
                }
                row.turn(ends);
            }
        }
    }

    fn block(&mut self, mean_m: f32, fast: f32, force_n: f32) {
        let before_m = self.mean_m.replace(mean_m).unwrap_or(mean_m);
        let middle_m = 0.5 * (mean_m + before_m);
        self.fast += SMOOTHING * (fast - self.fast);
        self.impulse += force_n * self.block_s;
        self.at = (self.at + 1) % KEPT;
        if let (Some(mean), Some(impulse)) =
            (self.means.get_mut(self.at), self.impulses.get_mut(self.at))
        {
            (*mean, *impulse) = (middle_m, self.impulse);
        }
        self.kept = (self.kept + 1).min(KEPT);
        if self.kept == 1 {
            (self.low_m, self.high_m) = (middle_m, middle_m);
        }
        if self.felt.moves {
            (self.low_m, self.high_m) = (self.low_m.min(middle_m), self.high_m.max(middle_m));
            self.felt.since_s += self.block_s;
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
        let stopped = &mut self.stopped;
        stopped.since_s += self.block_s;
        if self.kept == 1 {
            (stopped.low_m, stopped.high_m) = (middle_m, middle_m);
        }
        let back_m = self.block_s / AGAIN_TAU_S * (stopped.high_m - stopped.low_m);
        stopped.low_m = (stopped.low_m + back_m).min(middle_m);
        stopped.high_m = (stopped.high_m - back_m).max(middle_m);
        let soon = stopped.since_s < AGAIN_S;
        let swing_m = if soon { AGAIN * stopped.swing_m } else { 0.0 };
        let moved_m = stopped.high_m - stopped.low_m;
        if moved_m > (AGAIN_NOISES * self.noise.mean).max(swing_m)
            || self.fast > ALARMS * self.noise.fast
        {
            let faint = stopped.swing_m < FAINT * self.noise.mean;
            self.again = soon;
            self.start(force_n, if faint { FIRST } else { FIRST_AGAIN });
        }
    }

    /// Whether peaks are hardly above the noise.
    fn is_faint(&self) -> bool {
        self.swings.swing() > 0.0 && self.swings.swing() < FAINT * self.noise.mean
    }

    /// Whether the stylus stands.
    fn stands(&self) -> bool {
        let blocks = if self.is_faint() { STILL_BLOCKS_FAINT } else { STILL_BLOCKS };
        self.kept > blocks
            && self.fast <= NOT_STILL * self.noise.fast
            && self.range_m(blocks) < STILL * self.noise.mean
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
        let mean_m = self.swings.swing();
        let swung = self.again
            && self.stopped.swung < SWUNG_TIMES
            && self.swings.count() < SWUNG_TURNS
            && self.high_m - self.low_m < SWUNG_SPAN * self.stopped.swing_m;
        let before = self.stopped;
        self.stopped = if swung {
            Stopped {
                swung: before.swung + 1,
                since_s: 0.0,
                low_m: middle_m,
                high_m: middle_m,
                ..before
            }
        } else {
            let swing_m = if mean_m > 0.0 { mean_m } else { 0.5 * self.swings.range() };
            let held_n = self.held_n(force_n);
            Stopped { swing_m, held_n, swung: 0, since_s: 0.0, low_m: middle_m, high_m: middle_m }
        };
        let held_n = Some(self.stopped.held_n);
        self.felt = Felt { moves: false, vibrates: false, held_n, swung, ..self.felt };
    }

    /// Mean force of the slip (N), for each time in which the load may have come.
    fn held_n(&self, force_n: f32) -> f32 {
        let blocks = if self.is_faint() { STILL_BLOCKS_FAINT } else { STILL_BLOCKS };
        let back = (blocks - UNSETTLED_BLOCKS).min(self.kept.saturating_sub(1));
        let impulse =
            self.impulses.get((self.at + KEPT - back) % KEPT).copied().unwrap_or(self.impulse);
        let lasted_s = (self.felt.since_s - back as f32 * self.block_s).max(1e-3);
        let from_n = self.felt.from_n;
        let (mut ln, mut all) = (0.0, 0.0);
        for (row, (ramp_s, _)) in self.rows.iter().zip(RAMPS) {
            let p: f32 = row.p.iter().sum();
            if p >= 1e-3 {
                let before_s: f32 = row.p.iter().zip(&row.before_s).map(|(p, s)| p * s).sum();
                let before_s = before_s / p;
                let impulse = impulse + from_n * before_s;
                ln += p * libm::logf(balance(impulse, lasted_s + before_s, from_n, ramp_s));
                all += p;
            }
        }
        if all > 0.0 { libm::expf(ln / all).max(from_n) } else { force_n.max(from_n) }
    }

    /// One block of a slip: difference of the block means (m), squared differences of the readings, and the force (N).
    fn weigh(&mut self, difference_m: f32, fast: f32, force_n: f32) {
        let d_s = self.block_s;
        let noise = self.noise.difference.max(1e-30);
        let square = if self.fast > FAST * self.noise.fast {
            (fast - self.noise.fast).max(0.0) + noise
        } else {
            difference_m * difference_m
        };
        let w = (self.speed_m_s * d_s / CHANGES_M).clamp(LEAST_SHARE, 1.0);
        self.believe(square, noise, w, force_n);
        self.felt = Felt {
            turns: self.swings.count(),
            vibrates: self.range_m(MOVING_BLOCKS) > MOVING * self.noise.mean,
            unexplained: self.speed_m_s < SLOW_M_S && self.fast > VIBRATES * self.noise.fast,
            ..self.felt
        };
    }
}

#[cfg(test)]
mod tests;
