//! Model file: a trained network as JSON text, and back to a [`Model`].
//!
//! ```json
//! {
//!   "format": "mlp-model", "version": 1,
//!   "inputs": [{ "name": "v_m_s", "unit": "m/s", "transform": "identity", "min": 0.01, "max": 0.3 }],
//!   "targets": [{ "name": "f_n", "unit": "N", "transform": "ln", "min": 1.0, "max": 40.0 }],
//!   "layers": [
//!     { "activation": "tanh", "weights": [[0.5], [-0.25]], "biases": [0.1, 0.2] },
//!     { "activation": "linear", "weights": [[1.0, 2.0]], "biases": [0.0] }
//!   ],
//!   "training": null
//! }
//! ```
//! `min` and `max` are raw values; `weights` has one row per neuron. `"interval": { "level": 0.9, "widths": [1.2], "from": "10 parts of 100
//! rows" }` may stand beside them ([`Interval`]): 90 % of the forces lie between answer / 1.2 and 1.2 answer. Unknown fields are ignored. Limits are
//! written with as many digits as bring back the same `f64`, weights the same `f32`.

use serde::{Deserialize, Serialize};

use crate::{
    activation::Activation,
    column::ColumnSpec,
    interval::Interval,
    model::{Column, Model, ScaleError, Scaler, Transform},
    network::{Network, ShapeError},
    topology::{MOST_INPUTS, MOST_OUTPUTS, Topology},
};

/// Value of the field `format`.
pub const FORMAT: &str = "mlp-model";

/// Value of the field `version` that this crate reads and writes.
pub const VERSION: u64 = 1;

pub use crate::model::rounded;

/// Why a text is no model, or a model can not be saved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FileError {
    /// Not JSON, or a field is missing or of the wrong kind.
    #[error("line {line}, column {column}: {message}")]
    Json {
        /// Line, counted from 1; 0 when the text ended too early to know.
        line: usize,
        /// Column, counted from 1.
        column: usize,
        /// What is wrong there.
        message: String,
    },
    /// JSON of some other kind.
    #[error("format is {found:?}, not \"mlp-model\"")]
    Format {
        /// The field `format`, if there is one.
        found: Option<String>,
    },
    /// An ensemble without members.
    #[error("the ensemble has no members")]
    NoMembers,
    /// A member of an ensemble that has other columns than the first one.
    #[error("member {member} of the ensemble has other columns than the first")]
    Member {
        /// Its place, counted from 1.
        member: usize,
    },
    /// Another version of the format.
    #[error("version is {found:?}: this program reads version {VERSION}")]
    Version {
        /// The field `version`, if there is one.
        found: Option<u64>,
    },
    /// A row of weights, or the biases, of another length than the layers ask for.
    #[error("layer {layer}: {given} {what} where {needed} are needed")]
    Length {
        /// Layer of weights, counted from 1.
        layer: usize,
        /// Weights of which neuron, or biases.
        what: String,
        /// As many as the layer before has values, or this one neurons.
        needed: usize,
        /// As many as there are.
        given: usize,
    },
    /// Limits that can not be scaled.
    #[error("{kind}{}: {source}", if name.is_empty() { String::new() } else { format!(" \"{name}\"") })]
    Scale {
        /// `input` or `target`.
        kind: &'static str,
        /// Name of the column.
        name: String,
        /// What is wrong; its column number counts from 0.
        source: ScaleError,
    },
    /// A classifier where a number is to be estimated.
    #[error("it tells {classes} classes apart and estimates nothing")]
    Classifier {
        /// Its classes.
        classes: usize,
    },
    /// An interval without a level between 0 and 1, or without a possible width for each target.
    #[error("interval: a level between 0 and 1 and a width for each target are needed")]
    Interval,
    /// Sizes beyond the limits of a network, or layers that do not match the columns.
    #[error(transparent)]
    Shape(#[from] ShapeError),
}

/// One input or target of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FileColumn {
    /// Name of the CSV column.
    pub name: String,
    /// Its unit, empty when unknown.
    pub unit: String,
    /// Applied before scaling.
    pub transform: Transform,
    /// Smallest raw training value.
    pub min: f64,
    /// Largest raw training value.
    pub max: f64,
    /// Of a reciprocal target the [noise](Column::noise) of the rows; 0 and absent elsewhere.
    #[serde(default, skip_serializing_if = "is_none")]
    pub noise: f32,
}

impl FileColumn {
    /// What scales it.
    #[must_use]
    pub const fn column(&self) -> Column {
        Column { transform: self.transform, min: self.min, max: self.max, noise: self.noise }
    }

    /// Keeps the variance of the noise (scaled units squared) where answers need it.
    pub fn set_noise(&mut self, variance: f64) {
        if self.transform == Transform::Reciprocal {
            let [low, high] = [self.min, self.max].map(|raw| self.transform.forward(raw));
            let noise = rounded(0.5 * (high - low) * variance.sqrt());
            self.noise = if noise.is_finite() { noise } else { 0.0 };
        }
    }
}

/// By reference, as serde asks.
fn is_none(noise: &f32) -> bool {
    *noise == 0.0
}

