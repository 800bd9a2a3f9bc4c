//! Mean of the stylus under a changing grip force: whether it drifts, and how far it goes with pads that give way.
//!
//! While an object is held still, the mean of the stylus may move only as far as the pads give way under a change of force. In
//! seconds (stylus mean m, force mean F; one reading a millisecond):
//!
//! ```text
//! drifting when |m - m0| > limit + per_newton |F - F0|                       m0, F0: the first second of the hold
//! good again when the same is below half of it for 3 s in a row, or with a new anchor
//! ```
//!
//! The anchor (m0, F0) never follows the signal: that would be to re-baseline. It is taken anew only where the stylus does stand on
//! another place: when an object is taken, when a slip has ended, and when a failed stylus has come back. Then the state is good again and reported as such, so a stylus that goes
//! on drifting is found again. Nothing is judged in an open hand, during a slip, or without a force reading, where drift cannot be distinguished from
//! a change of grip. A drift below limit / length of the hold is not seen; it ends as saturation.

use crate::{
    sample::{ANY, Sample},
    settings::settings,
    units::Micros,
};

settings! {
    /// How far a hold may move the stylus.
    pub struct DriftConfig as c in "health.drift" {
        limit: f32 = 1e-4, 1e-12..=ANY =>
            "Shift of the mean at constant force that is drift (signal unit); beyond creep of the pads and"
            "temperature.";
        per_newton: f32 = 5e-5, 0.0..=1e12 => "What a change of grip force may add to it (signal unit per newton).";
    }
}

/// What the hand does, as far as the stylus is concerned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hold {
    /// Nothing is held, it is just being taken, or the readings are not to be believed.
    #[default]
    None,
    /// An object is held and does not slip.
    Still,
    /// The object slips.
    Slipping,
}

/// Length of the stretches that are compared (us).
const SECOND: u64 = 1_000_000;
/// Time between two readings that count (us).
const EVERY: u64 = 1000;
/// Seconds below half of the limit after which a drift is over.
const CALM: u8 = 3;

/// Sums of a stretch.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    stylus: f32,
    force: f32,
    count: u16,
}

/// The watch and its memory.
#[derive(Clone, Copy, Debug)]
pub struct DriftWatch {
    config: DriftConfig,
    hold: Hold,
    next: Micros,
    end: Micros,
    /// The readings are summed about this one, so that a large offset costs no digits.
    first: f32,
    sums: Sums,
    anchor: Option<(f32, f32)>,
    calm: u8,
    drifting: bool,
}

impl DriftWatch {
    /// A watch that has seen nothing yet.
    #[must_use]
    pub fn new(config: DriftConfig) -> Self {
        Self {
            config,
            hold: Hold::None,
            next: Micros(0),
            end: Micros(0),
            first: 0.0,
            sums: Sums::default(),
            anchor: None,
            calm: 0,
            drifting: false,
        }
    }

    /// Whether the stylus drifts. Takes the next reading of the stylus (finite) at `t` with the force of a finger (N).
    #[inline]
    pub fn step(&mut self, t: Micros, stylus: f32, force_n: Option<f32>, hold: Hold) -> bool {
        if hold != self.hold {
            self.turn(t, hold);
        }
        if hold == Hold::Still && t >= self.next {
            self.take(t, stylus, force_n);
        }
        self.drifting
    }

    /// Another hold: a new place under the stylus. During a slip the last word stands.
    #[cold]
    fn turn(&mut self, t: Micros, hold: Hold) {
        self.hold = hold;
        self.anchor = None;
        self.calm = 0;
        self.drifting &= hold != Hold::Still;
        self.next = t;
        self.begin(t);
    }

    fn begin(&mut self, t: Micros) {
        self.sums = Sums::default();
        self.end = t.plus(Micros(SECOND));
    }

    fn take(&mut self, t: Micros, stylus: f32, force_n: Option<f32>) {
        self.next = t.plus(Micros(EVERY));
        let Some(force_n) = force_n else { return };
        if self.sums.count == 0 {
            self.first = stylus;
        }
        self.sums.stylus += stylus - self.first;
        self.sums.force += force_n;
        self.sums.count = self.sums.count.saturating_add(1);
        if t >= self.end {
            self.end_stretch(t);
        }
    }

