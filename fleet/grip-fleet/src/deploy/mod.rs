//! Rules for which model has to be in force, by orders to take a model or to give it back, and grasps. No network, no thread, no disk and no clock.
//!
//! A model that is taken is on trial, for as long as somebody watches it: it stays with an order to accept it, and goes where no order to watch
//! it came for the time of its lease. [`Lasting`] is what survives an end of the daemon: it names a model on trial, but a daemon that starts is
//! on no trial. So whatever ends the daemon, the connection to it or the program of the operator also ends the trial, with the model of before
//! in force. The model of the configuration, and the one before, need no trial.

mod examine;
mod history;
mod models;
mod order;
mod rehearsal;
mod shelf;
mod standing;

pub use examine::{Examined, MOST_BYTES, digest, examine, hex};
pub use history::{Entry, Origin, Paused};
pub use models::{Models, Notice, Put, Swap};
pub use order::{Offer, Order};
pub use rehearsal::rehearse;
pub use standing::{Ended, How, ModelId, ReplayReport, ShadowReport, Standing, TrialReport};

use crate::rollout::{Finished, Grasp, Rehearsal};
use grip_link::message::FaultCode;
use grip_session::exit::message;
use history::History;
use shelf::Shelf;
use standing::Lasting;

/// Grasps that are kept of each model, the latest ones; of a model on trial the first.
const MOST_GRASPS: usize = 1000;

/// Why a model or an order is refused, in a sentence for whoever sent it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Refused(pub(crate) String);

/// The same of what something else says against it.
fn refused(error: &(dyn core::error::Error + 'static)) -> Refused {
    Refused(message(error))
}

/// What has to be done.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Step {
    /// Nothing.
    Stay,
    /// This model has to be put in force; none stands for that of the configuration.
    Swap(Option<ModelId>),
}

/// A model that somebody watches: on trial, or beside the one in force.
#[derive(Clone, Debug, PartialEq)]
struct Watched {
    model: ModelId,
    /// Grasps with the model before the trial, or those in which both were asked.
    grasps: Vec<Grasp>,
    /// Of a shadow: grasps of higher numbers are its own.
    since: u64,
    lease_s: u32,
    /// When it was watched last (us).
    watched_us: u64,
}

impl Watched {
    /// Whether nobody has watched it for its lease.
    fn is_left(&self, now_us: u64) -> bool {
        now_us.saturating_sub(self.watched_us) > 1_000_000 * u64::from(self.lease_s)
    }
}

/// The models of one gripper.
#[derive(Clone, Debug)]
struct Deployment {
    /// What the configuration names.
    configured: ModelId,
    lasting: Lasting,
    trial: Option<Watched>,
    shadow: Option<Watched>,
    fault: FaultCode,
    /// Grasps of models on trial, or beside the one in force, do not count.
    is_paused: bool,
    /// Grasps of higher numbers are those of the model in force.
    since: u64,
    /// Grasps with the model in force, and with the one that comes back next.
    grasps: Vec<Grasp>,
    resumed: Vec<Grasp>,
}

impl Deployment {
    /// Begins with what an earlier run has left: a trial that it was on has ended.
    fn new(configured: ModelId, lasting: Lasting) -> Self {
        let mut new = Self {
            configured,
            lasting,
            trial: None,
            shadow: None,
            fault: FaultCode::NONE,
            is_paused: false,
            since: 0,
            grasps: Vec::new(),
            resumed: Vec::new(),
        };
        if let Some(model) = new.lasting.trial.take() {
            new.lasting.last = Some(Ended { model, how: How::Restarted });
        }
        new
    }

    /// Lets grasps of models on trial, or beside the one in force, count or not.
    const fn pause(&mut self, is_paused: bool) {
        self.is_paused = is_paused;
    }

    /// Whether an order to take or to try this model waits until roll-outs go on here. The way back does not.
    fn waits(&self, model: &ModelId) -> bool {
        self.is_paused && self.in_force().sha256 != model.sha256 && !self.is_known(model)
    }

    /// The model that has to be in force; none stands for that of the configuration.
    fn wanted(&self) -> Option<&ModelId> {
        self.trial.as_ref().map(|trial| &trial.model).or(self.lasting.accepted.as_ref())
    }

    /// What has to be on the disk.
    const fn lasting(&self) -> &Lasting {
        &self.lasting
    }

