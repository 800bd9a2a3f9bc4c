//! Rows of named numbers with their times: what every format is read into.

use crate::error::ImportError;
use std::path::Path;

/// Most numbers that are kept of one file: 1 GiB of them.
pub const MOST_VALUES: usize = 1 << 28;

/// When the rows of a stream were measured.
#[derive(Clone, Debug, PartialEq)]
pub enum Times {
    /// At these times (ns), in the order of the file.
    Stamps(Vec<i64>),
    /// Only the caller knows.
    Unknown,
}

/// The signals that were measured together: a file, or one topic of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Stream {
    /// Topic, empty where the file has one stream.
    pub topic: String,
    /// Where the times come from, for people.
    pub clock: String,
    /// When.
    pub times: Times,
    /// Names of the signals, with the topic.
    pub names: Vec<String>,
    /// Unit of each signal, where the format knows it.
    pub units: Vec<Option<&'static str>>,
    /// What each is in a recording (`vibration`, `pressure_3`), where the format knows it.
    pub known: Vec<Option<String>>,
    /// Their readings, each as long as the others; NaN where a row has none.
    pub values: Vec<Vec<f32>>,
    /// Rows that were left out, and why.
    pub notes: Vec<String>,
}

impl Stream {
    /// A stream without rows.
    #[must_use]
    pub fn new(topic: &str, names: Vec<String>) -> Self {
        let width = names.len();
        Self {
            topic: topic.to_owned(),
            clock: String::new(),
            times: Times::Unknown,
            names,
            units: vec![None; width],
            known: vec![None; width],
            values: vec![Vec::new(); width],
            notes: Vec::new(),
        }
    }

    /// Rows there are.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.values.first().map_or(0, Vec::len)
    }

    /// Place of the signal `name`; appended, with NaN in the rows so far, where it is new.
    pub(crate) fn place(&mut self, name: &str, rows: usize) -> usize {
        if let Some(at) = self.names.iter().position(|other| other == name) {
            return at;
        }
        self.names.push(name.to_owned());
        self.units.push(None);
        self.known.push(None);
        self.values.push(vec![f32::NAN; rows]);
        self.names.len() - 1
    }
}

/// How many numbers may still be kept.
#[derive(Debug)]
pub(crate) struct Room(usize);

impl Default for Room {
    fn default() -> Self {
        Self(MOST_VALUES)
    }
}

impl Room {
    pub(crate) fn take(&mut self, file: &Path, numbers: usize) -> Result<(), ImportError> {
        self.0 = self
            .0
            .checked_sub(numbers)
            .ok_or_else(|| ImportError::TooLarge { file: file.to_owned() })?;
        Ok(())
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a reading has the 24 bits of an f32")]
pub(crate) const fn reading(value: f64) -> f32 {
    value as f32
}
