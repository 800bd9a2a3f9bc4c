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

    /// Its first and last time.
    fn span(&self) -> Option<[i64; 2]> {
        let Times::Stamps(times) = &self.times else { return None };
        Some([*times.iter().min()?, *times.iter().max()?])
    }

    fn overlaps(&self, span: Option<[i64; 2]>) -> bool {
        let apart = |[own, other]: [[i64; 2]; 2]| own[1] < other[0] || other[1] < own[0];
        !self.span().zip(span).is_some_and(|(own, other)| apart([own, other]))
    }

    /// Whether the other has the same topic, fields and kind of times.
    fn is_of_kind(&self, other: &Self) -> bool {
        self.topic == other.topic
            && self.clock == other.clock
            && self.names.len() == other.names.len()
            && self.names.iter().all(|name| other.names.contains(name))
    }

    /// Puts the rows of another of its kind before or behind its own.
    fn join(&mut self, mut other: Self) {
        let (rows, more) = (self.rows(), other.rows());
        if other.span() < self.span() {
            core::mem::swap(self, &mut other);
        }
        self.notes.append(&mut other.notes);
        self.notes.push(format!(
            "{}: {rows} and {more} rows under two types, one after the other, were joined",
            self.topic
        ));
        if let (Times::Stamps(times), Times::Stamps(others)) = (&mut self.times, other.times) {
            times.extend(others);
        }
        for (name, values) in self.names.iter().zip(&mut self.values) {
            let at = other.names.iter().position(|other| other == name);
            values.extend(at.and_then(|at| other.values.get(at)).into_iter().flatten());
        }
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

/// Streams of one topic under several types, as of a publisher of another version, in one, where one begins when the other has
/// ended. Streams that still share names are numbered, so that nothing is taken from one of them unasked.
pub(crate) fn joined(streams: Vec<Stream>) -> Vec<Stream> {
    let mut out: Vec<Stream> = Vec::new();
    for stream in streams {
        let span = stream.span();
        match out.iter_mut().find(|first| first.is_of_kind(&stream) && !first.overlaps(span)) {
            Some(first) => first.join(stream),
            None => out.push(stream),
        }
    }
    let names: Vec<Vec<String>> = out.iter().map(|stream| stream.names.clone()).collect();
    let shares = |at: usize| {
        let mut others = names.iter().enumerate().filter(|(other, _)| *other != at);
        others.any(|(_, other)| {
            names.get(at).is_some_and(|own| own.iter().any(|n| other.contains(n)))
        })
    };
    let sharing = out.iter_mut().enumerate().filter(|(at, _)| shares(*at));
    for (number, (_, stream)) in sharing.enumerate() {
        let topic = format!("{}#{}", stream.topic, number + 1);
        for name in &mut stream.names {
            *name = format!("{topic}{}", name.strip_prefix(&stream.topic).unwrap_or(name));
        }
        let rows = stream.rows();
        stream.notes.push(format!(
            "{topic}: {rows} rows of {} under one of several types at the same time or with other fields",
            stream.topic
        ));
        stream.topic = topic;
    }
    out
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
