//! A model file and what is known of its training in, a model card as JSON out.
//!
//! The card states what a model takes and gives, in which units and ranges, from which rows it was made, how they were split, with
//! which seed, and how well it did. What is not known is `null`; nothing is guessed.
//!
//! | field | holds |
//! |---|---|
//! | `format`, `version` | `mlp-model-card`, 1 |
//! | `program` | name and version of the program that trained it |
//! | `model` | name and SHA-256 of the model file, layer sizes, activation functions, number of weights |
//! | `inputs`, `targets` | name, unit, transform, smallest and largest raw value of the training rows |
//! | `data` | `train` and `test`: name without folders and SHA-256 of the file, number of rows; `split`: how rows came to be test rows |
//! | `training` | algorithm, seed of the chosen run, runs it was chosen from, epochs, why it stopped, settings |
//! | `metrics` | `train` and `test`: errors of the saved model; `mse` in target units squared, `scaled_mse` where the training range is 2 wide, `within_*pct` shares of rows from 0 to 1; of classes `accuracy` and `cross_entropy` |
//! | `exports` | files made from the model, with SHA-256, and how a comparison with this model went |

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::train::file::FileColumn;
use crate::train::{DataSet, Evaluation, FileError, FitConfig, ModelFile, Precision};

/// Value of the field `format`.
pub const FORMAT: &str = "mlp-model-card";

/// Value of the field `version`.
pub const VERSION: u64 = 1;

/// A model card.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Card {
    format: String,
    version: u64,
    /// Name and version of the program that trained it, if known.
    #[serde(default)]
    pub program: Option<String>,
    /// The model file.
    pub model: CardModel,
    /// Features in the order the network takes them.
    pub inputs: Vec<FileColumn>,
    /// Targets in the order of the outputs.
    pub targets: Vec<FileColumn>,
    /// Rows it was made and tested with.
    pub data: CardData,
    /// How it was trained, if known.
    pub training: Option<CardTraining>,
    /// Errors of the saved model.
    pub metrics: CardMetrics,
    /// Files made from it.
    pub exports: Vec<CardExport>,
}

/// A file by name and contents.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CardFile {
    /// Name without folders.
    pub file: String,
    /// SHA-256 of its bytes in hexadecimal.
    pub sha256: String,
}

/// The model file and its shape.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CardModel {
    /// Name and contents.
    #[serde(flatten)]
    pub file: CardFile,
    /// Inputs, hidden layers, outputs.
    pub sizes: Vec<usize>,
    /// One per layer of weights.
    pub activations: Vec<String>,
    /// Weights and biases.
    pub weights: usize,
}

/// A set of rows; what is unknown is absent.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CardRows {
    /// Name of the file without folders.
    pub file: Option<String>,
    /// SHA-256 of its bytes in hexadecimal.
    pub sha256: Option<String>,
    /// Number of rows.
    pub rows: Option<usize>,
}

/// Rows of training and test.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct CardData {
    /// Rows it was trained on.
    pub train: Option<CardRows>,
    /// Rows it was tested on.
    pub test: Option<CardRows>,
    /// How rows came to be test rows.
    pub split: Option<String>,
}

/// How it was trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CardTraining {
    /// Training rule.
    pub algorithm: String,
    /// Seed of the chosen run.
    pub seed: u64,
    /// Runs from which it was chosen.
    pub repeats: usize,
    /// Epochs of the chosen run.
    pub epochs: usize,
    /// Why it stopped.
    pub stop: String,
    /// Precision of the training, `f32` or `f64`.
    pub precision: Option<String>,
    /// Penalty on large weights.
    pub decay: Option<f64>,
    /// Mean squared error in scaled units that was good enough.
    pub goal: Option<f64>,
    /// Most epochs allowed.
    pub max_epochs: Option<usize>,
}

/// Errors on the rows of training and test.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CardMetrics {
    /// On the training rows.
    pub train: Option<CardErrors>,
    /// On the test rows.
    pub test: Option<CardErrors>,
}