    fn end_stretch(&mut self, t: Micros) {
        let count = f32::from(self.sums.count.max(1));
        let mean = (self.first + self.sums.stylus / count, self.sums.force / count);
        self.begin(t);
        let anchor = *self.anchor.get_or_insert(mean);
        let allowed = self.config.limit + self.config.per_newton * (mean.1 - anchor.1).abs();
        let shift = (mean.0 - anchor.0).abs();
        if shift > allowed {
            self.drifting = true;
            self.calm = 0;
        } else if shift < 0.5 * allowed {
            self.calm = self.calm.saturating_add(1);
            self.drifting &= self.calm < CALM;
        } else {
            self.calm = 0;
        }
    }
}

// Compensation of the stylus reading for what the pads give way under the grip force.

/// Readings that a slope takes.
const READINGS: u32 = 50;
/// It also takes a force that spreads by this (N, standard deviation), and is so many times its own deviation.
const SPREAD_N: f32 = 0.1;
const SURE: f32 = 20.0;
/// What the noise of the force sensor moves the levelled reading by is this share of the noise of the stylus at most.
const NOISE: f32 = 0.6;
/// Where it is so many times that, the force shows too little: nothing is taken away.
const TOO_NOISY: f32 = 12.0;
/// A reading further from the force that is expected than this (N) and so many of its deviations counts as one at that distance.
const GLITCH_N: f32 = 0.5;
const GLITCH: f32 = 5.0;
/// Time (s) after which the share of the slope is looked at again; its variance before a slip, and what is added each time.
const BLOCK_S: f32 = 1e-3;
const UNSURE: f32 = 0.1;
const CHANGES: f32 = 4e-4;
/// Of the squared movement of the surface in a block so much is new.
const NEW: f32 = 0.1;
/// The largest share: pads get stiffer.
const MOST: f32 = 1.5;

/// How far the force pushes the stylus in.
///
/// A stylus that stands out of a pad is pushed in when the pad gives way under the grip force. In a slip the force rises by many newtons, so that this
/// movement looks like a surface. How far it is pushed in by a newton is learned while the fingers close and nothing slips: the slope of the reading
/// over the force, where that is known well. In a slip it is taken away from the reading; afterwards what was taken away stays as it is,
/// so that the reading does not jump.
///
/// Pads get stiffer with the force. So the slope is followed in the slip by a Kalman filter of one state, the share of the slope at the trial force; the
/// surface is its noise.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sink {
    /// Of the readings since touch: number, means of force (N) and reading, sums of squares and of the product of their deviations.
    count: u32,
    force_n: f32,
    reading: f32,
    squares: [f32; 2],
    product: f32,
    /// Unit of the reading for one newton at the trial force, 0 where nothing is known, and the share of it now with its variance.
    per_n: f32,
    share: f32,
    variance: f32,
    /// What is taken away, and the force (N) of the last sample of the slip.
    taken: f32,
    last_n: f32,
    /// Of the block: length so far (s), force (N) and reading at its begin; squared movement of the surface in a block.
    block_s: f32,
    block_n: f32,
    block: f32,
    surface: f32,
    /// Sum of the squared differences of one force reading and the next (N^2), and the last reading (N).
    differences: f32,
    read_n: f32,
    /// Deviation of a force reading (N), and time constant (s) of what corrects the force of the command.
    sigma_n: f32,
    corrects_s: f32,
    /// Force by the command alone (N), and the last change of the force (N).
    commanded_n: f32,
    step_n: f32,
    raw: f32,
}

impl Sink {
    /// Takes a sample while no object is held: with touch the fingers close on it, without any nothing is known of the next grasp.
    pub(crate) fn close(&mut self, sample: &Sample, touching: bool) {
        match sample.normal_force_n.filter(|_| touching) {
            Some(force_n) => self.learn(sample.stylus, force_n),
            None => self.open(),
        }
    }

    fn open(&mut self) {
        (self.count, self.force_n, self.reading) = (0, 0.0, 0.0);
        (self.squares, self.product, self.differences) = ([0.0; 2], 0.0, 0.0);
    }

    fn learn(&mut self, reading: f32, force_n: f32) {
        if !(reading.is_finite() && force_n.is_finite()) {
            return;
        }
        if self.count > 0 {
            self.differences += (force_n - self.read_n) * (force_n - self.read_n);
        }
        self.read_n = force_n;
        self.count = self.count.saturating_add(1);
        let share = 1.0 / self.count as f32;
        let (by_n, by) = (force_n - self.force_n, reading - self.reading);
        self.force_n += share * by_n;
        self.reading += share * by;
        let left = reading - self.reading;
        self.squares[0] += by_n * (force_n - self.force_n);
        self.squares[1] += by * left;
        self.product += by_n * left;
    }

