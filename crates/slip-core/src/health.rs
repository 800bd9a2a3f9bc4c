//! Raw samples in; samples that are safe to compute with, and a verdict on the sensor, out.
//!
//! A reading that is not a number, beyond the sensor's range or a glitch of the line is counted and replaced by the
//! last good one; an isolated wrong one by the mean of those before it ([`isolated`](crate::isolated)). Neither reaches a filter. Too many of them, a value that no longer changes, or a mean that drifts while an
//! object is held, turn the sensor's health, which stops the slip reflex: a dead sensor must not move the fingers.

use crate::{
    drift::{DriftConfig, DriftWatch, Hold},
    isolated::Guard,
    sample::{ANY, FURTHER_AXES, Sample, Vector},
    settings::settings,
    units::{Hertz, Micros},
};
pub use slip_msg::{Sensor, SensorHealth};

settings! {
    /// What is believed of the stylus.
    pub struct HealthConfig as c in "health" {
        range: f32 = 5e-3, 1e-12..=ANY =>
            "Largest magnitude the stylus can show (signal unit); readings at or beyond it are saturated.";
        max_step: f32 = 1e-3, 1e-12..=ANY =>
            "Largest step between two samples that a real surface can cause (signal unit); beyond it a reading is a"
            "glitch.";
        frozen_ms: f32 = 50.0, 1.0..=1e12 =>
            "The stylus counts as frozen when not one bit changed for this long (ms).";
        max_bad_run: u32 = 8, 1.0..=5e9 => "Bad readings in a row after which the stylus counts as failed.";
        [drift]: DriftConfig = DriftConfig::default() => "How far the mean may move while an object is held.";
    }
}

/// A sensor in an unknown unit may be so coarse that its reading stands for this long (ms) at rest.
const COARSE_MS: f32 = 500.0;

impl HealthConfig {
    /// The same for a signal in an unknown unit: the defaults, which are in metres, show nothing of it. No range is known
    /// then, and no shift can be called too far.
    #[must_use]
    pub fn in_any_unit(self) -> Self {
        let default = Self::default();
        let given =
            |value: f32, default: f32, else_: f32| if value == default { else_ } else { value };
        Self {
            range: given(self.range, default.range, ANY),
            max_step: given(self.max_step, default.max_step, ANY),
            frozen_ms: given(self.frozen_ms, default.frozen_ms, COARSE_MS),
            max_bad_run: self.max_bad_run,
            drift: DriftConfig {
                limit: given(self.drift.limit, default.drift.limit, ANY),
                per_newton: given(self.drift.per_newton, default.drift.per_newton, 0.0),
            },
        }
    }
}

/// How often each kind of unusable reading was seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HealthCounters {
    /// NaN or infinite stylus readings.
    pub not_finite: u64,
    /// Stylus readings at or beyond the range.
    pub saturated: u64,
    /// Stylus readings too far from the one before.
    pub glitches: u64,
    /// Readings of the stylus or the reference that leapt out of a quiet stretch and back: isolated wrong ones
    /// ([`isolated`](crate::isolated)). The sensor works and nothing is missing, so they are not among the unusable ones.
    pub isolated: u64,
    /// NaN, infinite or impossible readings of the other channels, taken as absent.
    pub other_channels: u64,
    /// Samples not later than the one before, ignored.
    pub time_faults: u64,
    /// Times the health left [`SensorHealth::Good`].
    pub failures: u64,
}

impl HealthCounters {
    /// Readings of any channel, and samples, that could not be used; without the isolated ones.
    #[must_use]
    pub fn unusable(&self) -> u64 {
        self.not_finite + self.saturated + self.glitches + self.other_channels + self.time_faults
    }
}

/// Largest force (N), travel and speed (m, m/s) and reading of any other channel (own units) that can be meant.
const FORCE_LIMIT_N: f32 = 1e4;
const TRAVEL_LIMIT: f32 = 1e3;
const OTHER_LIMIT: f32 = ANY;

/// A second stylus that stands in for the first.
#[derive(Clone, Copy, Debug)]
struct StandIn {
    /// Its last reading (signal unit) and when that changed.
    last: f32,
    changed_at: Micros,
    /// What it shows less than the first did when that was lost (signal unit): no step for what comes after.
    offset: f32,
}

