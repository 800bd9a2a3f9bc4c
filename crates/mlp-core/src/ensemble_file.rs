//! Ensemble file: networks trained on the same rows as JSON text, and back to networks with common ranges.
//!
//! ```json
//! { "format": "ensemble-model", "version": 1, "members": [ .. files as of `file`, all with the same columns .. ] }
//! ```
//! `interval`, as in the file of a network, may stand beside them: that of the mean of their answers.
//!
//! Each member keeps its own note of training, with the hash of its rows. Members that saw rows drawn with replacement have
//! ranges of their own; [`EnsembleFile::aligned`] gives all of them the widest ones, so that one scaling serves them all.

use serde::{Deserialize, Serialize};

use crate::{
    file::{FileColumn, FileError, FileLayer, Head, ModelFile, check_head, rounded},
    interval::Interval,
};

/// Value of the field `format`.
pub const FORMAT: &str = "ensemble-model";

/// Value of the field `version` that this crate reads and writes.
pub const VERSION: u64 = 1;

/// Contents of an ensemble's file: at least one member, all with the same columns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EnsembleFile {
    format: String,
    version: u64,
    /// How far the truth may be from the mean of the answers, where that was measured on rows that no member had seen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<Interval>,
    members: Vec<ModelFile>,
}

/// Whether a text states that it holds an ensemble. A text that is no JSON does not.
#[must_use]
pub fn is_ensemble(text: &str) -> bool {
    serde_json::from_str::<Head>(text).is_ok_and(|head| head.format.as_deref() == Some(FORMAT))
}

impl EnsembleFile {
    /// Joins the files of the members.
    ///
    /// # Errors
    /// [`FileError::NoMembers`]; [`FileError::Member`] where one has other columns than the first.
    pub fn new(members: Vec<ModelFile>) -> Result<Self, FileError> {
        let Some(first) = members.first() else { return Err(FileError::NoMembers) };
        let differs = |file: &ModelFile| file.specs() != first.specs();
        match members.iter().position(differs) {
            Some(place) => Err(FileError::Member { member: place + 1 }),
            None => {
                Ok(Self { format: FORMAT.to_owned(), version: VERSION, interval: None, members })
            }
        }
    }

    /// Reads and checks the text of a file.
    ///
    /// # Errors
    /// Any [`FileError`]: of the file, of a member, or those of [`EnsembleFile::new`].
    pub fn from_json(text: &str) -> Result<Self, FileError> {
        check_head(text, FORMAT, VERSION)?;
        let Self { interval, members, .. } = serde_json::from_str(text)?;
        members.iter().try_for_each(ModelFile::check)?;
        let ensemble = Self::new(members)?;
        if let (Some(interval), Some(first)) = (&interval, ensemble.members.first()) {
            interval.check(&first.targets)?;
        }
        Ok(Self { interval, ..ensemble })
    }

    /// The text of the file.
    ///
    /// # Errors
    /// [`FileError::Json`].
    pub fn to_json(&self) -> Result<String, FileError> {
        Ok(serde_json::to_string_pretty(self)?)
    }

    /// The members as they were trained, at least one.
    #[must_use]
    pub fn members(&self) -> &[ModelFile] {
        &self.members
    }

    /// The members as they were trained.
    #[must_use]
    pub fn into_members(self) -> Vec<ModelFile> {
        self.members
    }

    /// The members with the widest ranges of all: the same answers but for the rounding of the first and the last layer, and to reciprocal
    /// targets that the noise is the mean of theirs.
    #[must_use]
    pub fn aligned(&self) -> Vec<ModelFile> {
        let all = |columns: fn(&ModelFile) -> &[FileColumn]| {
            let mut widest = self.members.first().map_or(Vec::new(), |file| columns(file).to_vec());
            for (file, so_far) in self.members.iter().zip(1_u16..) {
                for (wide, own) in widest.iter_mut().zip(columns(file)) {
                    wide.min = wide.min.min(own.min);
                    wide.max = wide.max.max(own.max);
                    wide.noise += (own.noise - wide.noise) / f32::from(so_far);
                }
            }
            widest
        };
        let (inputs, targets) = (all(|file| &file.inputs), all(|file| &file.targets));
        self.members.iter().map(|file| in_ranges(file, &inputs, &targets)).collect()
    }
}

/// The network of `file` for other limits of its columns: `scaled_own = slope scaled_new + offset`, taken up by the weights.
fn in_ranges(file: &ModelFile, inputs: &[FileColumn], targets: &[FileColumn]) -> ModelFile {
    let mut file = file.clone();
    let maps = |own: &[FileColumn], new: &[FileColumn]| -> Vec<[f64; 2]> {
        own.iter().zip(new).map(|(own, new)| map(own, new)).collect()
    };
    let (into, from) = (maps(&file.inputs, inputs), maps(targets, &file.targets));
    if let Some(first) = file.layers.first_mut() {
        take_inputs(first, &into);
    }
    if let Some(last) = file.layers.last_mut() {
        give_outputs(last, &from);
    }
    file.inputs = inputs.to_vec();
    file.targets = targets.to_vec();
    file
}

/// Slope and offset that turn a value scaled by `given` into one scaled by `wanted`; a constant column is scaled to 0.
fn map(wanted: &FileColumn, given: &FileColumn) -> [f64; 2] {
    let (wanted, given) = (middle_and_half(wanted), middle_and_half(given));
    if wanted[1] > 0.0 {
        [given[1] / wanted[1], (given[0] - wanted[0]) / wanted[1]]
    } else {
        [0.0, 0.0]
    }
}

/// Middle and half of the span of a column, transformed.
fn middle_and_half(column: &FileColumn) -> [f64; 2] {
    let [low, high] = [column.min, column.max].map(|raw| column.transform.forward(raw));
    [0.5 * (low + high), 0.5 * (high - low)]
}

fn take_inputs(layer: &mut FileLayer, maps: &[[f64; 2]]) {
    for (row, bias) in layer.weights.iter_mut().zip(&mut layer.biases) {
        let mut sum = f64::from(*bias);
        for (weight, [slope, offset]) in row.iter_mut().zip(maps) {
            sum += f64::from(*weight) * offset;
            *weight = rounded(f64::from(*weight) * slope);
        }
        *bias = rounded(sum);
    }
}

fn give_outputs(layer: &mut FileLayer, maps: &[[f64; 2]]) {
    for ((row, bias), [slope, offset]) in layer.weights.iter_mut().zip(&mut layer.biases).zip(maps)
    {
        for weight in row {
            *weight = rounded(f64::from(*weight) * slope);
        }
        *bias = rounded(f64::from(*bias) * slope + offset);
    }
}

#[cfg(test)]
mod tests;
