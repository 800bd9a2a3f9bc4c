//! Alarms and the time without slip in, both by cause out.

use super::interval::{self, Interval};
use grip_record::Phase;
use serde::Serialize;
use slip_core::units::Micros;
use std::collections::BTreeMap;

/// Cause of an alarm while the pipeline took the robot to move, where no phase names another ...
pub const MOVING: &str = "moving";
/// ... and while it did not.
pub const STILL: &str = "still";
/// Cause while the grip force of an array has not stood for long enough, so that no pattern is judged.
pub const CLOSING: &str = "closing";

/// The first notice of a slip.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Alarm {
    /// When it came (s).
    pub t_s: f64,
    /// When the slip was over (s); `null` where the recording ended before.
    pub end_s: Option<f64>,
    /// What went on: the phase that was named, or [`CLOSING`], [`MOVING`] or [`STILL`].
    pub cause: String,
    /// Whether it lies where no slip is labelled.
    pub is_false: bool,
}

/// The alarms of one cause in time without slip.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename = "cause")]
pub struct CauseScore {
    /// The detector.
    pub detector: &'static str,
    /// The cause.
    pub cause: String,
    /// Time without slip in which this went on (s).
    pub seconds: f64,
    /// Alarms in it.
    pub alarms: u32,
    /// Interval of their rate (1/h).
    pub per_hour_ci: Interval,
}

/// Seconds and false alarms of each cause.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Causes(BTreeMap<String, (f64, u32)>);

impl Causes {
    /// The cause at `t` in a recording with these `phases`: what was `seen`, where none is named.
    pub(super) fn at<'a>(phases: &'a [Phase], t: Micros, seen: &'a str) -> &'a str {
        let named = phases.iter().find(|phase| (phase.begin..phase.end).contains(&t));
        named.map_or(seen, |phase| phase.cause.as_str())
    }

    /// Time in which the cause went on and nothing slipped.
    pub(super) fn add_time(&mut self, cause: &str, seconds: f64) {
        self.entry(cause).0 += seconds;
    }

    pub(super) fn add_alarm(&mut self, cause: &str) {
        self.entry(cause).1 += 1;
    }

    pub(super) fn add(&mut self, other: &Self) {
        for (cause, (seconds, alarms)) in &other.0 {
            let sum = self.entry(cause);
            *sum = (sum.0 + seconds, sum.1 + alarms);
        }
    }

    fn entry(&mut self, cause: &str) -> &mut (f64, u32) {
        self.0.entry(cause.to_owned()).or_default()
    }

    /// One row a cause, by name.
    pub(super) fn rows(&self, detector: &'static str) -> Vec<CauseScore> {
        let row = |(cause, &(seconds, alarms)): (&String, &(f64, u32))| CauseScore {
            detector,
            cause: cause.clone(),
            seconds,
            alarms,
            per_hour_ci: interval::rate(alarms, seconds / 3600.0),
        };
        self.0.iter().map(row).collect()
    }
}
