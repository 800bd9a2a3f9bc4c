//! What a gripper says of its models, and what it keeps of them over an end of its daemon.

use crate::rollout::{Counts, Worse};
use core::fmt;
use serde::{Deserialize, Serialize};

/// A model: a name for people, and what it is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
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

/// How a trial, or an accepted model, came to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum How {
    /// It has been watched long enough, and stays.
    Accepted,
    /// There were more slips or faults than before.
    Worse(Worse),
    /// Nothing was grasped with it.
    Idle,
    /// Somebody asked for the model of before.
    Told,
    /// The daemon ended during the trial.
    Restarted,
    /// Other settings came in force during the trial.
    Reloaded,
    /// It could not be put in force.
    Failed,
}

impl fmt::Display for How {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Accepted => "it was watched long enough, and stays",
            Self::Worse(Worse::Slips) => "there were more slips",
            Self::Worse(Worse::Faults) => "there were more faults",
            Self::Idle => "nothing was grasped with it",
            Self::Told => "it was asked to",
            Self::Restarted => "gripd or gripfleet has started again during the trial",
            Self::Reloaded => "its settings were changed during the trial",
            Self::Failed => "it could not be put in force",
        })
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
pub struct Lasting {
    /// The model that was accepted last; that of the configuration, where absent.
    pub accepted: Option<ModelId>,
    /// The model before it; that of the configuration, where absent.
    pub before: Option<ModelId>,
    /// The model on trial: a daemon that finds one here has ended during the trial.
    pub trial: Option<ModelId>,
    /// What became of the last one.
    pub last: Option<Ended>,
}

/// A trial that goes on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialReport {
    /// Its length, in time with an object (s).
    pub watch_s: f64,
    /// What was counted with the model before.
    pub before: Counts,
}

impl Standing {
    /// The model of the configuration is in force, and no other one was taken.
    #[must_use]
    pub fn configured(model: &ModelId, counted: Counts) -> Self {
        Self { in_force: model.clone(), before: None, trial: None, counted, last: None }
    }
}

/// How the models of a gripper stand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Standing {
    /// The model in force.
    pub in_force: ModelId,
    /// The model that it gives way to where somebody asks for it; none where that of the configuration is in force.
    pub before: Option<ModelId>,
    /// The trial of the model in force, where it is on one.
    pub trial: Option<TrialReport>,
    /// What was counted since it has been in force, or since the start.
    pub counted: Counts,
    /// What became of the last model.
    pub last: Option<Ended>,
}
