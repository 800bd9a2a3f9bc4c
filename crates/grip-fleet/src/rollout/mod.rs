//! Grippers, and what each of them reports, in; who gets a new model next, and who gives it back, out. No network and no clock.
//!
//! Everybody is asked whether it would take the model, before anybody has it. Then one gripper first, then some, then all. A stage is over when every one of its grippers has run the model for its time and none has
//! become worse ([`JudgeConfig`]). With the first refusal, the first that is worse and the first that gives no answer the roll-out stops, and everybody
//! who has taken the model gives it back.

mod bursts;
mod counting;
mod judge;

pub use bursts::Bursts;
pub use counting::Counting;
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
    /// A gripper that has answered no question for so long, the first and the last of them, is gone (us).
    pub silence_us: u64,
    /// One that has the model and holds nothing for so long says nothing about it (us).
    pub idle_us: u64,
}

impl Default for RolloutConfig {
    /// A fifth of all, a minute, an hour.
    fn default() -> Self {
        let judge = JudgeConfig::default();
        Self { some: 0.2, judge, silence_us: 60_000_000, idle_us: 3_600_000_000 }
    }
}

/// What a gripper is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Order {
    /// Would you take the new model?
    Check(Member),
    /// Take it.
    Take(Member),
    /// Go back to the one before.
    GiveBack(Member),
}

/// What a gripper says.
#[derive(Clone, Debug, PartialEq)]
pub enum Report {
    /// It would take the model.
    Fit,
    /// The new model is in force; this was counted before it.
    Taken(Counts),
    /// It was refused: hash, schema or self-test, in a sentence.
    Refused(String),
    /// What was counted since it has been in force. Without more time than before it counts nothing.
    Counted(Counts),
    /// It has been watched long enough, and stays.
    Kept,
    /// This model was in force there before the roll-out.
    Had,
    /// It has become worse and has gone back by itself.
    FellBack(Worse),
    /// It has gone back for another reason, in a sentence.
    Left(String),
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
    /// Somebody has gone back for another reason.
    #[error("{member} has gone back to the model before: {reason}")]
    Left {
        /// Who.
        member: Member,
        /// Why.
        reason: String,
    },
    /// Somebody does not answer.
    #[error("{member} has not answered for too long{}", match reason { Some(reason) => format!(": {reason}"), None => String::new() })]
    Gone {
        /// Who.
        member: Member,
        /// What came instead of the last answer.
        reason: Option<String>,
    },
    /// Somebody has the model and holds nothing.
    #[error("{member} has held nothing for too long")]
    Idle {
        /// Who.
        member: Member,
    },
    /// Whoever began it.
    #[error("it was stopped from here")]
    Told,
}

/// Where a roll-out is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Everybody is asked; nobody has the model.
    Checking,
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
    /// It has not been asked anything.
    New,
    /// It was asked whether it would take the model.
    Checked,
    /// It would take the model.
    Waiting,
    /// It was told to take the model.
    Asked,
    /// It runs the model.
    Running(Running),
    Good,
    /// It had the model before, and keeps it.
    Had,
    /// It was told to give it back.
    Returning,
    /// It has the model of before, because it refused, gave back, or was never heard.
    Back,
}

/// A gripper that runs the model.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Running {
    before: Counts,
    /// How long it was watched (s).
    watched_s: f64,
    /// When it held something last, and how long it had held nothing when it answered last (us).
    held_us: u64,
    idle_us: u64,
}

impl Phase {
    const fn is_open_question(&self) -> bool {
        matches!(self, Self::New | Self::Checked)
    }

    const fn is_waiting(&self) -> bool {
        matches!(self, Self::Waiting)
    }

    /// It has got the model by this roll-out, or is getting it.
    const fn is_reached(&self) -> bool {
        matches!(self, Self::Asked | Self::Running(_) | Self::Good)
    }

    const fn is_done(&self) -> bool {
        matches!(self, Self::Good | Self::Had)
    }
}

