//! The label of the recording that is open, in the `labels.csv` beside it that `gripctl score` reads.

use grip_record::{CsvError, Label, LabelError, LabelKind, Relabel, read_labels, write_label};
use grip_scope::Span;
use slip_core::units::Micros;
use std::path::{Path, PathBuf};

/// What is wanted of the label of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Labelling {
    /// It begins to slip at cursor A.
    Onset,
    /// It slips all the time.
    Steady,
    /// It never slips.
    Rest,
    /// Take the label away.
    Remove,
}

/// A recording and the list that its label stands in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    file: PathBuf,
    name: String,
}

impl Place {
    /// Where the label of a recording stands; `None` where its name is no text.
    #[must_use]
    pub fn of(recording: &Path) -> Option<Self> {
        let name = recording.file_stem()?.to_str()?.to_owned();
        Some(Self { file: recording.with_file_name("labels.csv"), name })
    }

    /// The label that the recording has.
    ///
    /// # Errors
    /// Where the list cannot be read, or a row of it is not usable.
    pub fn read(&self) -> Result<Option<Label>, LabelError> {
        if !self.file.exists() {
            return Ok(None);
        }
        match read_labels(&self.file) {
            Ok(labels) => Ok(labels.into_iter().find(|label| label.recording == self.name)),
            Err(LabelError::Table(CsvError::NoRows { .. })) => Ok(None),
            Err(LabelError::Table(error)) if error.is_empty_file() => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Gives the recording a label, where it has none; a label that it has is given back and stays.
    ///
    /// # Errors
    /// As [`Place::read`], and where the list cannot be written.
    pub fn write(&self, kind: LabelKind, material: &str) -> Result<Option<Label>, LabelError> {
        let material = material.to_owned();
        let label = Label { recording: self.name.clone(), kind, material };
        write_label(&self.file, &label, Relabel::Keep)
    }

    /// Takes the label away: the one that went.
    ///
    /// # Errors
    /// As [`Place::write`].
    pub fn remove(&self) -> Result<Option<Label>, LabelError> {
        let (recording, material) = (self.name.clone(), String::new());
        let label = Label { recording, kind: LabelKind::Rest, material };
        write_label(&self.file, &label, Relabel::Remove)
    }
}

/// A label in words.
#[must_use]
pub fn words(kind: LabelKind) -> String {
    match kind {
        LabelKind::Onset { at } => format!("onset at {:.6} s", at.as_seconds()),
        kind => kind.word().to_owned(),
    }
}

/// The onset at a time of a recording.
///
/// # Errors
/// A sentence, where the time lies outside.
pub fn onset(at_s: f64, recording: Span) -> Result<LabelKind, String> {
    if !recording.holds(at_s) {
        let Span { from_s, to_s } = recording;
        return Err(format!(
            "Cursor A is at {at_s:.6} s: the recording goes from {from_s:.6} s to {to_s:.6} s."
        ));
    }
    Ok(LabelKind::Onset { at: Micros::from_seconds(at_s) })
}