/// What [`HealthCheck::passes`] makes of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Passed {
    /// [`HealthCheck::check`] is to be asked.
    Not,
    /// The sample can be used as it is.
    AsItIs,
    /// The sample can be used with isolated readings replaced.
    As(Sample),
}

/// The checks and their memory.
#[derive(Clone, Copy, Debug)]
pub struct HealthCheck {
    config: HealthConfig,
    /// The last readings.
    guard: Guard,
    /// Those of the reference, so that a knock begins at the same sample in both.
    reference_guard: Guard,
    /// Whether the guard alone knows which steps are glitches.
    uncalibrated: bool,
    frozen_after: Micros,
    /// The usual time between two samples, and from when on it is a gap.
    period: Micros,
    gap: Micros,
    last_t: Option<Micros>,
    /// When the reading changed last, later by the gaps since then: in a gap nothing could be seen to change.
    changed_at: Micros,
    bad_run: u32,
    saturated_run: u32,
    /// As far as single readings show.
    readings: SensorHealth,
    /// While the first stylus has failed.
    stand_in: Option<StandIn>,
    drift: DriftWatch,
    drifting: bool,
    counters: HealthCounters,
}

impl HealthCheck {
    /// Checks that have seen nothing yet, for samples at `rate`.
    #[must_use]
    pub fn new(config: HealthConfig, rate: Hertz) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the cast saturates; the configuration was checked"
        )]
        let frozen_after = Micros((config.frozen_ms * 1e3) as u64);
        Self {
            config,
            guard: Guard::new(rate),
            reference_guard: Guard::new(rate),
            uncalibrated: false,
            frozen_after,
            period: period(rate),
            gap: gap(rate),
            last_t: None,
            changed_at: Micros(0),
            bad_run: 0,
            saturated_run: 0,
            readings: SensorHealth::Good,
            stand_in: None,
            drift: DriftWatch::new(config.drift),
            drifting: false,
            counters: HealthCounters::default(),
        }
    }

    /// The same for a stylus whose unit is unknown, so that `max_step` can show nothing: a step 10,000 times as long as
    /// the steps so far is a glitch too.
    #[must_use]
    pub fn uncalibrated(config: HealthConfig, rate: Hertz) -> Self {
        Self { uncalibrated: true, ..Self::new(config, rate) }
    }

    /// What was counted so far.
    #[must_use]
    pub fn counters(&self) -> HealthCounters {
        let isolated = self.guard.isolated() + self.reference_guard.isolated();
        HealthCounters { isolated, ..self.counters }
    }

    /// The state of the stylus after the last sample.
    #[must_use]
    #[inline]
    pub fn health(&self) -> SensorHealth {
        match self.readings {
            SensorHealth::Good if self.drifting => SensorHealth::Drifting,
            readings => readings,
        }
    }

    /// Whether the stylus of the checked sample shows what the object does: the first one, or the second where that has failed.
    #[must_use]
    #[inline]
    pub fn feels(&self) -> bool {
        let t = self.last_t.unwrap_or_default();
        self.health() == SensorHealth::Good
            || self.stand_in.is_some_and(|second| t.since(second.changed_at) <= self.frozen_after)
    }

    /// Looks for drift in a checked sample; `hold` is what the hand does at that time.
    #[inline]
    pub fn watch_drift(&mut self, sample: &Sample, hold: Hold) {
        let hold = if self.readings == SensorHealth::Good { hold } else { Hold::None };
        let drifts = self.drift.step(sample.t, sample.stylus, sample.normal_force_n, hold);
        self.counters.failures += u64::from(drifts && !self.drifting);
        self.drifting = drifts;
    }

    /// Takes a sample in which nothing is to be reported, and nothing counted but isolated readings; [`Passed::Not`] where there may
    /// be something, and then [`HealthCheck::check`] is still to be asked.
    #[must_use]
    #[inline]
    pub fn passes(&mut self, sample: &Sample) -> Passed {
        let Some(last_t) = self.last_t else { return Passed::Not };
        let x = sample.vibration();
        let step = self.guard.step_to(x);
        // NaN fails every comparison.
        let plain = self.health() == SensorHealth::Good
            && self.bad_run == 0
            && sample.t > last_t
            && sample.t.since(last_t) <= self.gap
            && x[0].abs() < self.config.range
            && self.is_usual(step)
            && step > 0.0
            && self.others_pass(sample);
        if !plain {
            return Passed::Not;
        }
        self.last_t = Some(sample.t);
        self.changed_at = sample.t;
        self.saturated_run = 0;
        let stylus = self.guard.next(x, step);
        let reference = self.reference_instead(sample);
        if stylus.is_none() && reference.is_none() {
            return Passed::AsItIs;
        }
        let [stylus, y, z] = stylus.unwrap_or(x);
        Passed::As(with_reference(Sample { stylus, stylus_axes: [y, z], ..*sample }, reference))
    }

    /// What stands in for an isolated reading of the reference.
    #[inline]
    fn reference_instead(&mut self, sample: &Sample) -> Option<Vector> {
        self.reference_guard.step(sample.reference_vector()?)
    }

    /// Whether a step (signal unit) can be one of the surface.
    #[inline]
    fn is_usual(&self, step: f32) -> bool {
        step <= self.config.max_step && (!self.uncalibrated || step <= self.guard.glitch())
    }

    /// Whether no channel beside the stylus has an unusable reading.
    #[inline]
    fn others_pass(&self, sample: &Sample) -> bool {
        let within = |value: Option<f32>, limit: f32| value.is_none_or(|v| v.abs() <= limit);
        within(sample.normal_force_n, FORCE_LIMIT_N)
            && within(sample.tangential_n, FORCE_LIMIT_N)
            && within(sample.travel_m, TRAVEL_LIMIT)
            && within(sample.velocity_m_s, TRAVEL_LIMIT)
            && within(sample.second_stylus, self.config.range)
            && within(sample.reference, OTHER_LIMIT)
            && sample.stylus_axes.iter().all(|axis| axis.abs() < self.config.range)
            && sample.reference_axes.iter().all(|axis| axis.abs() <= OTHER_LIMIT)
            && within(sample.pressure, OTHER_LIMIT)
            && within(sample.motion, OTHER_LIMIT)
    }

    /// The sample with every unusable reading replaced (stylus: by that of the second one, or by the last) or taken as absent (others);
    /// `None` where its time does not lie after the one before.
    #[inline]
    pub fn check(&mut self, sample: &Sample) -> Option<Sample> {
        if self.last_t.is_some_and(|t| sample.t <= t) {
            self.counters.time_faults += 1;
            return None;
        }
        let after_gap = self.pass_gap(sample.t);
        let [stylus, y, z] = self.stylus(sample, after_gap);
        let stylus_axes = [y, z];
        self.last_t = Some(sample.t);
        let before = self.health();
        self.readings = self.judge(sample.t);
        if before == SensorHealth::Good && self.readings != SensorHealth::Good {
            self.counters.failures += 1;
        }
        let second_stylus = self.other(sample.second_stylus, self.config.range);
        self.stand_in = self.stand_in_after(sample.t, stylus, second_stylus);
        let (stylus, second_stylus) = match self.stand_in {
            Some(second) => (second.last + second.offset, None),
            None => (stylus, second_stylus),
        };
        // A vector without one of its components is none.
        let whole = sample.reference_axes.iter().all(|axis| axis.abs() <= OTHER_LIMIT);
        let reference = if whole { sample.reference } else { sample.reference.and(Some(f32::NAN)) };
        let reference = self.other(reference, OTHER_LIMIT);
        let checked = Sample {
            t: sample.t,
            stylus,
            stylus_axes,
            normal_force_n: self.other(sample.normal_force_n, FORCE_LIMIT_N),
            tangential_n: self.other(sample.tangential_n, FORCE_LIMIT_N),
            travel_m: self.other(sample.travel_m, TRAVEL_LIMIT),
            velocity_m_s: self.other(sample.velocity_m_s, TRAVEL_LIMIT),
            second_stylus,
            reference,
            reference_axes: if whole { sample.reference_axes } else { [0.0; FURTHER_AXES] },
            pressure: self.other(sample.pressure, OTHER_LIMIT),
            motion: self.other(sample.motion, OTHER_LIMIT),
            arrival: sample.arrival,
        };
        let reference = self.reference_instead(&checked);
        Some(with_reference(checked, reference))
    }

    /// The second stylus with its next reading, where the first has failed at `held` (signal unit).
    #[inline]
    fn stand_in_after(&self, t: Micros, held: f32, second: Option<f32>) -> Option<StandIn> {
        match (self.stand_in, second) {
            _ if self.readings == SensorHealth::Good => None,
            (None, Some(x)) => Some(StandIn { last: x, changed_at: t, offset: held - x }),
            (Some(before), Some(x)) if x.to_bits() != before.last.to_bits() => {
                Some(StandIn { last: x, changed_at: t, ..before })
            }
            (before, _) => before,
        }
    }

    /// Takes the time of a gap before `t` out of that in which nothing has changed; whether there is one.
    #[inline]
    fn pass_gap(&mut self, t: Micros) -> bool {
        let dt = self.last_t.map_or(Micros(0), |last| t.since(last));
        if dt <= self.gap {
            return false;
        }
        let unseen = dt.since(self.period);
        self.changed_at = self.changed_at.plus(unseen);
        self.reference_guard.forget();
        if let Some(second) = &mut self.stand_in {
            second.changed_at = second.changed_at.plus(unseen);
        }
        true
    }

    /// The reading, or what stands in for it: a vector with one bad component is a bad reading.
    #[inline]
    fn stylus(&mut self, sample: &Sample, after_gap: bool) -> Vector {
        let x = sample.vibration();
        let held = self.guard.last();
        if self.last_t.is_none() {
            self.changed_at = sample.t;
        }
        if !self.usable(worst(x)) {
            return held;
        }
        if !self.guard.has_started() {
            self.guard.restart(x);
        }
        // A real step stays; a lone spike is gone after a sample or two.
        let mut step = self.guard.step_to(x);
        if !self.is_usual(step) {
            if self.bad_run < self.config.max_bad_run {
                self.counters.glitches += 1;
                self.bad_run += 1;
                self.guard.left_out();
                return held;
            }
            if self.uncalibrated {
                self.guard.follow(step);
            }
        }
        self.bad_run = 0;
        if x != held {
            self.changed_at = sample.t;
        }
        // What comes after a gap or a failure may have another zero.
        if after_gap || self.readings != SensorHealth::Good {
            self.guard.restart(x);
            step = 0.0;
        }
        self.guard.next(x, step).unwrap_or(x)
    }

    #[inline]
    fn usable(&mut self, x: f32) -> bool {
        if !x.is_finite() {
            self.counters.not_finite += 1;
            self.saturated_run = 0;
            self.bad_run = self.bad_run.saturating_add(1);
            return false;
        }
        if x.abs() >= self.config.range {
            self.counters.saturated += 1;
            self.bad_run = self.bad_run.saturating_add(1);
            self.saturated_run = self.saturated_run.saturating_add(1);
            return false;
        }
        self.saturated_run = 0;
        true
    }

    #[inline]
    fn judge(&self, t: Micros) -> SensorHealth {
        if self.bad_run >= self.config.max_bad_run {
            let saturated = self.saturated_run >= self.config.max_bad_run;
            if saturated { SensorHealth::Saturated } else { SensorHealth::Failed }
        } else if self.bad_run == 0 && t.since(self.changed_at) > self.frozen_after {
            SensorHealth::Frozen
        } else if self.bad_run > 0 {
            self.readings
        } else {
            SensorHealth::Good
        }
    }

    #[inline]
    fn other(&mut self, value: Option<f32>, limit: f32) -> Option<f32> {
        let value = value?;
        // NaN fails the comparison.
        if value.abs() <= limit {
            Some(value)
        } else {
            self.counters.other_channels += 1;
            None
        }
    }
}

