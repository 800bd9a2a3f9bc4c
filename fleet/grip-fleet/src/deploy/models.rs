//! The rules of [`Deployment`] with a [`Shelf`] beneath them: answers, notices for people and the models to put in force, by orders and counts.

use super::{
    Deployment, Entry, Examined, History, How, ModelId, Offer, Order, Origin, Paused, Refused,
    Rehearsal, ReplayReport, Shelf, Standing, Step, examine,
};
use crate::{StoreError, rollout::Finished};
use grip_link::message::FaultCode;
use grip_session::{exit::message, signature::ModelKeys};
use std::path::Path;

/// Where a model goes.
#[derive(Clone, Copy, Debug)]
pub enum Put<'a> {
    /// In force; none is that of the configuration.
    InForce(Option<&'a Examined>),
    /// Beside the one in force, without touching the force; none ends that.
    Beside(Option<&'a Examined>),
}

/// Puts a model where it goes and waits until it is there. How many grasps had begun then.
pub type Swap<'a> = dyn FnMut(Put<'_>) -> Result<u64, String> + 'a;

/// Something that a person should know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Notice {
    /// As it should be.
    Done(String),
    /// As it should not.
    Trouble(String),
}

/// The models of one gripper, in force and on disk.
#[derive(Debug)]
pub struct Models {
    deployment: Deployment,
    shelf: Shelf,
    /// The model that is wanted could not be put in force yet.
    due: bool,
    notices: Vec<Notice>,
    /// A replay of recordings: of which model, until when its end is kept (us), and what it has shown, once it is over.
    replay: Option<(ModelId, u64, Option<Rehearsal>)>,
    /// The model of a replay that has not begun.
    rehearsing: Option<Examined>,
    history: History,
    /// Time of day (ns since 1970); 0 where that is not known.
    utc_ns: u64,
    /// Whose models are taken.
    keys: ModelKeys,
}

impl Models {
    /// Opens what an earlier run has left in `folder`.
    ///
    /// # Errors
    /// [`StoreError`]: then it is not known which model should be in force.
    pub fn open(folder: &Path, configured: ModelId) -> Result<Self, StoreError> {
        let (shelf, lasting) = Shelf::open(folder)?;
        let deployment = Deployment::new(configured, lasting);
        let mut models = Self {
            deployment,
            shelf,
            due: false,
            notices: Vec::new(),
            replay: None,
            rehearsing: None,
            history: History::default(),
            utc_ns: 0,
            keys: ModelKeys::default(),
        };
        models.remember();
        if let Some(last) = &models.deployment.lasting().last {
            models.notices.push(Notice::Done(format!("the last {}: {}", last.model, last.how)));
        }
        if let Some(model) = models.deployment.wanted().cloned() {
            models.fetch(&model)?;
        }
        models.note();
        Ok(models)
    }

    /// The same where a model that comes has to be signed with one of these keys.
    #[must_use]
    pub fn with_keys(self, keys: ModelKeys) -> Self {
        Self { keys, ..self }
    }

    /// Examines a model that has come, and its signature. The model in force, the one before and that of the configuration were taken by the
    /// rules of their time: no signature closes the way back.
    fn examine(&self, offer: &Offer) -> Result<Examined, Refused> {
        let model = examine(&offer.name, &offer.sha256, &offer.bytes)?;
        let deployment = &self.deployment;
        let is_known =
            deployment.is_known(&model.id) || deployment.in_force().sha256 == model.id.sha256;
        match self.keys.check(&model.text) {
            Ok(signed) => Ok(Examined { signed, ..model }),
            Err(_) if is_known => Ok(model),
            Err(error) => {
                let name = &model.id.name;
                Err(Refused(format!("{name}: {error}; {}", error.remedy(name))))
            }
        }
    }

    /// What an earlier run has noted. A file that cannot be read costs what stands in it, and nothing else.
    fn remember(&mut self) {
        match self.shelf.history() {
            Ok(history) => self.history = history,
            Err(error) => {
                let text = format!("earlier roll-outs are not known here: {}", message(&error));
                self.notices.push(Notice::Trouble(text));
            }
        }
        self.deployment.pause(self.history.paused.is_some());
        let open = self.history.entries.iter_mut().filter(|entry| entry.how.is_none());
        open.for_each(|entry| entry.how = Some(How::Restarted));
    }

    /// Sets the time of day (ns since 1970).
    pub const fn set_utc(&mut self, utc_ns: u64) {
        self.utc_ns = utc_ns;
    }