/// Questions to one gripper without an answer.
#[derive(Clone, Debug)]
struct Silence {
    /// When the first and the last of them ended (us).
    first_us: u64,
    last_us: u64,
    /// What came instead of the last answer.
    reason: Option<String>,
}

/// A roll-out to some grippers.
#[derive(Clone, Debug)]
pub struct Rollout {
    config: RolloutConfig,
    members: BTreeMap<Member, Phase>,
    silent: BTreeMap<Member, Silence>,
    stage: usize,
    stop: Option<Stop>,
}

impl Rollout {
    /// A roll-out that begins with the next [`Rollout::step`].
    pub fn new(config: RolloutConfig, members: impl IntoIterator<Item = Member>) -> Self {
        let members = members.into_iter().map(|member| (member, Phase::New)).collect();
        Self { config, members, silent: BTreeMap::new(), stage: 0, stop: None }
    }

    /// A gripper was asked and has not answered, or with something that is no answer; it is to be asked again.
    pub fn miss(&mut self, member: &Member, reason: Option<String>, now_us: u64) {
        if self.members.contains_key(member) {
            let first_us = self.silent.get(member).map_or(now_us, |silence| silence.first_us);
            self.silent.insert(member.clone(), Silence { first_us, last_us: now_us, reason });
        }
    }

    /// Takes what a gripper says; who is not in this roll-out is not heard.
    pub fn receive(&mut self, member: &Member, report: Report, now_us: u64) {
        let Some(phase) = self.members.get_mut(member) else { return };
        self.silent.remove(member);
        match (report, &*phase) {
            (Report::Fit, Phase::Checked) => *phase = Phase::Waiting,
            (Report::Taken(before), Phase::Asked) => {
                let (watched_s, held_us, idle_us) = (0.0, now_us, 0);
                *phase = Phase::Running(Running { before, watched_s, held_us, idle_us });
            }
            (Report::Had, Phase::Checked | Phase::Asked) => *phase = Phase::Had,
            (Report::Kept, Phase::Asked | Phase::Running(_)) => *phase = Phase::Good,
            (Report::Refused(reason), Phase::Checked | Phase::Asked) => {
                *phase = Phase::Back;
                self.stop(Stop::Refused { member: member.clone(), reason });
            }
            (Report::Counted(now), Phase::Running(running)) => {
                let held_us =
                    if now.seconds > running.watched_s { now_us } else { running.held_us };
                let (watched_s, before) = (now.seconds, running.before);
                let idle_us = now_us.saturating_sub(held_us);
                match self.config.judge.judge(&before, &now) {
                    Judgement::Open => {
                        *phase = Phase::Running(Running { before, watched_s, held_us, idle_us });
                    }
                    Judgement::Good => *phase = Phase::Good,
                    Judgement::Idle => {
                        let reason = "nothing was grasped with it".to_owned();
                        self.stop(Stop::Left { member: member.clone(), reason });
                    }
                    Judgement::Worse(what) => {
                        self.stop(Stop::Worse { member: member.clone(), what });
                    }
                }
            }
            (Report::FellBack(what), Phase::Running(_) | Phase::Good | Phase::Returning) => {
                *phase = Phase::Back;
                self.stop(Stop::Worse { member: member.clone(), what });
            }
            (Report::Left(reason), Phase::Asked | Phase::Running(_) | Phase::Good) => {
                *phase = Phase::Back;
                self.stop(Stop::Left { member: member.clone(), reason });
            }
            (Report::Back | Report::Left(_), Phase::Returning) => *phase = Phase::Back,
            _ => {}
        }
    }