fn with_reference(sample: Sample, reference: Option<Vector>) -> Sample {
    match reference {
        Some([x, y, z]) => Sample { reference: Some(x), reference_axes: [y, z], ..sample },
        None => sample,
    }
}

/// The usual time between two samples at `rate`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the cast saturates; the configuration was checked"
)]
fn period(rate: Hertz) -> Micros {
    Micros((1e6 / rate.0).max(1.0) as u64)
}

/// A longer time between two samples at `rate` is a gap: what comes after it is not compared with what was before.
pub(crate) fn gap(rate: Hertz) -> Micros {
    Micros((period(rate).0 * 5).max(10_000))
}

/// The component that is the least usable: one that is no number, else the largest.
#[inline]
fn worst(vector: Vector) -> f32 {
    vector.into_iter().fold(0.0, |worst: f32, x| {
        let worse = x.is_nan() || (!worst.is_nan() && x.abs() > worst.abs());
        if worse { x } else { worst }
    })
}

#[cfg(test)]
mod tests {
    use super::{HealthCheck, HealthConfig, Passed, SensorHealth};
    use crate::{
        sample::Sample,
        units::{Hertz, Micros},
    };

    const RATE: Hertz = Hertz(10_000.0);

    fn check() -> HealthCheck {
        HealthCheck::new(HealthConfig::default(), RATE)
    }