/// Errors on some rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CardErrors {
    /// Mean squared error in target units squared.
    pub mse: f64,
    /// The same in scaled units.
    pub scaled_mse: Option<f64>,
    /// Share of values within 5 % of the target.
    pub within_5pct: Option<f64>,
    /// Share of values within 10 % of the target.
    pub within_10pct: Option<f64>,
    /// Share of values within 20 % of the target.
    pub within_20pct: Option<f64>,
    /// Rows with a feature outside the training range.
    pub extrapolated: Option<usize>,
    /// Share of the classes that were right, where there are classes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<f64>,
    /// Mean of `-ln p` of the right classes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross_entropy: Option<f64>,
}

/// Files made from the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CardExport {
    /// `c99` or `onnx`.
    pub kind: String,
    /// The files.
    pub files: Vec<CardFile>,
    /// The comparison, if one was made.
    pub verified: Option<CardVerified>,
}

/// A comparison of an export with the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CardVerified {
    /// Feature vectors compared.
    pub inputs: usize,
    /// Largest difference of a target, in scaled units.
    pub largest_difference: f64,
    /// Its bound at that place.
    pub bound: f64,
}

impl CardFile {
    /// `name` without folders, and the hash of `bytes`.
    #[must_use]
    pub fn new(name: &str, bytes: &[u8]) -> Self {
        let sha256 = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        Self { file: base(name), sha256 }
    }
}

impl From<&Evaluation> for CardErrors {
    fn from(errors: &Evaluation) -> Self {
        Self {
            mse: errors.mse,
            scaled_mse: Some(errors.scaled_mse),
            within_5pct: Some(errors.within_fraction(0.05)),
            within_10pct: Some(errors.within_fraction(0.1)),
            within_20pct: Some(errors.within_fraction(0.2)),
            extrapolated: Some(errors.extrapolated),
            accuracy: errors.classes.map(|classes| classes.accuracy),
            cross_entropy: errors.classes.map(|classes| classes.cross_entropy),
        }
    }
}

impl From<&DataSet> for CardRows {
    fn from(data: &DataSet) -> Self {
        let (file, sha256) = (Some(base(&data.file)), Some(data.sha256.clone()));
        Self { file, sha256, rows: Some(data.rows()) }
    }
}