    /// The object is held: the slope is what was learned of this grasp.
    pub(crate) fn settle(&mut self) {
        if self.count < READINGS {
            return;
        }
        let [forces, readings] = self.squares;
        let count = self.count as f32;
        self.sigma_n = libm::sqrtf(0.5 * self.differences / count);
        let per_n = self.product / forces;
        // Variance of the reading that the force does not explain, and with it that of the slope.
        let rest = (readings - per_n * self.product).max(0.0);
        let sure = per_n * per_n * forces * count >= SURE * SURE * rest;
        let spread = forces >= SPREAD_N * SPREAD_N * count;
        self.per_n = if spread && sure && per_n.is_finite() { per_n } else { 0.0 };
        self.open();
    }

    /// A slip begins: force by its sensor, where that shows any, and by the command (N), as the sensor shows them. `noise` is that of the stylus (its unit),
    /// `dt_s` the time between samples (s).
    pub(crate) fn begin(&mut self, read_n: Option<f32>, commanded_n: f32, noise: f32, dt_s: f32) {
        let noises = self.per_n * self.sigma_n / (NOISE * noise);
        if noises > TOO_NOISY {
            self.per_n = 0.0;
        }
        let corrects_s = 0.5 * dt_s * noises * noises;
        self.corrects_s = if corrects_s.is_finite() { corrects_s } else { 0.0 };
        // A single reading of a noisy sensor is no beginning.
        let sound = self.corrects_s <= dt_s;
        let force_n = read_n.filter(|n| sound && n.is_finite()).unwrap_or(commanded_n);
        (self.last_n, self.commanded_n, self.step_n) = (force_n, commanded_n, 0.0);
        (self.block_n, self.block, self.block_s) = (force_n, self.raw, 0.0);
        (self.share, self.variance, self.surface) = (1.0, UNSURE, 0.0);
    }

    /// The force (N) in a slip, by its sensor and by the command alone, and the time since the sample before (s). A noisy sensor only corrects the
    /// command, so that its noise does not look like a surface.
    #[inline]
    pub(crate) fn follow(&mut self, force_n: f32, commanded_n: f32, dt_s: f32) {
        if self.per_n == 0.0 {
            return;
        }
        let expected_n = self.last_n + commanded_n - self.commanded_n;
        self.commanded_n = commanded_n;
        let share = if self.corrects_s > dt_s { dt_s / self.corrects_s } else { 1.0 };
        let off_n = force_n - expected_n;
        let most_n = GLITCH_N + GLITCH * self.sigma_n;
        let off_n = if off_n.is_finite() { off_n.min(most_n).max(-most_n) } else { 0.0 };
        let force_n = expected_n + share * off_n;
        self.step_n = force_n - self.last_n;
        self.taken += self.share * self.per_n * self.step_n;
        self.last_n = force_n;
        self.block_s += dt_s;
        if self.block_s >= BLOCK_S {
            self.correct(force_n);
        }
    }

    /// Corrects the share of the slope by the movement of the last block.
    #[cold]
    fn correct(&mut self, force_n: f32) {
        let pushed = self.per_n * (force_n - self.block_n);
        let missed = self.raw - self.block - self.share * pushed;
        (self.block_s, self.block_n, self.block) = (0.0, force_n, self.raw);
        let new = if self.surface == 0.0 { 1.0 } else { NEW };
        self.surface += new * (missed * missed - self.surface);
        let gain = self.variance * pushed / (self.surface + self.variance * pushed * pushed);
        if gain.is_finite() {
            self.share = (self.share + gain * missed).clamp(0.0, MOST);
            self.variance = (1.0 - gain * pushed) * self.variance + CHANGES;
        }
    }

    /// The slip has ended: what is taken away stays.
    pub(crate) fn end(&mut self) {
        self.step_n = 0.0;
    }

    /// The sample without what the force has pushed the stylus in; `None` where that is nothing.
    #[inline]
    pub(crate) fn level(&mut self, sample: &Sample) -> Option<Sample> {
        self.raw = sample.stylus;
        // The force of the sample itself is known only after it was judged: it is as much further on as the last one was.
        let taken = self.taken + self.share * self.per_n * self.step_n;
        if taken == 0.0 {
            return None;
        }
        Some(Sample {
            stylus: sample.stylus - taken,
            second_stylus: sample.second_stylus.map(|reading| reading - taken),
            ..*sample
        })
    }