    fn at(i: u16, stylus: f32) -> Sample {
        Sample::stylus(Micros(100 * (u64::from(i) + 1)), stylus)
    }

    #[test]
    fn bad_readings_are_replaced_and_counted() {
        let mut check = check();
        let mut out = |i, x| check.check(&at(i, x)).unwrap().stylus;
        assert_eq!(out(0, 1e-6), 1e-6);
        assert_eq!(out(1, f32::NAN), 1e-6);
        assert_eq!(out(2, f32::NEG_INFINITY), 1e-6);
        assert_eq!(out(3, 1e30), 1e-6);
        assert_eq!(out(4, 4e-3), 1e-6, "a jump of 4 mm in 0.1 ms is a glitch");
        assert_eq!(out(5, 2e-6), 2e-6);
        let counters = check.counters();
        assert_eq!((counters.not_finite, counters.saturated, counters.glitches), (2, 1, 1));
        assert_eq!(check.health(), SensorHealth::Good, "four in a row are not yet a failure");
    }

    #[test]
    fn a_real_step_is_accepted_after_a_while() {
        let mut check = check();
        check.check(&at(0, 0.0));
        let values: [f32; 10] = core::array::from_fn(|i| {
            check.check(&at(u16::try_from(i).unwrap() + 1, 4e-3)).unwrap().stylus
        });
        assert_eq!(values[7], 0.0);
        assert_eq!(values[8], 4e-3);
    }