    /// Whether a model that has passed its examination would be taken; `false` where it is in force already.
    fn check(&self, model: &ModelId, lease_s: u32) -> Result<bool, Refused> {
        if self.in_force().sha256 == model.sha256 {
            return Ok(false);
        }
        if !(1..=86_400).contains(&lease_s) {
            return Err(Refused(format!("lease={lease_s}: 1 to 86400 s are possible")));
        }
        if let Some(trial) = &self.trial {
            return Err(Refused(format!("{} is on trial here", trial.model)));
        }
        if self.fault.is_fault() && !self.is_known(model) {
            let fault = self.fault.0;
            return Err(Refused(format!(
                "this gripper has latched fault {fault:04x}, and nothing can be tried on it"
            )));
        }
        Ok(true)
    }

    /// Whether it is the model of the configuration, or the one before.
    fn is_known(&self, model: &ModelId) -> bool {
        let before = self.lasting.before.as_ref();
        model.sha256 == self.configured.sha256
            || before.is_some_and(|known| known.sha256 == model.sha256)
    }

    /// An order to take a model that has passed its examination. Where a step follows, the model is on trial, unless it is that of the
    /// configuration or the one before: these are in force again without a trial.
    fn take(&mut self, model: ModelId, lease_s: u32, now_us: u64) -> Result<Step, Refused> {
        if !self.check(&model, lease_s)? {
            self.renew(&model.sha256, now_us);
            return Ok(Step::Stay);
        }
        if model.sha256 == self.configured.sha256 {
            self.lasting.before = None;
        }
        if self.is_known(&model) {
            return Ok(self.back(None));
        }
        let (grasps, since) = (self.grasps.clone(), 0);
        self.lasting.trial = Some(model.clone());
        let trial = Watched { model: model.clone(), grasps, since, lease_s, watched_us: now_us };
        self.trial = Some(trial);
        Ok(Step::Swap(Some(model)))
    }

    /// Whether a model that has passed its examination is to estimate beside the one in force; `false` where it does so already, or is in force.
    fn check_shadow(&self, model: &ModelId, lease_s: u32) -> Result<bool, Refused> {
        let known = self.shadow.as_ref().is_some_and(|shadow| shadow.model == *model);
        Ok(self.check(model, lease_s)? && !known)
    }

    /// The model estimates beside the one in force; grasps of higher numbers than this are its own.
    fn cast(&mut self, model: ModelId, lease_s: u32, since: u64, now_us: u64) {
        let (watched_us, grasps) = (now_us, Vec::new());
        self.shadow = Some(Watched { model, grasps, since, lease_s, watched_us });
    }

    /// The shadow has to go: another model takes over, or nobody watches it any more. The one that was there, and in how many grasps it was asked.
    fn end_shadow(&mut self) -> Option<(ModelId, usize)> {
        self.shadow.take().map(|shadow| (shadow.model, shadow.grasps.len()))
    }

    /// Whether this model estimates beside the one in force.
    fn is_shadow(&self, sha256: &str) -> bool {
        self.shadow.as_ref().is_some_and(|shadow| shadow.model.sha256 == sha256)
    }

    /// Whether nobody watches the shadow any more.
    fn is_shadow_left(&self, now_us: u64) -> bool {
        self.shadow.as_ref().is_some_and(|shadow| shadow.is_left(now_us))
    }

    /// Somebody watches the trial of this model, or its work as a shadow.
    fn watch(&mut self, sha256: &str, now_us: u64) -> Result<(), Refused> {
        if self.renew(sha256, now_us) || self.in_force().sha256 == sha256 {
            return Ok(());
        }
        let last = self.lasting.last.as_ref().filter(|last| last.model.sha256 == sha256);
        let why = last.map_or_else(String::new, |last| format!(": {}", last.how));
        Err(Refused(format!("that model is not on trial here{why}")))
    }

    fn renew(&mut self, sha256: &str, now_us: u64) -> bool {
        let mut both = self.trial.iter_mut().chain(&mut self.shadow);
        let watched = both.find(|watched| watched.model.sha256 == sha256);
        watched.map(|watched| watched.watched_us = now_us).is_some()
    }

    /// An order to keep the model on trial.
    fn accept(&mut self, sha256: &str, now_us: u64) -> Result<(), Refused> {
        self.watch(sha256, now_us)?;
        if let Some(Watched { model, .. }) = self.trial.take() {
            self.lasting.trial = None;
            self.lasting.before = self.lasting.accepted.replace(model.clone());
            self.lasting.last = Some(Ended { model, how: How::Accepted });
        }
        Ok(())
    }

    /// The model on trial could not be put in force.
    fn failed(&mut self) {
        self.end(How::Failed);
    }

    /// The model that is wanted is in force, and grasps of higher numbers than this are its own. The grasps of one that was given up for a
    /// trial count again.
    fn swapped(&mut self, begun: u64) {
        self.since = begun;
        self.grasps = core::mem::take(&mut self.resumed);
    }

