//! Model card as JSON, from a model file and what is known of its training.
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

use crate::train::file::FileColumn;
use crate::train::{DataSet, Evaluation, FileError, FitConfig, ModelFile, Precision, sha256};

/// Value of the field `format`.
pub const FORMAT: &str = "mlp-model-card";

/// Value of the field `version`.
pub const VERSION: u64 = 1;

/// A model card; its parts are those of the table above.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Card {
    format: String,
    version: u64,
    #[serde(default)]
    program: Option<String>,
    model: Shape,
    inputs: Vec<FileColumn>,
    targets: Vec<FileColumn>,
    data: Data,
    training: Option<Training>,
    metrics: Metrics,
    exports: Vec<CardExport>,
}

/// A file by name and contents.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CardFile {
    /// Name without folders.
    pub file: String,
    /// SHA-256 of its bytes in hexadecimal.
    pub sha256: String,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Shape {
    #[serde(flatten)]
    file: CardFile,
    sizes: Vec<usize>,
    activations: Vec<String>,
    weights: usize,
}

/// What is unknown is absent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Rows {
    file: Option<String>,
    sha256: Option<String>,
    rows: Option<usize>,
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
struct Data {
    train: Option<Rows>,
    test: Option<Rows>,
    split: Option<String>,
}

/// The settings are absent where only the model file is known.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
struct Training {
    algorithm: String,
    seed: u64,
    repeats: usize,
    epochs: usize,
    stop: String,
    precision: Option<String>,
    decay: Option<f64>,
    goal: Option<f64>,
    max_epochs: Option<usize>,
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
struct Metrics {
    train: Option<Errors>,
    test: Option<Errors>,
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
struct Errors {
    mse: f64,
    scaled_mse: Option<f64>,
    within_5pct: Option<f64>,
    within_10pct: Option<f64>,
    within_20pct: Option<f64>,
    extrapolated: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    accuracy: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cross_entropy: Option<f64>,
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
        Self { file: base(name), sha256: sha256(bytes) }
    }
}

impl From<&Evaluation> for Errors {
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

impl From<&DataSet> for Rows {
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
            model: Shape {
                file: CardFile::new(name, text.as_bytes()),
                weights: crate::network::weight_count(&sizes),
                sizes,
                activations: file.layers.iter().map(|l| l.activation.to_string()).collect(),
            },
            inputs: file.inputs.clone(),
            targets: file.targets.clone(),
            data: Data::default(),
            training: None,
            metrics: Metrics::default(),
            exports: Vec::new(),
        };
        if let Some(note) = &file.training {
            let (sha256, rows) = (Some(note.data_sha256.clone()), Some(note.rows));
            card.data.train = Some(Rows { file: None, sha256, rows });
            let errors = |mse, scaled_mse| Errors { mse, scaled_mse, ..Errors::default() };
            card.metrics.train = Some(errors(note.train_mse, Some(note.train_scaled_mse)));
            card.metrics.test = note.test_mse.map(|mse| errors(mse, note.test_scaled_mse));
            card.training = Some(Training {
                algorithm: note.algorithm.clone(),
                seed: note.seed,
                repeats: note.repeats,
                epochs: note.epochs,
                stop: note.stop.clone(),
                ..Training::default()
            });
        }
        card
    }

    /// Adds name and version of the program that trained it, and the settings of the training.
    #[must_use]
    pub fn with_settings(mut self, program: &str, config: &FitConfig) -> Self {
        self.program = Some(program.to_owned());
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

    /// Adds the rows of the training and of the test with the errors on them, and how rows came to be test rows.
    #[must_use]
    pub fn with_rows(
        mut self,
        train: (&DataSet, &Evaluation),
        test: Option<(&DataSet, &Evaluation)>,
        split: &str,
    ) -> Self {
        (self.data.train, self.metrics.train) = (Some(train.0.into()), Some(train.1.into()));
        if let Some((rows, errors)) = test {
            (self.data.test, self.metrics.test) = (Some(rows.into()), Some(errors.into()));
        }
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
        Ok(serde_json::to_string_pretty(self)? + "\n")
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
