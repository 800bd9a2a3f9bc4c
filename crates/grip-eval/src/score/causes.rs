//! Breakdown of alarms and of the time without slip by cause.

use super::interval::{self, Interval};
use grip_record::Phase;
use serde::Serialize;
use slip_core::units::Micros;
use std::collections::BTreeMap;

/// Cause of an alarm while the pipeline took the robot to move, where no phase names another ...
pub const MOVING: &str = "moving";
/// ... and while it did not.
pub const STILL: &str = "still";
/// Cause where neither a reference nor a column `motion` shows whether the robot moved.
pub const UNKNOWN: &str = "motion not known";
/// Cause while the grip force of an array has not stood for long enough, so that no pattern is judged.
pub const CLOSING: &str = "closing";

/// The first notice of a slip.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Alarm {
    /// When it came (s).
    pub t_s: f64,
    /// When the slip was over (s); `null` where the recording ended before.
    pub end_s: Option<f64>,
    /// What went on: the phase that was named, or [`CLOSING`], [`MOVING`], [`STILL`] or [`UNKNOWN`].
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
    /// Of it in alarm (s).
    pub in_alarm_s: f64,
    /// Alarms in it.
    pub alarms: u32,
    /// Interval of their rate (1/h).
    pub per_hour_ci: Interval,
}

/// What there was of one cause.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Count {
    seconds: f64,
    in_alarm_s: f64,
    alarms: u32,
}

/// Seconds and false alarms of each cause.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Causes(BTreeMap<String, Count>);

impl Causes {
    /// The cause at `t` in a recording with these `phases`: what was `seen`, where none is named.
    pub(super) fn at<'a>(phases: &'a [Phase], t: Micros, seen: &'a str) -> &'a str {
        let named = phases.iter().find(|phase| (phase.begin..phase.end).contains(&t));
        named.map_or(seen, |phase| phase.cause.as_str())
    }

    /// Time in which the cause went on and nothing slipped, and of it in alarm.
    pub(super) fn add_time(&mut self, cause: &str, seconds: f64, in_alarm_s: f64) {
        let count = self.entry(cause);
        count.seconds += seconds;
        count.in_alarm_s += in_alarm_s;
    }

    pub(super) fn add_alarm(&mut self, cause: &str) {
        self.entry(cause).alarms += 1;
    }

    pub(super) fn add(&mut self, other: &Self) {
        for (cause, count) in &other.0 {
            self.add_time(cause, count.seconds, count.in_alarm_s);
            self.entry(cause).alarms += count.alarms;
        }
    }

    /// Whether alarms distinguish slip from rest: there was rest, and most of it was without one.
    pub(super) fn distinguishes(&self) -> bool {
        let sum = |of: fn(&Count) -> f64| self.0.values().map(of).sum::<f64>();
        let (seconds, in_alarm_s) = (sum(|count| count.seconds), sum(|count| count.in_alarm_s));
        seconds > 0.0 && in_alarm_s <= 0.5 * seconds
    }

    fn entry(&mut self, cause: &str) -> &mut Count {
        self.0.entry(cause.to_owned()).or_default()
    }

    /// One row a cause, by name.
    pub(super) fn rows(&self, detector: &'static str) -> Vec<CauseScore> {
        let row = |(cause, &Count { seconds, in_alarm_s, alarms }): (&String, &Count)| CauseScore {
            detector,
            cause: cause.clone(),
            seconds,
            in_alarm_s,
            alarms,
            per_hour_ci: interval::rate(alarms, seconds / 3600.0),
        };
        self.0.iter().map(row).collect()
    }
}
