//! Orders and counts in; answers, notices for people and the models to put in force out: the rules of [`Deployment`] with a [`Shelf`] beneath them.

use super::{
    Declined, Deployment, Examined, Fault, ModelId, Offer, Order, Shelf, ShelfError, Standing,
    Step, examine,
};
use crate::rollout::Counts;
use grip_session::exit::message;
use std::path::Path;

/// Puts a model in force and waits until it is; none is that of the configuration. All counts of this run since then.
pub type Swap<'a> = dyn FnMut(Option<&Examined>) -> Result<Counts, String> + 'a;

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
    pub fn obey(&mut self, order: Order, swap: &mut Swap<'_>) -> Result<Standing, OrderFault> {
        match order {
            Order::Notify => {}
            Order::Check(Offer { name, sha256, judge, bytes }) => {
                let model = examine(&name, &sha256, &bytes)?;
                self.deployment.check(&model.id, &judge)?;
            }
            Order::Take(Offer { name, sha256, judge, bytes }) => {
                let model = examine(&name, &sha256, &bytes)?;
                if self.deployment.take(model.id.clone(), judge)? != Step::Stay {
                    self.begin(&model, swap)?;
                    let id = &model.id;
                    self.report(format!("{id} is on trial for {} s with an object", judge.watch_s));
                }
            }
            Order::Back { sha256 } => {
                let step = self.deployment.back(sha256.as_deref());
                self.follow(&step, swap);
                if self.due {
                    return Err(OrderFault::Swap("it is tried again".to_owned()));
                }
            }
        }
        Ok(self.deployment.standing())
    }

    /// All counts of this run as of now. A model on trial may go by that, or stay.
    pub fn count(&mut self, total: Counts, swap: &mut Swap<'_>) {
        let was = self.deployment.lasting().clone();
        let step = self.deployment.count(total);
        if step == Step::Stay && *self.deployment.lasting() != was {
            self.report_last();
            self.note();
        }
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
            Ok(total) => {
                self.deployment.swapped(total);
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

    /// Puts the model in force that is wanted; what fails is tried again with the next counts.
    fn restore(&mut self, swap: &mut Swap<'_>) {
        let wanted = self.deployment.wanted();
        let model = wanted.map(|model| self.fetch(model).map_err(|error| message(&error)));
        match model.transpose().and_then(|model| swap(model.as_ref())) {
            Ok(total) => {
                self.due = false;
                self.deployment.swapped(total);
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
    use super::{Models, Notice, Offer, Order};
    use crate::{
        deploy::{Examined, How, ModelId, digest},
        rollout::{Counts, JudgeConfig},
    };
    use grip_session::model::default_text;
    use std::{path::Path, sync::Arc};

    fn model(name: &str, text: &str) -> ModelId {
        ModelId { name: name.to_owned(), sha256: digest(text.as_bytes()) }
    }

    fn take(name: &str, text: &str) -> Order {
        let bytes: Arc<[u8]> = text.as_bytes().into();
        let judge = JudgeConfig { watch_s: 60.0, ..JudgeConfig::default() };
        Order::Take(Offer { name: name.to_owned(), sha256: digest(&bytes), judge, bytes })
    }

    fn open(folder: &Path) -> Models {
        Models::open(folder, model("file", default_text())).unwrap()
    }

    /// A grasp with each slip.
    fn counts(seconds: f64, slips: u64) -> Counts {
        Counts { seconds, slips, faults: 0, grasps: slips }
    }

    #[test]
    fn what_was_accepted_is_there_at_the_next_start_and_what_was_on_trial_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let other = format!("{} ", default_text());
        let third = format!("{}  ", default_text());
        let mut in_force = Vec::new();
        let totals = [(100.0, 11), (161.0, 16), (0.0, 0), (0.0, 0)];
        let mut totals = totals.into_iter().map(|(seconds, slips)| counts(seconds, slips));
        let mut swap = |model: Option<&Examined>| {
            in_force.push(model.map(|model| model.id.name.clone()));
            Ok(totals.next().unwrap())
        };
        {
            let mut models = open(folder.path());
            let swap = &mut swap;
            models.count(counts(100.0, 10), swap);
            models.obey(take("a", &other), swap).unwrap();
            models.count(counts(161.0, 16), swap);
            // The slip that was noticed while the model waited for its turn is not the model's.
            assert_eq!(models.standing().counted, counts(61.0, 5));
            assert_eq!(models.standing().last.unwrap().how, How::Accepted);
            models.obey(take("b", &third), swap).unwrap();
            assert!(models.standing().trial.is_some());
        }
        let mut models = open(folder.path());
        models.resume(&digest(default_text().as_bytes()), &mut swap);
        models.resume(&digest(other.as_bytes()), &mut swap);
        assert_eq!(models.standing().last.unwrap().how, How::Restarted);
        assert!(
            matches!(&models.notices()[..], [Notice::Done(text), _] if text.contains("started again"))
        );
        let sha256 = digest(other.as_bytes());
        models.obey(Order::Back { sha256: Some(sha256) }, &mut swap).unwrap();
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
        let yes = &mut |_: Option<&Examined>| Ok(counts(100.0, 10));
        models.count(counts(100.0, 10), yes);
        let reported = models.obey(take("a", &other), no).unwrap_err().to_string();
        assert_eq!(reported, "the model cannot be put in force: no");
        assert_eq!(models.standing().in_force.name, "file");
        models.obey(take("a", &other), yes).unwrap();
        models.notices();
        models.count(counts(120.0, 90), no);
        models.count(counts(121.0, 90), no);
        let troubles =
            models.notices().into_iter().filter(|notice| matches!(notice, Notice::Trouble(_)));
        assert_eq!(troubles.count(), 1, "told once");
        models.count(counts(122.0, 90), yes);
        assert_eq!(
            models.notices(),
            [Notice::Done(format!("{} is in force", model("file", default_text())))]
        );
    }
}
