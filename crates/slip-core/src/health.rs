//! Check of raw samples: samples that are safe to compute with, and a verdict on the sensor.
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
    /// Normal forces that no finger of this gripper meets ([`FORCE_MOST`]), taken as absent: another unit than N.
    pub forces: u64,
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
        let stylus = self.not_finite + self.saturated + self.glitches;
        stylus + self.forces + self.other_channels + self.time_faults
    }
}

/// Largest force (N), travel and speed (m, m/s) and reading of any other channel (own units) that can be meant.
const FORCE_LIMIT_N: f32 = 1e4;
/// A normal force of so many times the largest that is ever commanded is in mN or in counts: the controller would follow it.
pub const FORCE_MOST: f32 = 5.0;
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
    /// Largest normal force that can be meant (N).
    most_n: f32,
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
            most_n: FORCE_LIMIT_N,
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

    /// The same for a gripper that is never commanded more than `f_max_n` (N).
    #[must_use]
    pub fn of_gripper(self, f_max_n: f32) -> Self {
        Self { most_n: FORCE_LIMIT_N.min(FORCE_MOST * f_max_n), ..self }
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

    /// Takes whether an object slips: then no reading counts as isolated.
    #[inline]
    pub fn set_slips(&mut self, slips: bool) {
        self.guard.set_open(slips);
        self.reference_guard.set_open(slips);
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

    /// Whether no channel beside the stylus has an unusable reading, or a force far below zero: [`HealthCheck::check`] takes that.
    #[inline]
    fn others_pass(&self, sample: &Sample) -> bool {
        let within = |value: Option<f32>, limit: f32| value.is_none_or(|v| v.abs() <= limit);
        within(sample.normal_force_n, self.most_n)
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
            normal_force_n: self.force(sample.normal_force_n),
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

    /// The reading, or what stands in for it. An axis without a number keeps its last value for some readings while another one has a number. From
    /// there on, and beyond the range, a vector is a bad reading as a whole: the floor holds for all axes.
    #[inline]
    fn stylus(&mut self, sample: &Sample, after_gap: bool) -> Vector {
        let held = self.guard.last();
        let mut x = sample.vibration();
        let broken = self.guard.has_started()
            && self.bad_run + 1 < self.config.max_bad_run
            && x.iter().any(|axis| !axis.is_finite())
            && x.iter().any(|axis| axis.is_finite() && *axis != 0.0);
        if broken {
            self.counters.not_finite += 1;
            x = core::array::from_fn(|i| if x[i].is_finite() { x[i] } else { held[i] });
        }
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
        self.bad_run = if broken { self.bad_run + 1 } else { 0 };
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

    /// What is below zero is no unit but a tare, and stays: it shows that nothing is touched.
    #[inline]
    fn force(&mut self, force_n: Option<f32>) -> Option<f32> {
        let force_n = self.other(force_n, FORCE_LIMIT_N)?;
        let meant = force_n <= self.most_n;
        self.counters.forces += u64::from(!meant);
        meant.then_some(force_n)
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
#[must_use]
pub fn gap(rate: Hertz) -> Micros {
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
mod tests;
