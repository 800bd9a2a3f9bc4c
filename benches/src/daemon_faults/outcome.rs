//! What a kind of fault came to: counts, figures, violations.

use super::{gripper::Gripper, judge::Judge};
use serde::Serialize;

/// What one kind of fault came to.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Outcome {
    /// The kind.
    pub name: &'static str,
    /// Faults.
    pub times: u64,
    /// Commands that reached the gripper, all of them checked.
    pub commands: u64,
    /// Recordings that were read or recovered.
    pub recordings: u64,
    /// What was measured, in words.
    pub figures: Vec<String>,
    /// How many promises were broken.
    pub broken: u64,
    /// The first of them, word for word.
    pub violations: Vec<String>,
}

impl Outcome {
    pub(super) fn failed(what: String) -> Self {
        Self { broken: 1, violations: vec![what], ..Self::default() }
    }

    /// Something that must not be.
    pub(super) fn violation(&mut self, what: String) {
        self.broken += 1;
        self.violations.push(what);
    }

    /// A violation, where `kept` is false.
    pub(super) fn require(&mut self, kept: bool, what: impl FnOnce() -> String) {
        if !kept {
            self.violation(what());
        }
    }

    /// What the judge of a gripper has counted.
    pub(super) fn receive(&mut self, gripper: &Gripper) {
        self.violations.extend(gripper.failure());
        self.broken += u64::from(gripper.failure().is_some());
        self.judged(&gripper.bench().judge);
    }

    pub(super) fn judged(&mut self, judge: &Judge) {
        self.commands += judge.commands;
        self.broken += judge.broken;
        self.violations.extend(judge.violations.iter().cloned());
    }

    pub(super) fn figure(&mut self, text: String) {
        self.figures.push(text);
    }

    /// Median and largest of some times.
    pub(super) fn spread(&mut self, what: &str, mut values: Vec<u64>, unit: &str) {
        values.sort_unstable();
        if let (Some(median), Some(most)) = (values.get(values.len() / 2), values.last()) {
            self.figure(format!("{what} median {median} {unit}, max {most} {unit}"));
        }
    }
}