    #[test]
    fn frozen_saturated_and_failed_are_reported_and_recover() {
        let mut check = check();
        for i in 0..600 {
            check.check(&at(i, 1e-6));
        }
        assert_eq!(check.health(), SensorHealth::Frozen);
        check.check(&at(600, 1.1e-6));
        assert_eq!(check.health(), SensorHealth::Good);
        for i in 601..620 {
            check.check(&at(i, 5e-3));
        }
        assert_eq!(check.health(), SensorHealth::Saturated);
        for i in 620..640 {
            check.check(&at(i, f32::NAN));
        }
        assert_eq!(check.health(), SensorHealth::Failed);
        check.check(&at(640, 1e-6));
        assert_eq!(check.health(), SensorHealth::Good);
        assert_eq!(check.counters().failures, 2);
    }

    /// Readings of some hundredths, as of an accelerometer, with serial glitches.
    #[test]
    fn without_a_unit_a_glitch_is_reported_by_the_steps_before() {
        let config = HealthConfig { range: 1e9, max_step: 1e9, ..HealthConfig::default() };
        let mut check = HealthCheck::uncalibrated(config, RATE);
        let wave = |i: u16| 0.06 * libm::sinf(f32::from(i) * 2.5);
        for i in 0..2000_u16 {
            let glitch = i % 100 == 99;
            let out = check.check(&at(i, if glitch { 5e5 } else { wave(i) })).unwrap().stylus;
            assert!(i < 99 || out.abs() <= 0.06, "{out}");
        }
        assert_eq!((check.counters().glitches, check.health()), (20, SensorHealth::Good));
        // A signal that has really become a million times louder is taken as it is after a while.
        let taken = (2000..3000_u16).filter(|&i| {
            let loud = 1e6 * wave(i);
            check.check(&at(i, loud)).unwrap().stylus == loud
        });
        assert!(taken.count() > 980);
        // Long silence of a coarse sensor does not make its first count a glitch.
        let mut check = HealthCheck::uncalibrated(config, RATE);
        for i in 0..10_000_u16 {
            check.check(&at(i, if i % 1000 < 100 { f32::from(i % 2) } else { 0.0 }));
        }
        assert_eq!(check.counters().glitches, 0);
    }

    #[test]
    fn other_channels_turn_absent() {
        let mut check = check();
        let sample = Sample {
            normal_force_n: Some(f32::NAN),
            travel_m: Some(1e30),
            velocity_m_s: Some(0.1),
            ..at(0, 0.0)
        };
        let out = check.check(&sample).unwrap();
        assert_eq!((out.normal_force_n, out.travel_m, out.velocity_m_s), (None, None, Some(0.1)));
        assert_eq!(check.counters().other_channels, 2);
    }

