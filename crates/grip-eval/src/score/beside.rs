//! Test beside the pipeline and no part of it: its statistic and its alarms, from each sample and the pipeline that took it.

use super::{esc_test::EscTest, network_test::NetworkTest};
use grip_record::Phase;
use slip_core::{
    Sample,
    detector::{DetectorConfig, SlipDetector},
};
use std::collections::VecDeque;

/// A test beside the pipeline.
#[derive(Clone, Debug)]
pub enum Test {
    /// The scattered energy of the last milliseconds.
    Esc(Box<EscTest>),
    /// A network on the levels of the bands.
    Network(NetworkTest),
    /// Alarms that are known: those that are not over yet, by their begin.
    Own(VecDeque<Phase>),
}

/// Statistic below which an alarm is about to end.
const RELEASE: f32 = 0.25;

/// A test with its alarm, which ends when the statistic has stayed below `RELEASE` for `release_ms`.
#[derive(Clone, Debug)]
pub struct Beside {
    test: Test,
    release_s: f64,
    slips: bool,
    /// When the statistic was last at or above [`RELEASE`] (s).
    last_s: f64,
}

/// How an alarm changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// It begins.
    Begins,
    /// It is over.
    Ends,
}

impl Beside {
    /// A test that releases as `config` has it.
    #[must_use]
    pub fn new(test: Test, config: &DetectorConfig) -> Self {
        let release_s = 1e-3 * f64::from(config.release_ms);
        Self { test, release_s, slips: false, last_s: f64::NEG_INFINITY }
    }

    /// Takes the next sample after the pipeline, whose `detector` gives floor and levels. Gives the statistic, above 1 being a slip,
    /// and what becomes of the alarm.
    pub fn step(&mut self, sample: &Sample, detector: &SlipDetector) -> (f32, Option<Change>) {
        let statistic = match &mut self.test {
            Test::Esc(test) => test.step(sample, detector.noise_rms()),
            Test::Network(test) => test.step(detector),
            Test::Own(alarms) => {
                let begun = alarms.front().is_some_and(|alarm| alarm.begin <= sample.t);
                while alarms.front().is_some_and(|alarm| alarm.end <= sample.t) {
                    alarms.pop_front();
                }
                if begun { 2.0 } else { 0.0 }
            }
        };
        let t = sample.t.as_seconds();
        if statistic >= RELEASE {
            self.last_s = t;
        }
        let change = match self.slips {
            false if statistic > 1.0 => Some(Change::Begins),
            true if t - self.last_s >= self.release_s => Some(Change::Ends),
            _ => None,
        };
        self.slips = change.map_or(self.slips, |change| change == Change::Begins);
        (statistic, change)
    }

    /// Whether its alarm is on.
    #[must_use]
    pub fn slips(&self) -> bool {
        self.slips
    }
}