    /// How far the stylus sinks in with the force (its unit over N), as far as the closing has shown.
    pub(crate) fn per_n(&self) -> f32 {
        self.per_n
    }

    /// The last reading as it came.
    pub(crate) fn raw(&self) -> f32 {
        self.raw
    }
}

#[cfg(test)]
mod tests {
    use super::{DriftConfig, DriftWatch, Hold};
    use crate::units::Micros;

    /// Runs from second `from` to `to` at 2 kHz and states after which seconds the watch said that it drifts.
    fn run(
        watch: &mut DriftWatch,
        from: u16,
        to: u16,
        hold: Hold,
        signal: impl Fn(f32) -> (f32, Option<f32>),
    ) -> [bool; 64] {
        let mut stated = [false; 64];
        for i in u32::from(from) * 2000..u32::from(to) * 2000 {
            let t_s = i as f32 / 2000.0;
            let (stylus, force_n) = signal(t_s);
            let drifts = watch.step(Micros(u64::from(i) * 500), stylus, force_n, hold);
            stated[i as usize / 2000] = drifts;
        }
        stated
    }

    fn watch() -> DriftWatch {
        DriftWatch::new(DriftConfig::default())
    }

    /// 20 um/s, with vibration: 100 um are passed between the 6th and the 7th second.
    #[test]
    fn a_slow_drift_is_found_and_reported_until_it_is_gone() {
        let mut watch = watch();
        let wave = |t: f32| 5e-6 * libm::sinf(900.0 * t);
        let stated =
            run(&mut watch, 0, 12, Hold::Still, |t| (3e-4 + 2e-5 * t + wave(t), Some(5.0)));
        assert!(!stated[4] && stated[6] && stated[11], "{stated:?}");
        // It stays where it is: nothing is re-baselined.
        assert!(run(&mut watch, 12, 30, Hold::Still, |_| (5.4e-4, Some(5.0)))[29]);
        // Back at its place: three seconds of it, then good.
        let stated = run(&mut watch, 30, 40, Hold::Still, |t| (3.1e-4 + wave(t), Some(5.0)));
        assert!(stated[31] && !stated[35], "{stated:?}");
    }

    #[test]
    fn a_change_of_grip_force_is_no_drift() {
        let mut watch = watch();
        // Pads that give way by 30 um/N, from 2 to 30 N and back, with 10 um of creep.
        let force = |t: f32| if t < 25.0 { 2.0 + 1.12 * t } else { 30.0 - 1.5 * (t - 25.0) };
        let stated =
            run(&mut watch, 0, 40, Hold::Still, |t| (3e-5 * force(t) + 2.5e-7 * t, Some(force(t))));
        assert!(!stated.contains(&true), "{stated:?}");
        // The same way without the force is one.
        let stated = run(&mut self::watch(), 0, 40, Hold::Still, |t| (3e-5 * force(t), Some(2.0)));
        assert!(stated[10], "{stated:?}");
    }

    #[test]
    fn another_object_and_the_end_of_a_slip_are_another_place() {
        let mut watch = watch();
        let at = |level: f32| move |_: f32| (level, Some(5.0));
        run(&mut watch, 0, 3, Hold::Still, at(0.0));
        let slip = run(&mut watch, 3, 5, Hold::Slipping, at(1e-3));
        let after = run(&mut watch, 5, 9, Hold::Still, at(1e-3));
        assert!(!slip[4] && !after[8]);
        let stated = run(&mut watch, 9, 13, Hold::Still, at(2e-3));
        assert!(stated[12]);
        // The hand opens: still reported. The next hold begins good and is judged by itself.
        assert!(run(&mut watch, 13, 15, Hold::None, at(0.0))[14]);
        assert!(!run(&mut watch, 15, 18, Hold::Still, at(2e-3))[17]);
        assert!(run(&mut watch, 18, 22, Hold::Still, at(3e-3))[21]);
    }

    #[test]
    fn without_force_nothing_is_judged() {
        let mut watch = watch();
        let stated = run(&mut watch, 0, 30, Hold::Still, |t| (1e-4 * t, None));
        assert!(!stated.contains(&true), "drift cannot be told from a change of grip");
    }
}

#[cfg(test)]
mod sink_tests;
