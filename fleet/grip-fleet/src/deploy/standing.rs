//! What a gripper reports of its models, and what it keeps of them over an end of its daemon.

use super::{Entry, Paused, Rehearsal};
use crate::rollout::Grasp;
use core::fmt;
use serde::{Deserialize, Deserializer, Serialize};

/// A model: a name for people, and what it is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModelId {
    /// The name of its file where it came from.
    pub name: String,
    /// SHA-256 of its file, 64 hexadecimal digits.
    pub sha256: String,
}

impl fmt::Display for ModelId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let short = self.sha256.get(..12).unwrap_or(&self.sha256);
        write!(f, "model {} ({short})", self.name)
    }
}

slip_core::named! {
    /// How a trial, or an accepted model, came to its end.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum How {
        fn sentence: "It in words.";
    }
    Accepted: "The roll-out was over, and it stays.", "its trial is over, and it stays";
    #[serde(rename = "told")]
    Ordered: "Somebody asked for the model of before.", "it was asked to";
    Unwatched: "Nobody watched the trial for the time of its lease.", "nobody watched its trial any more";
    Restarted: "The daemon ended during the trial.", "gripd or gripfleet has started again during the trial";
    Reloaded: "Other settings came in force during the trial.", "its settings were changed during the trial";
    Failed: "It could not be put in force.", "it could not be put in force";
}

impl fmt::Display for How {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.sentence())
    }
}

/// A model and its end.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ended {
    /// Which one.
    pub model: ModelId,
    /// How.
    pub how: How,
}

/// What survives an end of the daemon.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Lasting {
    /// The model that was accepted last; that of the configuration, where absent.
    pub(super) accepted: Option<ModelId>,
    /// The model before it; that of the configuration, where absent.
    pub(super) before: Option<ModelId>,
    /// The model on trial: a daemon that finds one here has ended during the trial.
    pub(super) trial: Option<ModelId>,
    /// What became of the last one; an end that is not known, such as one of an earlier version, is none.
    #[serde(deserialize_with = "known")]
    pub(super) last: Option<Ended>,
}

fn known<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Ended>, D::Error> {
    serde_json::Value::deserialize(from).map(|value| serde_json::from_value(value).ok())
}

/// A trial that goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrialReport {
    /// It ends where nobody watches it for so long (s).
    pub lease_s: u32,
    /// Grasps with the model before.
    pub before: usize,
}

/// A model that estimates beside the one in force.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShadowReport {
    /// Which one.
    pub model: ModelId,
    /// It ends where nobody watches it for so long (s).
    pub lease_s: u32,
    /// Grasps in which both were asked.
    pub compared: usize,
}

/// A replay of the gripper's own recordings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReplayReport {
    /// It goes on; ask again.
    pub running: bool,
    /// What it has shown.
    #[serde(flatten)]
    pub rehearsal: Rehearsal,
}

impl Standing {
    /// The model of the configuration is in force, and no other one was taken.
    #[must_use]
    pub fn configured(model: &ModelId) -> Self {
        Self { in_force: model.clone(), configured: model.clone(), ..Self::default() }
    }
}

/// How the models of a gripper stand.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Standing {
    /// The model in force.
    pub in_force: ModelId,
    /// The model that the configuration names.
    pub configured: ModelId,
    /// The model that it gives way to where somebody asks for it; none where that of the configuration is in force.
    pub before: Option<ModelId>,
    /// The trial of the model in force, where it is on one.
    pub trial: Option<TrialReport>,
    /// The model that estimates beside it, where one does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shadow: Option<ShadowReport>,
    /// Only in the answer to an order to replay its recordings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub replay: Option<ReplayReport>,
    /// Grasps since it has been in force, or since the start.
    pub grasped: usize,
    /// Those that were asked for: to a check the ones with the model in force, to an order to take a model the ones before it, to an order to
    /// watch it the ones with it, or those in which it was asked beside the one in force.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub grasps: Vec<Grasp>,
    /// What became of the last model.
    pub last: Option<Ended>,
    /// Who lets roll-outs pause here, where somebody does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paused: Option<Paused>,
    /// Those that were asked for, the latest last: all, or to a check the one of this model that goes on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub history: Vec<Entry>,
}

#[cfg(test)]
mod tests {
    use super::Lasting;

    #[test]
    fn an_end_of_an_earlier_version_does_not_hide_what_was_accepted() {
        let text = r#"{"accepted":{"name":"a","sha256":"ab"},"last":{"model":{"name":"b","sha256":"cd"},"how":{"worse":"slips"}}}"#;
        let lasting: Lasting = serde_json::from_str(text).unwrap();
        assert_eq!((lasting.accepted.unwrap().name, lasting.last), ("a".to_owned(), None));
    }
}