    /// Puts the model in force that was accepted, where that of this SHA-256 is.
    pub fn resume(&mut self, in_force: &str, swap: &mut Swap<'_>) {
        if self.standing().in_force.sha256 != in_force {
            self.restore(swap);
        }
    }

    /// Obeys an order.
    ///
    /// # Errors
    /// [`Refused`]; the model in force stays.
    pub fn obey(
        &mut self,
        order: Order,
        now_us: u64,
        swap: &mut Swap<'_>,
    ) -> Result<Standing, Refused> {
        let (mut grasps, mut replay, mut history) = (Vec::new(), None, Vec::new());
        match order {
            Order::Notify => {}
            Order::Check(offer) => {
                let model = self.examine(&offer)?;
                self.deployment.check(&model.id, offer.lease_s)?;
                let trial = self.standing().trial.is_some();
                let known = &self.deployment;
                grasps = if trial { known.grasps_before() } else { known.grasps(0) }.to_vec();
                history.extend(self.history.open(&model.id).cloned());
            }
            Order::Replay(offer) => {
                let model = self.examine(&offer)?;
                self.deployment.check(&model.id, offer.lease_s)?;
                replay = Some(self.replay(model, offer.lease_s, now_us));
            }
            Order::Shadow(offer) => {
                let model = self.examine(&offer)?;
                self.cast(&model, &offer.origin, offer.lease_s, now_us, swap)?;
            }
            Order::Take(offer) => {
                let model = self.examine(&offer)?;
                self.take(&model, &offer.origin, offer.lease_s, now_us, swap)?;
                grasps = self.deployment.grasps_before().to_vec();
            }
            Order::Watch { sha256, from } => {
                self.deployment.watch(&sha256, now_us)?;
                grasps = self.deployment.grasps_of(&sha256, from).to_vec();
            }
            Order::Accept { sha256 } => {
                let was = self.deployment.lasting().clone();
                self.deployment.accept(&sha256, now_us)?;
                if *self.deployment.lasting() != was {
                    self.report_last(None);
                    self.note();
                }
            }
            Order::Back { sha256, why } => {
                if sha256.as_deref().is_some_and(|sha256| self.deployment.is_shadow(sha256)) {
                    self.end_shadow(How::Ordered, why.clone(), swap);
                }
                let step = self.deployment.back(sha256.as_deref());
                self.go_back(&step, why, swap)?;
            }
            Order::Pause { by } => {
                let at_ns = self.utc_ns;
                self.pause(Some(Paused { by, at_ns }))?;
            }
            Order::Resume => self.pause(None)?,
            Order::History => history = self.entries(),
        }
        Ok(Standing { grasps, replay, history, ..self.standing() })
    }

    /// Lets roll-outs pause here, or go on: first on disk.
    fn pause(&mut self, paused: Option<Paused>) -> Result<(), Refused> {
        if self.history.paused.is_some() == paused.is_some() {
            return Ok(());
        }
        let text = match &paused {
            Some(Paused { by, .. }) => format!("roll-outs pause here, by order of {by}"),
            None => "roll-outs go on here".to_owned(),
        };
        let history = History { paused, ..self.history.clone() };
        self.shelf.note_history(&history).map_err(|error| not_kept(&error))?;
        self.history = history;
        self.deployment.pause(self.history.paused.is_some());
        self.report(text);
        Ok(())
    }

    /// Which roll-outs were here, with the grasps of the one that goes on.
    fn entries(&self) -> Vec<Entry> {
        let count = |mut entry: Entry| {
            if entry.how.is_none() {
                entry.grasps = Some(self.deployment.grasps_of(&entry.model.sha256, 0).len());
            }
            entry
        };
        self.history.entries.iter().cloned().map(count).collect()
    }

    /// What the recordings have shown of the model; where nobody has asked within the lease, they are replayed.
    fn replay(&mut self, model: Examined, lease_s: u32, now_us: u64) -> ReplayReport {
        let until_us = now_us.saturating_add(1_000_000 * u64::from(lease_s));
        match &mut self.replay {
            // One at a time: the next model waits.
            Some((_, _, None)) => {}
            Some((known, until, Some(rehearsal))) if *known == model.id && now_us < *until => {
                *until = until_us;
                return ReplayReport { running: false, rehearsal: rehearsal.clone() };
            }
            replay => {
                *replay = Some((model.id.clone(), until_us, None));
                self.report(format!("{} is tried on the recordings of this gripper", model.id));
                self.rehearsing = Some(model);
            }
        }
        ReplayReport { running: true, rehearsal: Rehearsal::default() }
    }