    /// An order to give this model back, or the one in force, whatever was counted with it. Of one that is not in force there is nothing to give back.
    fn back(&mut self, sha256: Option<&str>) -> Step {
        let is_meant = |model: &ModelId| sha256.is_none_or(|sha256| model.sha256 == sha256);
        if self.trial.as_ref().is_some_and(|trial| is_meant(&trial.model)) {
            return self.end(How::Ordered);
        }
        match self.lasting.accepted.take_if(|model| is_meant(model)) {
            Some(model) => {
                self.lasting.accepted = self.lasting.before.take();
                self.lasting.last = Some(Ended { model, how: How::Ordered });
                Step::Swap(self.lasting.accepted.clone())
            }
            None => Step::Stay,
        }
    }

    /// A grasp has ended. One of another model is too late.
    fn grasped(&mut self, finished: &Finished) {
        if self.is_paused && (self.trial.is_some() || self.shadow.is_some()) {
            return;
        }
        if let Some(shadow) = &mut self.shadow
            && finished.number > shadow.since
            && finished.grasp.compared.is_some()
            && shadow.grasps.len() < MOST_GRASPS
        {
            shadow.grasps.push(finished.grasp);
        }
        if finished.number <= self.since || self.grasps.len() >= MOST_GRASPS && self.trial.is_some()
        {
            return;
        }
        if self.grasps.len() >= MOST_GRASPS {
            self.grasps.remove(0);
        }
        self.grasps.push(finished.grasp);
    }

    /// The time, and the latched fault of the gripper.
    fn tick(&mut self, now_us: u64, fault: FaultCode) -> Step {
        self.fault = fault;
        let left = self.trial.as_ref().is_some_and(|trial| trial.is_left(now_us));
        if left { self.end(How::Unwatched) } else { Step::Stay }
    }

    /// Other settings are in force, with the model named where none was taken over the network. Grasps with the old ones are no comparison any
    /// more.
    fn reloaded(&mut self, configured: ModelId) -> Step {
        self.configured = configured;
        self.grasps.clear();
        if self.trial.is_some() { self.end(How::Reloaded) } else { Step::Stay }
    }

    /// How it stands.
    fn standing(&self) -> Standing {
        let configured = || self.configured.clone();
        let before = match (&self.trial, &self.lasting.accepted) {
            (Some(_), accepted) => Some(accepted.clone().unwrap_or_else(configured)),
            (None, Some(_)) => Some(self.lasting.before.clone().unwrap_or_else(configured)),
            (None, None) => None,
        };
        let trial = self.trial.as_ref();
        let shadow = self.shadow.as_ref();
        Standing {
            in_force: self.in_force().clone(),
            configured: configured(),
            before,
            trial: trial
                .map(|trial| TrialReport { lease_s: trial.lease_s, before: trial.grasps.len() }),
            shadow: shadow.map(|shadow| ShadowReport {
                model: shadow.model.clone(),
                lease_s: shadow.lease_s,
                compared: shadow.grasps.len(),
            }),
            grasped: self.grasps.len(),
            last: self.lasting.last.clone(),
            ..Standing::default()
        }
    }

    /// Grasps with this model that somebody watches, from that many on: those of its trial, or those in which it was asked as a shadow.
    fn grasps_of(&self, sha256: &str, from: usize) -> &[Grasp] {
        let shadow = self.shadow.as_ref().filter(|shadow| shadow.model.sha256 == sha256);
        shadow.map_or(self.grasps(from), |shadow| shadow.grasps.get(from..).unwrap_or_default())
    }

    /// Grasps with the model in force, from that many on.
    fn grasps(&self, from: usize) -> &[Grasp] {
        self.grasps.get(from..).unwrap_or_default()
    }

    /// Grasps with the model before the one on trial.
    fn grasps_before(&self) -> &[Grasp] {
        self.trial.as_ref().map_or(&[], |trial| &trial.grasps)
    }

    fn in_force(&self) -> &ModelId {
        self.wanted().unwrap_or(&self.configured)
    }

    /// The model on trial goes.
    fn end(&mut self, how: How) -> Step {
        let Some(Watched { model, grasps, .. }) = self.trial.take() else { return Step::Stay };
        if matches!(how, How::Ordered | How::Unwatched) {
            self.resumed = grasps;
        }
        self.lasting.trial = None;
        self.lasting.last = Some(Ended { model, how });
        Step::Swap(self.lasting.accepted.clone())
    }
}

#[cfg(test)]
mod tests;
