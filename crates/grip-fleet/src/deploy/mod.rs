//! Orders to take a model or to give it back, and counts of slips and faults, in; which model has to be in force out. No network, no thread, no disk
//! and no clock.
//!
//! A model that is taken is on trial: it stays when it has been watched long enough, and has to go when slips or faults become more
//! ([`JudgeConfig`]). [`Lasting`] is what survives an end of the daemon: it names a model on trial, but a daemon that starts is on no trial. So
//! whatever ends the daemon, or the connection to it, also ends the trial, with the model of before in force.

mod examine;
mod models;
mod order;
mod shelf;
mod standing;

pub use examine::{Examined, Fault, MOST_BYTES, digest, examine, hex};
pub use models::{Models, Notice, OrderFault, Swap};
pub use order::{Offer, Order, OrderError};
pub use shelf::{Shelf, ShelfError};
pub use standing::{Ended, How, Lasting, ModelId, Standing, TrialReport};

use crate::rollout::{Counts, JudgeConfig, Judgement};

/// Why a model is not taken.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Declined {
    /// One at a time.
    #[error("{0} is on trial here")]
    OnTrial(ModelId),
    /// There is nothing to compare with.
    #[error(
        "there are only {counted_s} s with an object to compare with, and the trial wants {watch_s} s; ask again later, or for a shorter one"
    )]
    TooEarly {
        /// Time that was counted with the model in force (s).
        counted_s: u64,
        /// Time that is wanted (s).
        watch_s: u64,
    },
    /// The judge cannot be one.
    #[error(
        "watch, factor or alpha make no sense: 1 to 2592000 s, 1 to 100 and 1e-9 to 0.5 are possible"
    )]
    Judge,
}

/// What has to be done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// Nothing.
    Stay,
    /// This model has to be put in force; none stands for that of the configuration.
    Swap(Option<ModelId>),
}

/// A model on trial.
#[derive(Clone, Debug, PartialEq)]
struct Trial {
    model: ModelId,
    judge: JudgeConfig,
    before: Counts,
}

/// The models of one gripper.
#[derive(Clone, Debug)]
pub struct Deployment {
    /// What the configuration names.
    configured: ModelId,
    lasting: Lasting,
    trial: Option<Trial>,
    /// All counts of this run, and those when the model in force came.
    total: Counts,
    since: Counts,
    /// What was counted with it before that; and with the one that comes back next.
    earlier: Counts,
    resumed: Counts,
}

impl Deployment {
    /// Begins with what an earlier run has left: a trial that it was on has ended.
    #[must_use]
    pub fn new(configured: ModelId, lasting: Lasting) -> Self {
        let mut new = Self {
            configured,
            lasting,
            trial: None,
            total: Counts::default(),
            since: Counts::default(),
            earlier: Counts::default(),
            resumed: Counts::default(),
        };
        if let Some(model) = new.lasting.trial.take() {
            new.lasting.last = Some(Ended { model, how: How::Restarted });
        }
        new
    }

    /// The model that has to be in force; none stands for that of the configuration.
    #[must_use]
    pub fn wanted(&self) -> Option<&ModelId> {
        self.trial.as_ref().map(|trial| &trial.model).or(self.lasting.accepted.as_ref())
    }

    /// What has to be on the disk.
    #[must_use]
    pub const fn lasting(&self) -> &Lasting {
        &self.lasting
    }

    /// Whether a model that has passed its examination would be taken; `false` where it is in force already.
    ///
    /// # Errors
    /// [`Declined`].
    pub fn check(&self, model: &ModelId, judge: &JudgeConfig) -> Result<bool, Declined> {
        if !judge.is_sane() {
            return Err(Declined::Judge);
        }
        if self.in_force().sha256 == model.sha256 {
            return Ok(false);
        }
        if let Some(trial) = &self.trial {
            return Err(Declined::OnTrial(trial.model.clone()));
        }
        let before = self.counted();
        if before.seconds < judge.watch_s {
            let (counted_s, watch_s) = (whole(before.seconds), whole(judge.watch_s));
            return Err(Declined::TooEarly { counted_s, watch_s });
        }
        Ok(true)
    }

    /// An order to take a model that has passed its examination. Where a step follows, the model is on trial.
    ///
    /// # Errors
    /// [`Declined`]; nothing has changed.
    pub fn take(&mut self, model: ModelId, judge: JudgeConfig) -> Result<Step, Declined> {
        if !self.check(&model, &judge)? {
            return Ok(Step::Stay);
        }
        let before = self.counted();
        self.lasting.trial = Some(model.clone());
        self.trial = Some(Trial { model: model.clone(), judge, before });
        Ok(Step::Swap(Some(model)))
    }

