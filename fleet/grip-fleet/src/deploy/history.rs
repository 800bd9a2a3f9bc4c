//! Which roll-outs a gripper has taken part in, and whether they pause there: what its folder keeps beside the model in force.

use super::{How, ModelId};
use grip_session::signature::Provenance;
use serde::{Deserialize, Serialize};

/// Entries that are kept, the latest ones.
const MOST: usize = 100;
/// Letters of a name, and of a reason.
const LONGEST_NAME: usize = 64;
const LONGEST_REASON: usize = 300;

/// Which roll-out an order belongs to.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Origin {
    /// Who ordered it; empty where that is not known.
    pub by: String,
    /// When the roll-out began, by the clock of whoever began it (ns since 1970); 0 where that is not known.
    pub rollout_ns: u64,
    /// Stage in which the gripper got the model; 0 in the shadow stage.
    pub stage: u32,
}

impl Origin {
    /// Without what is too long or stands for something in the parameters of a question.
    #[must_use]
    pub fn new(by: &str, rollout_ns: u64, stage: u32) -> Self {
        Self { by: parameter(by, LONGEST_NAME), rollout_ns, stage }
    }
}

/// Why a model is to go, without what is too long or stands for something in the parameters of a question.
pub(super) fn reason(text: &str) -> String {
    parameter(text, LONGEST_REASON)
}

/// The text of a parameter.
fn parameter(text: &str, longest: usize) -> String {
    let plain = |letter: char| if ";=#?&|".contains(letter) { ',' } else { letter };
    text.chars().filter(|letter| !letter.is_control()).map(plain).take(longest).collect()
}

/// A model at this gripper, from its first estimate beside the one in force to its end.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// Which one.
    pub model: ModelId,
    /// Which roll-out brought it.
    #[serde(flatten)]
    pub origin: Origin,
    /// Who has signed it, where that was asked and somebody has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signed: Option<Provenance>,
    /// When it began and ended here, by the clock of the gripper's computer (ns since 1970); 0 where that is not known.
    pub begun_ns: u64,
    /// The end; none while it goes on.
    pub ended_ns: Option<u64>,
    /// Grasps with it, or those in which it was asked in the shadow stage; none where a start of gripfleet has cost the count.
    pub grasps: Option<usize>,
    /// How it ended.
    pub how: Option<How>,
    /// Why whoever ordered its end has ordered it.
    pub why: Option<String>,
}

/// Roll-outs pause at a gripper.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Paused {
    /// Who ordered it; empty where that is not known.
    pub by: String,
    /// Since when, by the clock of the gripper's computer (ns since 1970); 0 where that is not known.
    pub at_ns: u64,
}

/// The file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct History {
    /// Whether roll-outs pause here.
    pub(super) paused: Option<Paused>,
    /// The latest last.
    pub(super) entries: Vec<Entry>,
}

impl History {
    /// A model of that roll-out begins here, or goes on to the next stage.
    pub(super) fn begin(
        &mut self,
        model: &ModelId,
        origin: &Origin,
        signed: Option<&Provenance>,
        now_ns: u64,
    ) {
        if let Some(entry) = self.open(model) {
            entry.origin.stage = origin.stage;
            return;
        }
        let (model, origin) = (model.clone(), origin.clone());
        self.push(Entry {
            model,
            origin,
            signed: signed.cloned(),
            begun_ns: now_ns,
            ended_ns: None,
            grasps: None,
            how: None,
            why: None,
        });
    }

    /// A model ends here, after so many grasps; one that was accepted before has an entry of its own for that.
    pub(super) fn end(&mut self, model: &ModelId, how: How, why: Option<String>, now_ns: u64) {
        if self.open(model).is_none() {
            let known = |entry: &&Entry| entry.model.sha256 == model.sha256;
            let last = self.entries.iter().rev().find(known);
            let known = last.map(|entry| (entry.origin.clone(), entry.signed.clone()));
            let (origin, signed) = known.unwrap_or_default();
            self.begin(model, &origin, signed.as_ref(), now_ns);
        }
        if let Some(entry) = self.open(model) {
            (entry.ended_ns, entry.how, entry.why) = (Some(now_ns), Some(how), why);
        }
    }

    /// The entry of a model that goes on.
    pub(super) fn open(&mut self, model: &ModelId) -> Option<&mut Entry> {
        let is_open =
            |entry: &&mut Entry| entry.how.is_none() && entry.model.sha256 == model.sha256;
        self.entries.iter_mut().rev().find(is_open)
    }

    fn push(&mut self, entry: Entry) {
        if self.entries.len() >= MOST {
            self.entries.remove(0);
        }
        self.entries.push(entry);
    }
}