/// One layer of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FileLayer {
    /// Function of its neurons.
    pub activation: Activation,
    /// One row per neuron.
    pub weights: Vec<Vec<f32>>,
    /// One per neuron.
    pub biases: Vec<f32>,
}

/// How the network was trained; errors are those of the saved model.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TrainingNote {
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
    /// Training rows.
    pub rows: usize,
    /// SHA-256 of the training file.
    pub data_sha256: String,
    /// Training error in raw units squared.
    pub train_mse: f64,
    /// Training error in scaled units squared.
    pub train_scaled_mse: f64,
    /// Test error in raw units squared.
    pub test_mse: Option<f64>,
    /// Test error in scaled units squared.
    pub test_scaled_mse: Option<f64>,
    /// How rows of the training file were kept away from the training, if any were.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub split: Option<SplitNote>,
}

/// How the rows of one file were split. `data_sha256` of the [`TrainingNote`] is that of the whole file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SplitNote {
    /// Column whose groups of equal text stayed together; rows were split one by one without it.
    pub by: Option<String>,
    /// Seed of the split.
    pub seed: u64,
    /// Share of the rows that was asked for as test rows.
    pub holdout: Option<f64>,
    /// Share of the remaining rows that was asked for as validation rows.
    pub validation: Option<f64>,
}

/// Contents of a model file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelFile {
    format: String,
    version: u64,
    /// Features in the order the network takes them.
    pub inputs: Vec<FileColumn>,
    /// Targets in the order of the outputs.
    pub targets: Vec<FileColumn>,
    /// Layers of weights, first to last.
    pub layers: Vec<FileLayer>,
    /// Of a classifier, the column whose text is the class. Its targets are the classes, and the network's outputs, which
    /// their limits of -1 and 1 leave as they are, are scores: softmax makes probabilities of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub classes: Option<String>,
    /// How far the truth may be from an answer, where that was measured on rows that the network had not seen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<Interval>,
    /// How it was trained, if known.
    pub training: Option<TrainingNote>,
}

/// A model of any size that can be trained.
pub type LargeModel<W = Box<[f32]>> = Model<W, MOST_INPUTS, MOST_INPUTS>;

/// By how much answers are off (one standard deviation).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Deviation {
    /// In the unit of the target.
    Absolute(f32),
    /// Of the logarithm of the answer, which for small ones is the share of it.
    Relative(f32),
}

/// What a text states it is.
#[derive(Deserialize)]
pub(crate) struct Head {
    pub(crate) format: Option<String>,
    version: Option<u64>,
}

impl Head {
    fn is(self, format: &str, version: u64) -> Result<(), FileError> {
        let Self { format: found, version: found_version } = self;
        if found.as_deref() != Some(format) {
            return Err(FileError::Format { found });
        }
        if found_version != Some(version) {
            return Err(FileError::Version { found: found_version });
        }
        Ok(())
    }
}

/// Whether a text states that it is of this format and version.
///
/// # Errors
/// [`FileError::Json`], [`FileError::Format`] or [`FileError::Version`].
pub fn check_head(text: &str, format: &str, version: u64) -> Result<(), FileError> {
    serde_json::from_str::<Head>(text)?.is(format, version)
}

