//! Grippers, and what each of them reports, in; who gets a new model next, and who gives it back, out. No network and no clock.
//!
//! One gripper first, then some, then all. A stage is over when every one of its grippers has run the model for its time and none has
//! become worse ([`JudgeConfig`]). With the first refusal, the first that is worse and the first that is gone the roll-out stops, and everybody who has
//! taken the model gives it back.

mod judge;

pub use judge::{Counts, JudgeConfig, Judgement, Worse};

use crate::key::Member;
use std::collections::BTreeMap;

/// How a roll-out goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RolloutConfig {
    /// Share of all grippers in the second stage, 0 to 1; one at least.
    pub some: f64,
    /// When a model is worse.
    pub judge: JudgeConfig,
    /// A gripper that has not answered for so long is gone (us).
    pub silence_us: u64,
}

impl Default for RolloutConfig {
    /// A fifth of all, a minute.
    fn default() -> Self {
        Self { some: 0.2, judge: JudgeConfig::default(), silence_us: 60_000_000 }
    }
}

/// What a gripper is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Order {
    /// Take the new model.
    Take(Member),
    /// Go back to the one before.
    GiveBack(Member),
}

/// What a gripper says.
#[derive(Clone, Debug, PartialEq)]
pub enum Report {
    /// The new model is in force; this was counted before it.
    Taken(Counts),
    /// It was refused: hash, schema or self-test, in a sentence.
    Refused(String),
    /// What was counted since it has been in force.
    Counted(Counts),
    /// It has become worse and has gone back by itself.
    FellBack(Worse),
    /// The one before is in force again, as it was told.
    Back,
}

/// Why a roll-out has stopped.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Stop {
    /// Somebody refused the model.
    #[error("{member} refused the model: {reason}")]
    Refused {
        /// Who.
        member: Member,
        /// Why.
        reason: String,
    },
    /// Somebody has become worse.
    #[error("{member} has more {} with the new model", match what { Worse::Slips => "slips", Worse::Faults => "faults" })]
    Worse {
        /// Who.
        member: Member,
        /// In what.
        what: Worse,
    },
    /// Somebody does not answer.
    #[error("{member} does not answer")]
    Gone {
        /// Who.
        member: Member,
    },
}

/// Where a roll-out is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Progress {
    /// In this stage, from 1.
    Stage(usize),
    /// Everybody has the model.
    Done,
    /// It was stopped; so many have not given the model back yet.
    Stopped(usize),
}

/// One gripper in the roll-out.
#[derive(Clone, Debug, PartialEq)]
enum Phase {
    Waiting,
    /// It was told to take the model, and when (us).
    Asked(u64),
    /// It runs the model: counts before, and when it was heard last (us).
    Running(Counts, u64),
    Good,
    /// It was told to give it back.
    Returning,
    /// It has the model of before, because it refused or gave back.
    Back,
}

/// A roll-out to some grippers.
#[derive(Clone, Debug)]
pub struct Rollout {
    config: RolloutConfig,
    members: BTreeMap<Member, Phase>,
    /// How many, in their order, have got the model or are getting it.
    reached: usize,
    stage: usize,
    stop: Option<Stop>,
}

impl Rollout {
    /// A roll-out that begins with the next [`Rollout::step`].
    pub fn new(config: RolloutConfig, members: impl IntoIterator<Item = Member>) -> Self {
        let members = members.into_iter().map(|member| (member, Phase::Waiting)).collect();
        Self { config, members, reached: 0, stage: 0, stop: None }
    }

    /// Takes what a gripper says; who is not in this roll-out is not heard.
    pub fn hear(&mut self, member: &Member, report: Report, now_us: u64) {
        let Some(phase) = self.members.get_mut(member) else { return };
        match (report, &*phase) {
            (Report::Taken(before), Phase::Asked(_)) => *phase = Phase::Running(before, now_us),
            (Report::Refused(reason), Phase::Asked(_)) => {
                *phase = Phase::Back;
                self.stop(Stop::Refused { member: member.clone(), reason });
            }
            (Report::Counted(now), Phase::Running(before, _)) => {
                let before = *before;
                match self.config.judge.judge(&before, &now) {
                    Judgement::Open => *phase = Phase::Running(before, now_us),
                    Judgement::Good => *phase = Phase::Good,
                    Judgement::Worse(what) => {
                        self.stop(Stop::Worse { member: member.clone(), what });
                    }
                }
            }
            (Report::FellBack(what), Phase::Running(..) | Phase::Good | Phase::Returning) => {
                *phase = Phase::Back;
                self.stop(Stop::Worse { member: member.clone(), what });
            }
            (Report::Back, Phase::Returning) => *phase = Phase::Back,
            _ => {}
        }
    }

    /// Time has passed: what is to be told to whom.
    pub fn step(&mut self, now_us: u64) -> Vec<Order> {
        self.miss(now_us);
        if self.stop.is_some() {
            return self.give_back();
        }
        let open = self.members.values().take(self.reached).any(|phase| *phase != Phase::Good);
        if open || self.reached == self.members.len() {
            return Vec::new();
        }
        self.stage += 1;
        let from = self.reached;
        self.reached = self.goal().clamp(from + 1, self.members.len());
        let stage = self.members.iter_mut().take(self.reached).skip(from);
        stage
            .map(|(member, phase)| {
                *phase = Phase::Asked(now_us);
                Order::Take(member.clone())
            })
            .collect()
    }

    /// Where it is.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let holding = |phase: &&Phase| !matches!(phase, Phase::Waiting | Phase::Back);
        if self.stop.is_some() {
            Progress::Stopped(self.members.values().filter(holding).count())
        } else if self.members.values().all(|phase| *phase == Phase::Good) {
            Progress::Done
        } else {
            Progress::Stage(self.stage.max(1))
        }
    }

    /// Why it was stopped.
    #[must_use]
    pub const fn stopped(&self) -> Option<&Stop> {
        self.stop.as_ref()
    }

    /// How many have the model when the stage is over.
    fn goal(&self) -> usize {
        let all = self.members.len();
        match self.stage {
            1 => 1,
            2 => self.share(all) + 1,
            _ => all,
        }
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "a share of a small count; the cast saturates"
    )]
    fn share(&self, all: usize) -> usize {
        (self.config.some.clamp(0.0, 1.0) * all as f64).ceil() as usize
    }

    /// The first reason counts.
    fn stop(&mut self, reason: Stop) {
        self.stop.get_or_insert(reason);
    }

    /// Who has been silent for too long.
    fn miss(&mut self, now_us: u64) {
        let silence_us = self.config.silence_us;
        let late = |since: u64| now_us.saturating_sub(since) > silence_us;
        let gone = self.members.iter().find(|(_, phase)| match phase {
            Phase::Asked(since) | Phase::Running(_, since) => late(*since),
            _ => false,
        });
        if let Some(member) = gone.map(|(member, _)| member.clone()) {
            self.stop(Stop::Gone { member });
        }
    }

    /// Everybody who has the model, or may have it.
    fn give_back(&mut self) -> Vec<Order> {
        let taken =
            |phase: &Phase| matches!(phase, Phase::Asked(_) | Phase::Running(..) | Phase::Good);
        let all = self.members.iter_mut().filter(|(_, phase)| taken(phase));
        all.map(|(member, phase)| {
            *phase = Phase::Returning;
            Order::GiveBack(member.clone())
        })
        .collect()
    }
}

#[cfg(test)]
mod tests;