    /// The model on trial could not be put in force.
    pub fn failed(&mut self) {
        self.end(How::Failed);
    }

    /// The model that is wanted is in force since these counts of this run. One that was given up for a trial goes on where its counts were.
    pub fn swapped(&mut self, total: Counts) {
        (self.total, self.since) = (total, total);
        self.earlier = core::mem::take(&mut self.resumed);
    }

    /// An order to give this model back, or the one in force, whatever was counted with it. Of one that is not in force there is nothing to give back.
    pub fn back(&mut self, sha256: Option<&str>) -> Step {
        let is_meant = |model: &ModelId| sha256.is_none_or(|sha256| model.sha256 == sha256);
        if self.trial.as_ref().is_some_and(|trial| is_meant(&trial.model)) {
            return self.end(How::Told);
        }
        match self.lasting.accepted.take_if(|model| is_meant(model)) {
            Some(model) => {
                self.lasting.accepted = self.lasting.before.take();
                self.lasting.last = Some(Ended { model, how: How::Told });
                Step::Swap(self.lasting.accepted.clone())
            }
            None => Step::Stay,
        }
    }

    /// All counts of this run as of now.
    pub fn count(&mut self, total: Counts) -> Step {
        self.total = total;
        let now = self.counted();
        let judged = self.trial.as_ref().map(|trial| trial.judge.judge(&trial.before, &now));
        match judged {
            None | Some(Judgement::Open) => Step::Stay,
            Some(Judgement::Worse(worse)) => self.end(How::Worse(worse)),
            Some(Judgement::Idle) => self.end(How::Idle),
            Some(Judgement::Good) => {
                self.keep();
                Step::Stay
            }
        }
    }

    /// Other settings are in force, with the model named where none was taken over the network. What was counted with the old ones is no
    /// comparison any more.
    pub fn reloaded(&mut self, configured: ModelId) -> Step {
        self.configured = configured;
        (self.since, self.earlier) = (self.total, Counts::default());
        if self.trial.is_some() { self.end(How::Reloaded) } else { Step::Stay }
    }

    /// How it stands.
    #[must_use]
    pub fn standing(&self) -> Standing {
        let configured = || self.configured.clone();
        let before = match (&self.trial, &self.lasting.accepted) {
            (Some(_), accepted) => Some(accepted.clone().unwrap_or_else(configured)),
            (None, Some(_)) => Some(self.lasting.before.clone().unwrap_or_else(configured)),
            (None, None) => None,
        };
        let trial = self
            .trial
            .as_ref()
            .map(|trial| TrialReport { watch_s: trial.judge.watch_s, before: trial.before });
        let (in_force, last) = (self.in_force().clone(), self.lasting.last.clone());
        Standing { in_force, before, trial, counted: self.counted(), last }
    }

    fn in_force(&self) -> &ModelId {
        self.wanted().unwrap_or(&self.configured)
    }

    /// What was counted with the model in force.
    fn counted(&self) -> Counts {
        let (now, earlier) = (self.total.since(&self.since), &self.earlier);
        Counts {
            seconds: now.seconds + earlier.seconds,
            slips: now.slips + earlier.slips,
            faults: now.faults + earlier.faults,
            grasps: now.grasps + earlier.grasps,
        }
    }

    /// The model on trial goes.
    fn end(&mut self, how: How) -> Step {
        let Some(Trial { model, before, .. }) = self.trial.take() else { return Step::Stay };
        self.resumed = match how {
            How::Worse(_) | How::Idle | How::Told => before,
            _ => Counts::default(),
        };
        self.lasting.trial = None;
        self.lasting.last = Some(Ended { model, how });
        Step::Swap(self.lasting.accepted.clone())
    }

    /// The model on trial stays.
    fn keep(&mut self) {
        let Some(Trial { model, .. }) = self.trial.take() else { return };
        self.lasting.trial = None;
        self.lasting.before = self.lasting.accepted.replace(model.clone());
        self.lasting.last = Some(Ended { model, how: How::Accepted });
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a time, for people; the cast saturates"
)]
const fn whole(seconds: f64) -> u64 {
    seconds as u64
}

#[cfg(test)]
mod tests;