impl ModelFile {
    /// Rounds `weights` (flat order, as many as `topology` has) to `f32`.
    #[must_use]
    pub fn new(
        inputs: &[FileColumn],
        targets: &[FileColumn],
        topology: &Topology,
        weights: &[f64],
    ) -> Self {
        let round = |values: &[f64]| values.iter().copied().map(rounded).collect::<Vec<f32>>();
        let layers = topology.layers().map(|layer| FileLayer {
            activation: layer.activation,
            weights: weights[layer.start..layer.biases()]
                .chunks_exact(layer.from)
                .map(round)
                .collect(),
            biases: round(&weights[layer.biases()..layer.end()]),
        });
        Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            inputs: inputs.to_vec(),
            targets: targets.to_vec(),
            layers: layers.collect(),
            classes: None,
            interval: None,
            training: None,
        }
    }

    /// Reads and checks the text of a model file.
    ///
    /// # Errors
    /// Any [`FileError`]; the first fault found.
    pub fn from_json(text: &str) -> Result<Self, FileError> {
        check_head(text, FORMAT, VERSION)?;
        let file: Self = serde_json::from_str(text)?;
        file.large_model()?;
        Ok(file)
    }

    /// Whether it is a valid model of this format, where it was read as a part of another file.
    pub(crate) fn check(&self) -> Result<(), FileError> {
        let head = Head { format: Some(self.format.clone()), version: Some(self.version) };
        head.is(FORMAT, VERSION)?;
        self.large_model().map(drop)
    }

    /// The text of the file.
    ///
    /// # Errors
    /// Any [`FileError`] but those of reading, when the contents are no valid model.
    pub fn to_json(&self) -> Result<String, FileError> {
        self.large_model()?;
        Ok(serde_json::to_string_pretty(self)?)
    }

    /// The model, for estimates in memory of a fixed size.
    ///
    /// # Errors
    /// Any [`FileError`] but those of reading, when the contents are no valid model, are too large for gripd, or distinguish classes
    /// apart.
    pub fn model(&self) -> Result<Model<Box<[f32]>>, FileError> {
        self.model_in()
    }

    /// The same with the weights in another kind of memory, for example shared.
    ///
    /// # Errors
    /// As [`ModelFile::model`].
    pub fn model_in<W: AsRef<[f32]> + From<Vec<f32>>>(&self) -> Result<Model<W>, FileError> {
        match self.classes {
            Some(_) => Err(FileError::Classifier { classes: self.targets.len() }),
            None => self.model_within(),
        }
    }

    /// The model, whatever its size and whether or not it is a classifier.
    ///
    /// # Errors
    /// Any [`FileError`] but those of reading, when the contents are no valid model.
    pub fn large_model(&self) -> Result<LargeModel, FileError> {
        if self.targets.len() > MOST_OUTPUTS {
            let (layer, given) = (self.layers.len(), self.targets.len());
            return Err(ShapeError::Width { layer, given, limit: MOST_OUTPUTS }.into());
        }
        if let Some(interval) = &self.interval {
            interval.check(&self.targets)?;
        }
        self.model_within()
    }

    fn model_within<W, const IO: usize, const WIDTH: usize>(
        &self,
    ) -> Result<Model<W, IO, WIDTH>, FileError>
    where
        W: AsRef<[f32]> + From<Vec<f32>>,
    {
        let mut sizes = vec![self.inputs.len()];
        let mut weights = Vec::new();
        for (layer, contents) in self.layers.iter().enumerate() {
            append_layer(layer + 1, contents, sizes[layer], &mut weights)?;
            sizes.push(contents.weights.len());
        }
        let activations: Vec<Activation> =
            self.layers.iter().map(|layer| layer.activation).collect();
        let network = Network::within(&sizes, &activations, weights.into())?;
        let (inputs, targets) = (scaler("input", &self.inputs)?, scaler("target", &self.targets)?);
        Ok(Model::new(network, inputs, targets)?)
    }

    /// How far its answers were off, as a standard deviation: on the test rows, or on the training rows where there were no test rows; nothing
    /// where the file does not state how it was trained. Over all targets; the first one states whether it is relative.
    #[must_use]
    pub fn deviation(&self) -> Option<Deviation> {
        let (note, target) = (self.training.as_ref()?, self.targets.first()?);
        let scaled = note.test_scaled_mse.unwrap_or(note.train_scaled_mse).max(0.0).sqrt();
        let (transform, min, max) = (target.transform, target.min, target.max);
        let transformed = 0.5 * (transform.forward(max) - transform.forward(min)) * scaled;
        Some(match transform {
            Transform::Identity => Deviation::Absolute(rounded(transformed)),
            Transform::Ln => Deviation::Relative(rounded(transformed)),
            // It grows with the answer: that of the largest.
            Transform::Reciprocal => Deviation::Relative(rounded(transformed * max)),
        })
    }

    /// The column specs with which a CSV file is read for this model.
    #[must_use]
    pub fn specs(&self) -> (Vec<ColumnSpec>, Vec<ColumnSpec>) {
        let specs = |columns: &[FileColumn]| {
            columns
                .iter()
                .map(|column| ColumnSpec { name: column.name.clone(), transform: column.transform })
                .collect()
        };
        (specs(&self.inputs), specs(&self.targets))
    }
}

fn append_layer(
    layer: usize,
    contents: &FileLayer,
    needed: usize,
    weights: &mut Vec<f32>,
) -> Result<(), FileError> {
    let check = |what: &dyn Fn() -> String, needed, given| match needed == given {
        true => Ok(()),
        false => Err(FileError::Length { layer, what: what(), needed, given }),
    };
    for (at, row) in contents.weights.iter().enumerate() {
        check(&|| format!("weights of neuron {}", at + 1), needed, row.len())?;
        weights.extend(row);
    }
    check(&|| "biases".to_owned(), contents.weights.len(), contents.biases.len())?;
    weights.extend(&contents.biases);
    Ok(())
}

fn scaler<const IO: usize>(
    kind: &'static str,
    columns: &[FileColumn],
) -> Result<Scaler<IO>, FileError> {
    let limits: Vec<Column> = columns.iter().map(FileColumn::column).collect();
    Scaler::within(&limits).map_err(|source| {
        let place = match source {
            ScaleError::Columns { .. } => None,
            ScaleError::Limits { column, .. }
            | ScaleError::Noise { column, .. }
            | ScaleError::LogOfNonPositive { column, .. } => columns.get(column),
        };
        FileError::Scale { kind, name: place.map_or(String::new(), |c| c.name.clone()), source }
    })
}

impl From<serde_json::Error> for FileError {
    fn from(error: serde_json::Error) -> Self {
        let (line, column, text) = (error.line(), error.column(), error.to_string());
        let place = format!(" at line {line} column {column}");
        let message = text.strip_suffix(&place).unwrap_or(&text).to_owned();
        Self::Json { line, column, message }
    }
}

#[cfg(test)]
mod tests;
