//! Filter that removes isolated wrong readings of a stylus or vibration sensor.
//!
//! # Rule
//! The usual step `s` is the running mean of the distance between a reading and the output before it, each counted as
//! at most 3 `s`. A reading *leaps* where it lies more than 6 `s` from the last output. From 1 kHz on, one that leaps
//! while none of the four before it did is held back: the output is the mean of the last four outputs. The next
//! reading decides. Where it does not leap, the one held back was isolated, and is counted; where it leaps too, the
//! signal has moved, and goes on with what comes. From 10 kHz on a second reading is held back where it lies nearer
//! to the first than that lies to the output (a wrong pair of 40 to 200 us); then the third decides. No reading comes
//! late, and none is replaced that does not leap out of a quiet stretch. While an object slips nothing is held back:
//! its surface leaps, and is measured. Nor below 1 kHz, where a single reading may be all that a slip shows.
//!
//! # Why these numbers
//! - 6 `s` is 6.7 deviations of white Gaussian noise, of which 3 readings in a million leap
//!   (`gaussian_noise_stays_as_it_is`).
//! - The mean of four, not the last output: to repeat one reading turns two readings of noise into energy at low
//!   frequencies.
//! - 3 `s` keeps outliers out of their own measure; a weight of 1/256 follows the noise within some 25 ms at 10 kHz.
//! - Steps of 0 show the resolution of a sensor, not its noise: single counts of a coarse one are no leaps.
//! - A median of three would do without `s`, but halves 2-3 kHz at 10 kHz. At 1 kHz it makes white noise so uneven
//!   that it has 29 false alarms in 8 h where readings as they are, and these rules, have none.
//!
//! # Limits
//! What stays in: two wrong readings in a row below 10 kHz, three anywhere (`runs_that_are_too_long_stay`); the
//! second of two within five readings; what lies within 6 `s`; and all while the first 64 steps
//! are learned. What it costs: a slip that begins with a leap loses that reading, two from 10 kHz on. Where that one
//! would have been the alarm, the alarm waits for the next ones
//! (`an_onset_is_found_as_soon_as_its_next_readings_show_it`).

use crate::{sample::Vector, units::Hertz};

/// How far readings usually lie apart (unit of the sensor).
#[derive(Clone, Copy, Debug, Default)]
struct UsualStep {
    mean: f32,
    seen: u16,
}

impl UsualStep {
    /// Steps that are averaged before the mean is believed, and those from which one step is bounded.
    const LEARNED: u16 = 64;
    const BOUNDED: u16 = 8;
    /// Weight of a step in the running mean, and how many times the mean one step may count.
    const WEIGHT: f32 = 1.0 / 256.0;
    const MOST: f32 = 3.0;

    /// So many times the mean; no bound while that is not known.
    #[inline]
    fn times(self, ratio: f32) -> f32 {
        if self.seen < Self::LEARNED { f32::MAX } else { ratio * self.mean }
    }

    /// Learns from a step. No change at all is the resolution of the sensor, not its noise.
    #[inline]
    fn learn(&mut self, step: f32) {
        if step == 0.0 {
            return;
        }
        let most = if self.seen < Self::BOUNDED { step } else { Self::MOST * self.mean };
        self.seen += u16::from(self.seen < Self::LEARNED);
        let change = step.min(most) - self.mean;
        self.mean += if self.seen < Self::LEARNED {
            change / f32::from(self.seen)
        } else {
            Self::WEIGHT * change
        };
    }
}

/// A step so many times the usual one is no vibration: a glitch of the line, however small the numbers (80 dB).
const GLITCH: f32 = 1e4;
/// A step so many times the usual one leaps.
const LEAP: f32 = 6.0;
/// Readings after one that leapt, during which none is held back.
const QUIET: u8 = 4;

/// From this sample rate on (Hz) single readings are held back.
pub const SINGLE_HZ: f32 = 1e3;
/// From this one on pairs are.
const PAIR_HZ: f32 = 1e4;

/// The guard against isolated wrong readings, and its memory.
#[derive(Clone, Copy, Debug)]
pub struct Guard {
    /// How many readings may be held back.
    most: u8,
    usual: UsualStep,
    /// The last four outputs, in turn, and the place of the last one.
    outputs: [Vector; 4],
    at: usize,
    /// Readings since the last one that leapt.
    quiet: u8,
    /// Readings that are held back, and the first of them.
    held: u8,
    first: Vector,
    started: bool,
    /// Whether every reading is let through.
    open: bool,
    isolated: u64,
}

impl Guard {
    /// A guard that has seen nothing yet, for readings at `rate`.
    #[must_use]
    pub fn new(rate: Hertz) -> Self {
        let from = |hz: f32| u8::from(rate.0 >= hz);
        Self {
            most: from(SINGLE_HZ) + from(PAIR_HZ),
            usual: UsualStep::default(),
            outputs: [[0.0; 3]; 4],
            at: 0,
            quiet: 0,
            held: 0,
            first: [0.0; 3],
            started: false,
            open: false,
            isolated: 0,
        }
    }

