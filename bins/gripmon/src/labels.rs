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

/// The recording that is open, and the list that its label stands in.
#[derive(Clone, Debug)]
pub struct Labelled {
    file: PathBuf,
    name: String,
    /// The label that it has.
    pub label: Option<Label>,
    /// The material of the label that was removed last: the next one is of the same.
    material: String,
}

impl Labelled {
    /// A recording whose label was not looked for; `None` where its name is no text.
    #[must_use]
    pub fn of(recording: &Path) -> Option<Self> {
        let name = recording.file_stem()?.to_str()?.to_owned();
        let file = recording.with_file_name("labels.csv");
        Some(Self { file, name, label: None, material: String::new() })
    }

    /// Looks for the label that it has.
    ///
    /// # Errors
    /// Where the list cannot be read, or a row of it is not usable.
    pub fn look(&mut self) -> Result<(), LabelError> {
        self.label = match read_labels(&self.file) {
            _ if !self.file.exists() => None,
            Ok(labels) => labels.into_iter().find(|label| label.recording == self.name),
            Err(LabelError::Table(CsvError::NoRows { .. })) => None,
            Err(LabelError::Table(error)) if error.is_empty_file() => None,
            Err(error) => return Err(error),
        };
        Ok(())
    }

    /// Gives it a label, or takes the one away that it has; one that is there is not replaced. What was done.
    ///
    /// # Errors
    /// A sentence, where it was not done.
    pub fn set(&mut self, kind: Option<LabelKind>) -> Result<String, String> {
        let how = if kind.is_some() { Relabel::Keep } else { Relabel::Remove };
        let (recording, material) = (self.name.clone(), self.material.clone());
        let label = Label { recording, kind: kind.unwrap_or(LabelKind::Rest), material };
        let old = write_label(&self.file, &label, how).map_err(|error| error.to_string())?;
        self.look().map_err(|error| error.to_string())?;
        match (kind, old) {
            (Some(_), Some(old)) => {
                let had = words(old.kind);
                Err(format!("The recording has a label already ({had}): remove it first."))
            }
            (Some(kind), None) => Ok(format!("Labelled: {}.", words(kind))),
            (None, None) => Err("The recording has no label.".to_owned()),
            (None, Some(old)) => {
                self.material = old.material;
                Ok(format!("No label any more; it was {}.", words(old.kind)))
            }
        }
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