    /// The model of which recordings are to be replayed, once for each; [`Models::rehearsed`] takes what they show.
    pub fn rehearsing(&mut self) -> Option<Examined> {
        self.rehearsing.take()
    }

    /// The replay is over.
    pub fn rehearsed(&mut self, rehearsal: Rehearsal) {
        if let Some((model, _, shown)) = &mut self.replay {
            let (recordings, grasps) = (rehearsal.recordings, rehearsal.grasps.len());
            let text = format!(
                "{model} was tried on {recordings} recordings of this gripper: {grasps} grasps compared"
            );
            *shown = Some(rehearsal);
            self.report(text);
        }
    }

    /// The model estimates beside the one in force: nothing of it is kept, and an end of the daemon ends it.
    fn cast(
        &mut self,
        model: &Examined,
        origin: &Origin,
        lease_s: u32,
        now_us: u64,
        swap: &mut Swap<'_>,
    ) -> Result<(), Refused> {
        if !self.deployment.check_shadow(&model.id, lease_s)? {
            // Who asks again watches it.
            self.deployment.watch(&model.id.sha256, now_us)?;
            return Ok(());
        }
        if self.deployment.waits(&model.id) {
            return Ok(());
        }
        let since = swap(Put::Beside(Some(model))).map_err(|why| {
            Refused(format!("the model cannot estimate beside the one in force: {why}"))
        })?;
        self.end_entry(How::Ordered, None);
        self.deployment.cast(model.id.clone(), lease_s, since, now_us);
        self.history.begin(&model.id, origin, model.signed.as_ref(), self.utc_ns);
        self.note_history();
        let text = format!("{} estimates beside the one in force, and moves nothing", model.id);
        self.report(text);
        Ok(())
    }

    /// The shadow goes.
    fn end_shadow(&mut self, how: How, why: Option<String>, swap: &mut Swap<'_>) {
        if self.end_entry(how, why) {
            let why = if how == How::Unwatched { "nobody watches it" } else { "it was asked to" };
            self.remove_shadow(why, swap);
        }
    }

    /// The entry of the shadow ends, and its part in the deployment; `false` where there is none.
    fn end_entry(&mut self, how: How, why: Option<String>) -> bool {
        let Some((model, compared)) = self.deployment.end_shadow() else { return false };
        if let Some(entry) = self.history.open(&model) {
            entry.grasps = Some(compared);
        }
        self.history.end(&model, how, why, self.utc_ns);
        self.note_history();
        true
    }

    fn remove_shadow(&mut self, why: &str, swap: &mut Swap<'_>) {
        let text = match swap(Put::Beside(None)) {
            Ok(_) => format!("no model estimates beside the one in force any more: {why}"),
            // Without the connection to gripd it has ended too.
            Err(reason) => format!("the model beside the one in force is left there: {reason}"),
        };
        self.report(text);
    }

    fn take(
        &mut self,
        model: &Examined,
        origin: &Origin,
        lease_s: u32,
        now_us: u64,
        swap: &mut Swap<'_>,
    ) -> Result<(), Refused> {
        if self.deployment.waits(&model.id) {
            return Ok(());
        }
        let step = self.deployment.take(model.id.clone(), lease_s, now_us)?;
        if step == Step::Stay {
            return Ok(());
        }
        // Of the same model the entry goes on.
        if self.deployment.is_shadow(&model.id.sha256) {
            self.deployment.end_shadow();
            self.remove_shadow("a model is put in force", swap);
        } else {
            self.end_shadow(How::Ordered, None, swap);
        }
        if self.standing().trial.is_none() {
            return self.go_back(&step, None, swap);
        }
        self.begin(model, swap)?;
        self.history.begin(&model.id, origin, model.signed.as_ref(), self.utc_ns);
        self.note_history();
        let text =
            format!("{} is on trial, as long as somebody watches it every {lease_s} s", model.id);
        self.report(text);
        Ok(())
    }

    fn go_back(
        &mut self,
        step: &Step,
        why: Option<String>,
        swap: &mut Swap<'_>,
    ) -> Result<(), Refused> {
        self.follow(step, why, swap);
        if self.due { Err(not_in_force("it is tried again")) } else { Ok(()) }
    }

    /// A grasp has ended.
    pub fn grasped(&mut self, finished: &Finished) {
        self.deployment.grasped(finished);
    }