    /// Lets every reading through from now on, or no longer: while an object slips its surface leaps.
    #[inline]
    pub fn set_open(&mut self, open: bool) {
        self.open = open;
    }

    /// Takes the next reading of a sensor; what stands in for it, where it is not to be used as it is. One that is no
    /// number changes nothing.
    #[inline]
    pub fn step(&mut self, x: Vector) -> Option<Vector> {
        let step = self.step_to(x);
        if !step.is_finite() {
            return None;
        }
        if self.started {
            return self.next(x, step);
        }
        self.restart(x);
        self.next(x, 0.0)
    }

    /// Isolated readings so far.
    #[must_use]
    pub fn isolated(&self) -> u64 {
        self.isolated
    }

    /// Whether there was a reading.
    pub(crate) fn has_started(&self) -> bool {
        self.started
    }

    /// Forgets the readings before `x`.
    pub(crate) fn restart(&mut self, x: Vector) {
        self.outputs = [x; 4];
        self.quiet = QUIET;
        self.held = 0;
        self.started = true;
    }

    /// Compares the next reading with none before it, as after a gap in time; the usual step and the count stay.
    pub fn forget(&mut self) {
        self.started = false;
    }

    /// The last output; 0 before the first.
    #[inline]
    pub(crate) fn last(&self) -> Vector {
        self.outputs[self.at & 3]
    }

    /// Distance of a reading from the last output; NaN where a component has no number.
    #[inline]
    pub(crate) fn step_to(&self, x: Vector) -> f32 {
        distance(x, self.last())
    }

    /// The longest step that may be one of the sensor; beyond it the line has failed.
    #[inline]
    pub(crate) fn glitch(&self) -> f32 {
        self.usual.times(GLITCH)
    }

    /// A reading was left out: the next one has nothing quiet before it.
    #[inline]
    pub(crate) fn left_out(&mut self) {
        self.quiet = 0;
    }

    /// Takes a step that has lasted, however long: this is what the signal is like now, and its other swings may be
    /// longer.
    #[inline]
    pub(crate) fn follow(&mut self, step: f32) {
        self.usual.mean = self.usual.mean.max(4.0 * step / GLITCH);
    }

    /// Takes the next reading, `step` from the last output; what stands in for it, where it is not to be used as it is.
    #[inline]
    pub(crate) fn next(&mut self, x: Vector, step: f32) -> Option<Vector> {
        let leaps = step > self.usual.times(LEAP);
        self.usual.learn(step);
        // Most readings are neither.
        let holds = (leaps || self.held > 0) && self.holds(x, leaps);
        self.quiet = if leaps { 0 } else { self.quiet.saturating_add(1) };
        let instead = holds.then(|| self.mean());
        self.at = (self.at + 1) & 3;
        self.outputs[self.at & 3] = instead.unwrap_or(x);
        instead
    }

    /// Whether a reading is held back. Counts those before it where they were isolated.
    fn holds(&mut self, x: Vector, leaps: bool) -> bool {
        let holds = leaps
            && !self.open
            && self.held < self.most
            && match self.held {
                0 => self.quiet >= QUIET,
                _ => distance(x, self.first) < distance(self.first, self.last()),
            };
        if holds {
            if self.held == 0 {
                self.first = x;
            }
            self.held += 1;
        } else {
            self.isolated += if leaps { 0 } else { u64::from(self.held) };
            self.held = 0;
        }
        holds
    }

    /// The mean of the last four outputs.
    fn mean(&self) -> Vector {
        let [a, b, c, d] = self.outputs;
        core::array::from_fn(|i| 0.25 * ((a[i] + b[i]) + (c[i] + d[i])))
    }
}

/// Distance of two readings (unit of the sensor).
#[inline]
fn distance(a: Vector, b: Vector) -> f32 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    if y == 0.0 && z == 0.0 { x.abs() } else { libm::sqrtf(x * x + (y * y + z * z)) }
}

#[cfg(test)]
mod tests {
    use super::Guard;
    use crate::{sample::Vector, units::Hertz};

    /// Uneven readings of some units, of which no step is a leap.
    fn calm(i: u16) -> f32 {
        libm::sinf(f32::from(i) * 2.5)
    }

    /// Readings that are replaced, and the count, where `spoil` changes them.
    fn replaced(rate_hz: f32, spoil: impl Fn(u16, f32) -> Vector) -> ([u16; 4], usize, u64) {
        let mut guard = Guard::new(Hertz(rate_hz));
        let (mut places, mut n) = ([0; 4], 0);
        for i in 0..400 {
            if guard.step(spoil(i, calm(i))).is_some() {
                places[n % 4] = i;
                n += 1;
            }
        }
        (places, n, guard.isolated())
    }

    fn one_axis(spoiled: impl Fn(u16) -> f32) -> impl Fn(u16, f32) -> Vector {
        move |i, x| [x + spoiled(i), 0.0, 0.0]
    }