    /// What is to be told to whom, by what was heard until now.
    pub fn step(&mut self) -> Vec<Order> {
        self.look();
        // Where somebody refuses it, all the others are still heard, so that all reasons are told at once.
        if self.is_checking() {
            return self.check();
        }
        if self.stop.is_some() {
            return self.give_back();
        }
        let (reached, waiting) = (self.count(Phase::is_reached), self.count(Phase::is_waiting));
        let open = self.members.values().any(|phase| phase.is_reached() && !phase.is_done());
        if open || waiting == 0 {
            return Vec::new();
        }
        // Where the first one to try it had it already, another one is the first.
        self.stage = if reached == 0 { 1 } else { self.stage + 1 };
        let more = self.goal(reached + waiting).saturating_sub(reached).max(1);
        let stage = self.members.iter_mut().filter(|(_, phase)| phase.is_waiting()).take(more);
        stage
            .map(|(member, phase)| {
                *phase = Phase::Asked;
                Order::Take(member.clone())
            })
            .collect()
    }

    /// Whether somebody has not said yet whether it would take the model.
    fn is_checking(&self) -> bool {
        self.members.values().any(Phase::is_open_question)
    }

    fn count(&self, is: impl Fn(&Phase) -> bool) -> usize {
        self.members.values().filter(|phase| is(phase)).count()
    }

    fn check(&mut self) -> Vec<Order> {
        let new = self.members.iter_mut().filter(|(_, phase)| **phase == Phase::New);
        new.map(|(member, phase)| {
            *phase = Phase::Checked;
            Order::Check(member.clone())
        })
        .collect()
    }

    /// Which stage it is in or was in; 0 before the first.
    #[must_use]
    pub const fn stage(&self) -> usize {
        self.stage
    }

    /// Where it is.
    #[must_use]
    pub fn progress(&self) -> Progress {
        if self.is_checking() {
            Progress::Checking
        } else if self.stop.is_some() {
            Progress::Stopped(self.holding().count())
        } else if self.members.values().all(Phase::is_done) {
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

    /// Who has been told to take the model, or may have it by this roll-out, and has not given it back.
    pub fn holding(&self) -> impl Iterator<Item = &Member> {
        let holding = |phase: &Phase| {
            use Phase::{Asked, Good, Returning, Running};
            matches!(phase, Asked | Running(_) | Good | Returning)
        };
        self.members.iter().filter(move |(_, phase)| holding(phase)).map(|(member, _)| member)
    }

    /// Who is still to be heard of: who has been told something, or runs the model.
    #[must_use]
    pub fn is_open(&self, member: &Member) -> bool {
        let open = |phase: &Phase| matches!(phase, Phase::Running(_) | Phase::Good);
        self.members.get(member).is_some_and(open)
    }

    /// Stops it; the next step asks for the model back.
    pub fn abort(&mut self) {
        let ignored = self.members.values_mut().filter(|phase| phase.is_open_question());
        ignored.for_each(|phase| *phase = Phase::Back);
        self.stop(Stop::Told);
    }

    /// How many have got the model, of all who did not have it before, when the stage is over.
    fn goal(&self, all: usize) -> usize {
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

    /// Who has been silent, or idle, for too long.
    fn look(&mut self) {
        let RolloutConfig { silence_us, idle_us, .. } = self.config;
        let late = |silence: &&Silence| silence.last_us - silence.first_us > silence_us;
        let mut why = None;
        for (member, phase) in &mut self.members {
            let stop = match (&*phase, self.silent.get(member).filter(late)) {
                (Phase::Checked | Phase::Asked | Phase::Running(_), Some(silence)) => {
                    Stop::Gone { member: member.clone(), reason: silence.reason.clone() }
                }
                (Phase::Running(running), None) if running.idle_us > idle_us => {
                    Stop::Idle { member: member.clone() }
                }
                _ => continue,
            };
            if *phase == Phase::Checked {
                *phase = Phase::Back;
            }
            why.get_or_insert(stop);
        }
        if let Some(stop) = why {
            self.stop(stop);
        }
    }

    /// Everybody who has the model, or may have it.
    fn give_back(&mut self) -> Vec<Order> {
        let all = self.members.iter_mut().filter(|(_, phase)| phase.is_reached());
        all.map(|(member, phase)| {
            *phase = Phase::Returning;
            Order::GiveBack(member.clone())
        })
        .collect()
    }
}

#[cfg(test)]
mod tests;