    /// The time, and the latched fault of the gripper. A model on trial that nobody watches any more goes; a way back that failed is tried again.
    pub fn tick(&mut self, now_us: u64, fault: FaultCode, swap: &mut Swap<'_>) {
        let step = self.deployment.tick(now_us, fault);
        self.follow(&step, None, swap);
        if self.deployment.is_shadow_left(now_us) {
            self.end_shadow(How::Unwatched, None, swap);
        }
        if self.due {
            self.restore(swap);
        }
    }

    /// Other settings are in force, with that model where none came over the network.
    pub fn reloaded(&mut self, configured: ModelId, swap: &mut Swap<'_>) {
        let step = self.deployment.reloaded(configured);
        self.follow(&step, None, swap);
    }

    /// How they stand.
    #[must_use]
    pub fn standing(&self) -> Standing {
        Standing { paused: self.history.paused.clone(), ..self.deployment.standing() }
    }

    /// What has happened since it was asked last.
    pub fn notices(&mut self) -> Vec<Notice> {
        core::mem::take(&mut self.notices)
    }

    /// First on disk, so that a daemon that ends now knows of the trial; then in force.
    fn begin(&mut self, model: &Examined, swap: &mut Swap<'_>) -> Result<(), Refused> {
        let kept = self.shelf.put(&model.id, &model.text);
        let begun = kept
            .and_then(|()| self.shelf.note(self.deployment.lasting()))
            .map_err(|error| not_kept(&error))
            .and_then(|()| swap(Put::InForce(Some(model))).map_err(|why| not_in_force(&why)));
        match begun {
            Ok(begun) => {
                self.deployment.swapped(begun);
                Ok(())
            }
            Err(refused) => {
                self.deployment.failed();
                self.note();
                Err(refused)
            }
        }
    }

    fn follow(&mut self, step: &Step, why: Option<String>, swap: &mut Swap<'_>) {
        if *step != Step::Stay {
            self.report_last(why);
            self.note();
            self.restore(swap);
        }
    }

    /// Puts the model in force that is wanted; what fails is tried again with the next tick.
    fn restore(&mut self, swap: &mut Swap<'_>) {
        let wanted = self.deployment.wanted();
        let model = wanted.map(|model| self.fetch(model).map_err(|error| message(&error)));
        match model.transpose().and_then(|model| swap(Put::InForce(model.as_ref()))) {
            Ok(begun) => {
                self.due = false;
                self.deployment.swapped(begun);
                let text = format!("{} is in force", self.deployment.standing().in_force);
                self.report(text);
            }
            Err(reason) if !core::mem::replace(&mut self.due, true) => {
                let text = format!("the model before cannot be put in force: {reason}");
                self.notices.push(Notice::Trouble(text));
            }
            Err(_) => {}
        }
    }

    /// A model that was examined when it came.
    fn fetch(&self, model: &ModelId) -> Result<Examined, StoreError> {
        let text = self.shelf.read(model)?;
        examine(&model.name, &model.sha256, text.as_bytes())
            .map_err(|fault| self.shelf.unusable(model, &message(&fault)))
    }

    fn note(&mut self) {
        if let Err(error) = self.shelf.note(self.deployment.lasting()) {
            let text = format!("which model is in force cannot be kept: {}", message(&error));
            self.notices.push(Notice::Trouble(text));
        }
    }

    fn report(&mut self, text: String) {
        self.notices.push(Notice::Done(text));
    }

    fn report_last(&mut self, why: Option<String>) {
        let Some(last) = self.deployment.lasting().last.clone() else { return };
        self.report(format!("{}: {}", last.model, last.how));
        // Those of the model before count only from the swap on.
        let grasps = self.deployment.grasps(0).len();
        if let Some(entry) = self.history.open(&last.model) {
            entry.grasps = Some(grasps);
        }
        self.history.end(&last.model, last.how, why, self.utc_ns);
        self.note_history();
    }

    fn note_history(&mut self) {
        if let Err(error) = self.shelf.note_history(&self.history) {
            let text = format!("the history of roll-outs cannot be kept: {}", message(&error));
            self.notices.push(Notice::Trouble(text));
        }
    }
}

fn not_kept(error: &StoreError) -> Refused {
    Refused(format!("the model cannot be kept: {}", message(error)))
}

fn not_in_force(why: &str) -> Refused {
    Refused(format!("the model cannot be put in force: {why}"))
}