impl Card {
    /// What the model file itself reports: `name` and `text` are its name and contents.
    #[must_use]
    pub fn new(file: &ModelFile, name: &str, text: &str) -> Self {
        let widths = file.layers.iter().map(|layer| layer.biases.len());
        let sizes: Vec<usize> = core::iter::once(file.inputs.len()).chain(widths).collect();
        let mut card = Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            program: None,
            model: CardModel {
                file: CardFile::new(name, text.as_bytes()),
                weights: crate::network::weight_count(&sizes),
                sizes,
                activations: file.layers.iter().map(|l| l.activation.to_string()).collect(),
            },
            inputs: file.inputs.clone(),
            targets: file.targets.clone(),
            data: CardData::default(),
            training: None,
            metrics: CardMetrics::default(),
            exports: Vec::new(),
        };
        if let Some(note) = &file.training {
            let (sha256, rows) = (Some(note.data_sha256.clone()), Some(note.rows));
            card.data.train = Some(CardRows { file: None, sha256, rows });
            let errors = |mse, scaled_mse| CardErrors {
                mse,
                scaled_mse,
                within_5pct: None,
                within_10pct: None,
                within_20pct: None,
                extrapolated: None,
                accuracy: None,
                cross_entropy: None,
            };
            card.metrics.train = Some(errors(note.train_mse, Some(note.train_scaled_mse)));
            card.metrics.test = note.test_mse.map(|mse| errors(mse, note.test_scaled_mse));
            card.training = Some(CardTraining {
                algorithm: note.algorithm.clone(),
                seed: note.seed,
                repeats: note.repeats,
                epochs: note.epochs,
                stop: note.stop.clone(),
                precision: None,
                decay: None,
                goal: None,
                max_epochs: None,
            });
        }
        card
    }

    /// Adds name and version of the program that trained it.
    #[must_use]
    pub fn with_program(self, program: &str) -> Self {
        Self { program: Some(program.to_owned()), ..self }
    }

    /// Adds the settings of the training.
    #[must_use]
    pub fn with_settings(mut self, config: &FitConfig) -> Self {
        if let Some(training) = &mut self.training {
            let precision = match config.precision {
                Precision::Single => "f32",
                Precision::Double => "f64",
            };
            training.precision = Some(precision.to_owned());
            training.decay = Some(config.decay);
            training.goal = Some(config.run.goal);
            training.max_epochs = Some(config.run.epochs);
        }
        self
    }

    /// Adds the training rows and the errors on them.
    #[must_use]
    pub fn with_train(mut self, data: &DataSet, errors: &Evaluation) -> Self {
        (self.data.train, self.metrics.train) = (Some(data.into()), Some(errors.into()));
        self
    }

    /// Adds the test rows and the errors on them.
    #[must_use]
    pub fn with_test(mut self, data: &DataSet, errors: &Evaluation) -> Self {
        (self.data.test, self.metrics.test) = (Some(data.into()), Some(errors.into()));
        self
    }

    /// Reports how rows came to be test rows.
    #[must_use]
    pub fn with_split(mut self, split: &str) -> Self {
        self.data.split = Some(split.to_owned());
        self
    }

    /// Adds an export, in place of an earlier one of the same kind.
    #[must_use]
    pub fn with_export(mut self, export: CardExport) -> Self {
        self.exports.retain(|other| other.kind != export.kind);
        self.exports.push(export);
        self
    }

    /// Reads the text of a card; `None` when it is no card of this version.
    #[must_use]
    pub fn from_json(text: &str) -> Option<Self> {
        let card: Self = serde_json::from_str(text).ok()?;
        (card.format == FORMAT && card.version == VERSION).then_some(card)
    }

    /// Whether it is the card of the model file with the contents `text`.
    #[must_use]
    pub fn is_of(&self, text: &str) -> bool {
        self.model.file.sha256 == CardFile::new("", text.as_bytes()).sha256
    }

    /// The text of the card.
    ///
    /// # Errors
    /// [`FileError::Json`], which no card is known to cause.
    pub fn to_json(&self) -> Result<String, FileError> {
        let fault = |error: serde_json::Error| FileError::Json {
            line: error.line(),
            column: error.column(),
            message: error.to_string(),
        };
        Ok(serde_json::to_string_pretty(self).map_err(fault)? + "\n")
    }
}

/// A file name without its folders.
fn base(name: &str) -> String {
    name.rsplit(['/', '\\']).next().unwrap_or(name).to_owned()
}

#[cfg(test)]
mod tests {
    use super::super::test_models;
    use super::*;

    #[test]
    fn a_card_reports_the_shape_and_is_read_back() {
        let file = &test_models::all()[4];
        let text = file.to_json().unwrap();
        let export = CardExport { kind: "c99".into(), files: Vec::new(), verified: None };
        let card = Card::new(file, "some/where/m.json", &text)
            .with_split("by hand")
            .with_export(export.clone())
            .with_export(export);
        assert_eq!((card.model.file.file.as_str(), card.exports.len()), ("m.json", 1));
        assert_eq!((card.model.sizes.clone(), card.model.weights), (vec![4, 6, 5, 4], 89));
        assert_eq!(card.inputs, file.inputs);
        assert!(card.training.is_none() && card.metrics.train.is_none(), "nothing is guessed");
        let again = Card::from_json(&card.to_json().unwrap()).unwrap();
        assert_eq!(again, card);
        assert!(again.is_of(&text) && !again.is_of("other"));
        assert_eq!(Card::from_json(&text), None, "a model is no card");
    }
}