    #[test]
    fn time_only_goes_forward() {
        let mut check = check();
        assert!(check.check(&at(5, 0.0)).is_some());
        assert!(check.check(&at(5, 0.0)).is_none());
        assert!(check.check(&at(4, 0.0)).is_none());
        assert_eq!(check.counters().time_faults, 2);
    }

    /// Two equal readings on both sides of a gap are what a coarse sensor shows in a quarter of all cases.
    #[test]
    fn a_gap_does_not_freeze_the_stylus() {
        let coarse = |i: u16| 1e-6 * libm::roundf(2.0 * libm::sinf(f32::from(i) * 1.3));
        for second in [None, Some(0.0)] {
            let mut check = check();
            let (mut t, mut last) = (0, 0.0);
            for i in 0..10_000_u16 {
                let gap = i % 1000 == 999;
                t += if gap { 500_000 } else { 100 };
                last = if gap { last } else { coarse(i) };
                let sample = Sample { second_stylus: second, ..Sample::stylus(Micros(t), last) };
                assert!(check.check(&sample).is_some());
                assert_eq!(check.health(), SensorHealth::Good, "{i}");
            }
            assert_eq!(check.counters().failures, 0);
        }
    }

    /// The time between gaps counts, however often they come.
    #[test]
    fn a_stylus_that_is_frozen_on_both_sides_of_gaps_is_reported() {
        let mut check = check();
        let mut t = 0;
        let mut frozen_after = None;
        for i in 0..2000_u32 {
            t += if i % 100 == 99 { 200_000 } else { 100 };
            check.check(&Sample::stylus(Micros(t), if i == 0 { 0.0 } else { 1e-6 }));
            let frozen = check.health() == SensorHealth::Frozen;
            frozen_after = frozen_after.or(frozen.then_some(i));
        }
        // 50 ms of readings.
        assert_eq!(frozen_after, Some(502));
    }

    /// The fast path against every check of every sample: noise with wrong readings, gaps, repeats, glitches and no numbers.
    #[test]
    fn what_passes_is_what_the_checks_give() {
        let (mut fast, mut slow) = (check(), check());
        let (mut state, mut t, mut as_other) = (1_u32, 0, 0);
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) as u16
        };
        for i in 0..20_000_u16 {
            t += if random() % 500 == 0 { 30_000 } else { 100 };
            let x = 1e-9 * f32::from(random() % 64);
            let stylus = match random() % 300 {
                0 => f32::NAN,
                1 => 4e-3,
                2..=5 => x + 1e-6,
                6 => 1e-9,
                _ => x,
            };
            let r = f32::from(random() % 64) + if random() % 100 == 0 { 9e3 } else { 0.0 };
            let sample = Sample {
                stylus_axes: [0.0, if i < 10_000 { 0.0 } else { 1e-9 * f32::from(random() % 64) }],
                reference: Some(r),
                ..Sample::stylus(Micros(t), stylus)
            };
            let shown = match fast.passes(&sample) {
                Passed::Not => fast.check(&sample),
                Passed::AsItIs => Some(sample),
                Passed::As(other) => {
                    as_other += 1;
                    Some(other)
                }
            };
            assert_eq!(shown, slow.check(&sample), "{i}");
            assert_eq!((fast.health(), fast.counters()), (slow.health(), slow.counters()), "{i}");
        }
        let counters = fast.counters();
        assert!(
            counters.isolated > 200 && counters.glitches > 20 && as_other > 200,
            "{counters:?}"
        );
    }

    /// They are replaced, not missing: the sensor works.
    #[test]
    fn isolated_readings_are_counted_beside_the_unusable_ones() {
        let mut check = check();
        for i in 0..1000 {
            let x = 1e-7 * libm::sinf(f32::from(i) * 2.5) + if i == 500 { 1e-5 } else { 0.0 };
            let out = check.check(&at(i, x)).unwrap().stylus;
            assert!(out.abs() < 2e-7, "{i}: {out}");
        }
        let counters = check.counters();
        assert_eq!((counters.isolated, counters.unusable()), (1, 0));
        assert_eq!(check.health(), SensorHealth::Good);
    }
}