    #[test]
    fn a_single_reading_is_replaced_from_1_khz_on_and_a_pair_from_10_khz_on() {
        let one = |i| if i == 200 { 60.0 } else { 0.0 };
        let two = |i| if (200..202).contains(&i) { 60.0 } else { 0.0 };
        for (rate_hz, of_one, of_two) in
            [(999.0, (0, 0), (0, 0)), (1e3, (1, 1), (1, 0)), (1e4, (1, 1), (2, 2))]
        {
            let (_, n, counted) = replaced(rate_hz, one_axis(one));
            assert_eq!((n, counted), of_one, "one at {rate_hz} Hz");
            let (_, n, counted) = replaced(rate_hz, one_axis(two));
            assert_eq!((n, counted), of_two, "two at {rate_hz} Hz");
        }
        assert_eq!(replaced(2e3, one_axis(one)).0[0], 200);
    }

    #[test]
    fn runs_that_are_too_long_stay() {
        for (rate_hz, width) in [(2e3, 2), (1e4, 3)] {
            let run = |i| if (200..200 + width).contains(&i) { 60.0 } else { 0.0 };
            let (_, n, counted) = replaced(rate_hz, one_axis(run));
            // All but the last one held back, none counted.
            assert_eq!((n, counted), (usize::from(width) - 1, 0), "{rate_hz} Hz");
        }
    }

    /// A stick-slip event: a leap, then a decaying ring at a sixth of the rate or a quarter, whose second reading
    /// lies near the mean.
    #[test]
    fn an_impulse_that_rings_is_passed_on_from_its_second_reading() {
        for rate_hz in [2e3, 1e4] {
            for per_reading in [1.0, 1.6, 2.3] {
                let ring = |i: u16| {
                    let t = f32::from(i.saturating_sub(200));
                    let level = if i < 200 { 0.0 } else { 60.0 * libm::expf(-0.1 * t) };
                    level * libm::cosf(per_reading * t)
                };
                let (places, n, _) = replaced(rate_hz, one_axis(ring));
                let most = if rate_hz < 1e4 { 1 } else { 2 };
                assert!(n <= most && places[0] == 200, "{rate_hz} Hz, {per_reading}: {places:?}");
            }
        }
    }

    #[test]
    fn a_step_is_passed_on_from_its_second_or_third_reading() {
        for (rate_hz, late) in [(1e3, 1), (2e3, 1), (1e4, 2), (5e4, 2)] {
            let step = |i| if i < 200 { 0.0 } else { 60.0 };
            let (_, n, counted) = replaced(rate_hz, one_axis(step));
            assert_eq!((n, counted), (late, 0), "{rate_hz} Hz");
        }
    }

    #[test]
    fn the_unit_and_the_axis_do_not_matter() {
        let leap = |i: u16| if i % 60 == 59 { 20.0 } else { 0.0 };
        let straight = replaced(1e4, one_axis(leap));
        assert!(straight.1 >= 5 && straight.2 >= 5, "{straight:?}");
        for unit in [1.0 / (1 << 30) as f32, 1.0, (1 << 30) as f32] {
            assert_eq!(replaced(1e4, |i, x| [unit * (x + leap(i)), 0.0, 0.0]), straight);
            assert_eq!(replaced(1e4, |i, x| [0.0, 0.0, unit * (x + leap(i))]), straight);
            let turned = |i, x| [0.6 * unit * (x + leap(i)), 0.0, -0.8 * unit * (x + leap(i))];
            assert_eq!(replaced(1e4, turned), straight);
        }
    }

    #[test]
    fn nothing_is_held_back_while_an_object_slips() {
        let mut guard = Guard::new(Hertz(1e4));
        for i in 0..410 {
            guard.set_open((200..300).contains(&i));
            let leaps = i % 20 == 19 && i > 100;
            let replaced =
                guard.step([calm(i) + if leaps { 30.0 } else { 0.0 }, 0.0, 0.0]).is_some();
            assert_eq!(replaced, leaps && !(200..300).contains(&i), "{i}");
        }
        assert_eq!(guard.isolated(), 10);
    }

    #[test]
    fn single_counts_of_a_coarse_sensor_stay() {
        let mut guard = Guard::new(Hertz(1e4));
        for i in 0..20_000_u16 {
            let count = f32::from(u8::from(i % 50 == 7)) * f32::from(1 + i % 3);
            assert_eq!(guard.step([count, 0.0, 0.0]), None, "{i}");
        }
    }

    #[test]
    fn what_is_no_number_changes_nothing() {
        let mut guard = Guard::new(Hertz(1e4));
        assert_eq!(guard.step([f32::NAN, 0.0, 0.0]), None);
        for i in 0..300 {
            assert_eq!(guard.step([calm(i), 0.0, 0.0]), None);
            assert_eq!(guard.step([calm(i), f32::INFINITY, 0.0]), None);
        }
        assert!(guard.step([60.0, 0.0, 0.0]).is_some_and(|x| x[0].abs() < 1.0));
    }
}
