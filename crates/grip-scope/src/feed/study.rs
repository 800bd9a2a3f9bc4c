//! The report of a study (JSON of `gripctl study`), as far as it is shown.

use serde::Deserialize;

/// A study.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct Study {
    /// What it is called.
    #[serde(default)]
    pub title: String,
    /// Sentences beside its plots.
    #[serde(default)]
    pub summary: Vec<String>,
    /// Its results.
    pub results: Vec<StudyResult>,
}

/// Nets that learned the same rows.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct StudyResult {
    /// Title.
    pub title: String,
    /// The nets.
    pub nets: Vec<StudyNet>,
}

/// A net and how it learned.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct StudyNet {
    /// Which one.
    pub net: String,
    /// How it was trained.
    pub trainer: String,
    /// How it learned, where that was recorded.
    pub curve: Option<LearningCurve>,
}

impl StudyNet {
    /// What a legend states: most nets beside the four published ones have the name of their trainer.
    #[must_use]
    pub fn name(&self) -> String {
        let (net, trainer) = (&self.net, &self.trainer);
        if trainer.replace('-', "") == *net { trainer.clone() } else { format!("{net} {trainer}") }
    }
}

/// Mean squared errors over epochs; `None` where an error is no number.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct LearningCurve {
    /// Epochs.
    pub epoch: Vec<f64>,
    /// On the rows of the training.
    pub train: Vec<Option<f64>>,
    /// On unseen rows.
    pub test: Vec<Option<f64>>,
}
