//! Orders and counts in; answers, notices for people and the models to put in force out: the rules of [`Deployment`] with a [`Shelf`] beneath them.

use super::{
    Declined, Deployment, Examined, Fault, ModelId, Offer, Order, Shelf, ShelfError, Standing,
    Step, examine,
};
use crate::rollout::Finished;
use grip_link::message::FaultCode;
use grip_session::exit::message;
use std::path::Path;

/// Puts a model in force and waits until it is; none is that of the configuration. How many grasps had begun then.
pub type Swap<'a> = dyn FnMut(Option<&Examined>) -> Result<u64, String> + 'a;

/// Something that a person should know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Notice {
    /// As it should be.
    Done(String),
    /// As it should not.
    Trouble(String),
}

/// Why an order is not obeyed.
#[derive(Debug, thiserror::Error)]
pub enum OrderFault {
    /// The model is none for this gripper.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// Not now.
    #[error(transparent)]
    Declined(#[from] Declined),
    /// It cannot be kept.
    #[error("the model cannot be kept: {0}")]
    Shelf(#[from] ShelfError),
    /// It cannot be put in force.
    #[error("the model cannot be put in force: {0}")]
    Swap(String),
}

/// The models of one gripper, in force and on disk.
#[derive(Debug)]
pub struct Models {
    deployment: Deployment,
    shelf: Shelf,
    /// The model that is wanted could not be put in force yet.
    due: bool,
    notices: Vec<Notice>,
}

impl Models {
    /// Opens what an earlier run has left in `folder`.
    ///
    /// # Errors
    /// [`ShelfError`]: then it is not known which model should be in force.
    pub fn open(folder: &Path, configured: ModelId) -> Result<Self, ShelfError> {
        let (shelf, lasting) = Shelf::open(folder)?;
        let deployment = Deployment::new(configured, lasting);
        let mut models = Self { deployment, shelf, due: false, notices: Vec::new() };
        if let Some(last) = &models.deployment.lasting().last {
            models.notices.push(Notice::Done(format!("the last {}: {}", last.model, last.how)));
        }
        if let Some(model) = models.deployment.wanted().cloned() {
            models.fetch(&model)?;
        }
        models.note();
        Ok(models)
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
    /// [`OrderFault`], a sentence for whoever sent it; the model in force stays.
    pub fn obey(
        &mut self,
        order: Order,
        now_us: u64,
        swap: &mut Swap<'_>,
    ) -> Result<Standing, OrderFault> {
        let mut grasps = Vec::new();
        match order {
            Order::Notify => {}
            Order::Check(Offer { name, sha256, lease_s, bytes }) => {
                let model = examine(&name, &sha256, &bytes)?;
                self.deployment.check(&model.id, lease_s)?;
                let trial = self.standing().trial.is_some();
                let known = &self.deployment;
                grasps = if trial { known.grasps_before() } else { known.grasps(0) }.to_vec();
            }
            Order::Take(Offer { name, sha256, lease_s, bytes }) => {
                self.take(&examine(&name, &sha256, &bytes)?, lease_s, now_us, swap)?;
                grasps = self.deployment.grasps_before().to_vec();
            }
            Order::Watch { sha256, from } => {
                self.deployment.watch(&sha256, now_us)?;
                grasps = self.deployment.grasps(from).to_vec();
            }
            Order::Accept { sha256 } => {
                let was = self.deployment.lasting().clone();
                self.deployment.accept(&sha256, now_us)?;
                if *self.deployment.lasting() != was {
                    self.report_last();
                    self.note();
                }
            }
            Order::Back { sha256 } => {
                let step = self.deployment.back(sha256.as_deref());
                self.go_back(&step, swap)?;
            }
        }
        Ok(Standing { grasps, ..self.deployment.standing() })
    }

    fn take(
        &mut self,
        model: &Examined,
        lease_s: u32,
        now_us: u64,
        swap: &mut Swap<'_>,
    ) -> Result<(), OrderFault> {
        let step = self.deployment.take(model.id.clone(), lease_s, now_us)?;
        if step == Step::Stay {
            return Ok(());
        }
        if self.standing().trial.is_none() {
            return self.go_back(&step, swap);
        }
        self.begin(model, swap)?;
        let text =
            format!("{} is on trial, as long as somebody watches it every {lease_s} s", model.id);
        self.report(text);
        Ok(())
    }

    fn go_back(&mut self, step: &Step, swap: &mut Swap<'_>) -> Result<(), OrderFault> {
        self.follow(step, swap);
        if self.due { Err(OrderFault::Swap("it is tried again".to_owned())) } else { Ok(()) }
    }

    /// A grasp has ended.
    pub fn grasped(&mut self, finished: &Finished) {
        self.deployment.grasped(finished);
    }

    /// The time, and the latched fault of the gripper. A model on trial that nobody watches any more goes; a way back that failed is tried again.
    pub fn tick(&mut self, now_us: u64, fault: FaultCode, swap: &mut Swap<'_>) {
        let step = self.deployment.tick(now_us, fault);
        self.follow(&step, swap);
        if self.due {
            self.restore(swap);
        }
    }

    /// Other settings are in force, with that model where none came over the network.
    pub fn reloaded(&mut self, configured: ModelId, swap: &mut Swap<'_>) {
        let step = self.deployment.reloaded(configured);
        self.follow(&step, swap);
    }

    /// How they stand.
    #[must_use]
    pub fn standing(&self) -> Standing {
        self.deployment.standing()
    }

    /// What has happened since it was asked last.
    pub fn notices(&mut self) -> Vec<Notice> {
        core::mem::take(&mut self.notices)
    }

    /// First on disk, so that a daemon that ends now knows of the trial; then in force.
    fn begin(&mut self, model: &Examined, swap: &mut Swap<'_>) -> Result<(), OrderFault> {
        let kept = self.shelf.put(&model.id, &model.text);
        let begun = kept
            .and_then(|()| self.shelf.note(self.deployment.lasting()))
            .map_err(OrderFault::Shelf)
            .and_then(|()| swap(Some(model)).map_err(OrderFault::Swap));
        match begun {
            Ok(begun) => {
                self.deployment.swapped(begun);
                Ok(())
            }
            Err(fault) => {
                self.deployment.failed();
                self.note();
                Err(fault)
            }
        }
    }

    fn follow(&mut self, step: &Step, swap: &mut Swap<'_>) {
        if *step != Step::Stay {
            self.report_last();
            self.note();
            self.restore(swap);
        }
    }

    /// Puts the model in force that is wanted; what fails is tried again with the next tick.
    fn restore(&mut self, swap: &mut Swap<'_>) {
        let wanted = self.deployment.wanted();
        let model = wanted.map(|model| self.fetch(model).map_err(|error| message(&error)));
        match model.transpose().and_then(|model| swap(model.as_ref())) {
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
    fn fetch(&self, model: &ModelId) -> Result<Examined, ShelfError> {
        let text = self.shelf.read(model)?;
        examine(&model.name, &model.sha256, text.as_bytes())
            .map_err(|fault| self.shelf.unusable(model, message(&fault)))
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

    fn report_last(&mut self) {
        if let Some(last) = &self.deployment.lasting().last {
            self.report(format!("{}: {}", last.model, last.how));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Models, Notice, Offer, Order, Standing};
    use crate::{
        deploy::{Examined, How, ModelId, digest},
        rollout::{Finished, Grasp},
    };
    use grip_link::message::FaultCode;
    use grip_session::model::default_text;
    use std::{path::Path, sync::Arc};

    const NONE: FaultCode = FaultCode::NONE;

    fn model(name: &str, text: &str) -> ModelId {
        ModelId { name: name.to_owned(), sha256: digest(text.as_bytes()) }
    }

    fn take(name: &str, text: &str) -> Order {
        let bytes: Arc<[u8]> = text.as_bytes().into();
        Order::Take(Offer { name: name.to_owned(), sha256: digest(&bytes), lease_s: 60, bytes })
    }

    fn open(folder: &Path) -> Models {
        Models::open(folder, model("file", default_text())).unwrap()
    }

    fn grasped(models: &mut Models, count: u64) {
        (1..=count).for_each(|n| models.grasped(&Finished { number: n, grasp: Grasp::default() }));
    }

    #[test]
    fn what_was_accepted_is_there_at_the_next_start_and_what_was_on_trial_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let [other, third] = [" ", "  "].map(|spaces| format!("{}{spaces}", default_text()));
        let mut in_force = Vec::new();
        let mut swap = |model: Option<&Examined>| {
            in_force.push(model.map(|model| model.id.name.clone()));
            Ok(4)
        };
        let sha256 = digest(other.as_bytes());
        let grasps = |standing: &Standing| (standing.grasped, standing.grasps.len());
        {
            let mut models = open(folder.path());
            let swap = &mut swap;
            grasped(&mut models, 3);
            let taken = models.obey(take("a", &other), 0, swap).unwrap();
            assert_eq!((grasps(&taken), taken.trial.unwrap().before), ((0, 3), 3), "those before");
            grasped(&mut models, 6);
            let watch = Order::Watch { sha256: sha256.clone(), from: 1 };
            let watched = models.obey(watch, 0, swap).unwrap();
            assert_eq!(grasps(&watched), (2, 1), "those that are not known yet");
            models.obey(Order::Accept { sha256: sha256.clone() }, 0, swap).unwrap();
            assert_eq!(models.standing().last.unwrap().how, How::Accepted);
            models.obey(take("b", &third), 0, swap).unwrap();
            assert!(models.standing().trial.is_some());
        }
        let mut models = open(folder.path());
        models.resume(&digest(default_text().as_bytes()), &mut swap);
        models.resume(&sha256, &mut swap);
        assert_eq!(models.standing().last.unwrap().how, How::Restarted);
        assert!(
            matches!(&models.notices()[..], [Notice::Done(text), _] if text.contains("started again"))
        );
        models.obey(Order::Back { sha256: Some(sha256) }, 0, &mut swap).unwrap();
        assert_eq!(models.standing().in_force.name, "file");
        let [a, b] = ["a", "b"].map(|name| Some(name.to_owned()));
        assert_eq!(in_force, [a.clone(), b, a, None]);
    }

    #[test]
    fn what_cannot_be_put_in_force_changes_nothing_and_the_way_back_is_tried_again() {
        let folder = tempfile::tempdir().unwrap();
        let mut models = open(folder.path());
        let other = format!("{} ", default_text());
        let no = &mut |_: Option<&Examined>| Err("no".to_owned());
        let yes = &mut |_: Option<&Examined>| Ok(0);
        let reported = models.obey(take("a", &other), 0, no).unwrap_err().to_string();
        assert_eq!(reported, "the model cannot be put in force: no");
        assert_eq!(models.standing().in_force.name, "file");
        models.obey(take("a", &other), 0, yes).unwrap();
        models.notices();
        // Nobody watches it.
        models.tick(61_000_000, NONE, no);
        models.tick(61_100_000, NONE, no);
        let troubles =
            models.notices().into_iter().filter(|notice| matches!(notice, Notice::Trouble(_)));
        assert_eq!(troubles.count(), 1, "reported once");
        models.tick(61_200_000, NONE, yes);
        assert_eq!(
            models.notices(),
            [Notice::Done(format!("{} is in force", model("file", default_text())))]
        );
    }
}
