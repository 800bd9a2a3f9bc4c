//! Why a file cannot be imported: what is wrong, and what to do about it.

use grip_record::{CsvError, mcap::McapError};
use slip_core::PipelineConfig;
use std::{
    io,
    path::{Path, PathBuf},
};

/// Why a file cannot be imported.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file is missing or cannot be read.
    #[error("{}: cannot be read ({source})", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the operating system states.
        source: io::Error,
    },
    /// The file is not what its name states, or not of a kind that is read.
    #[error("{}: {what}", file.display())]
    Unusable {
        /// The file.
        file: PathBuf,
        /// What is wrong, and what helps.
        what: String,
    },
    /// An MCAP file that is no MCAP file, or damaged.
    #[error(transparent)]
    Mcap(#[from] McapError),
    /// The channels make no recording.
    #[error(transparent)]
    Recording(#[from] CsvError),
    /// More numbers than are kept.
    #[error("{}: more than {} numbers; choose topics with --topic, or cut the file", file.display(), crate::MOST_VALUES)]
    TooLarge {
        /// The file.
        file: PathBuf,
    },
    /// More samples a second than a pipeline takes.
    #[error(
        "{}: has {rate_hz:.0} samples a second, at most {:.0} are used; resample it and import that, for example \
         `sox FILE.wav -r 48000 FILE-48k.wav`",
        file.display(), PipelineConfig::HIGHEST_RATE_HZ
    )]
    TooFast {
        /// The file.
        file: PathBuf,
        /// Its rate (Hz).
        rate_hz: f32,
    },
    /// No signal of the file is known to show a slip.
    #[error(
        "{}: nothing was taken for a vibration, a stylus, a travel or taxels; say which it is, for example --map vibration={}; the file \
         has: {}",
        file.display(), found.first().map_or("NAME", String::as_str), shortened(found)
    )]
    NoSignal {
        /// The file.
        file: PathBuf,
        /// The signals there are.
        found: Vec<String>,
    },
    /// Several signals could be the one.
    #[error(
        "{}: {what} may be any of {}; choose one with --map {ours}=NAME",
        file.display(), shortened(found)
    )]
    Ambiguous {
        /// The file.
        file: PathBuf,
        /// What is looked for.
        what: &'static str,
        /// Its name among the columns.
        ours: &'static str,
        /// What could be it.
        found: Vec<String>,
    },
    /// A renaming of something that is not there.
    #[error("{}: --map {ours}={theirs}: no such signal; the file has: {}", file.display(), shortened(found))]
    NotThere {
        /// The file.
        file: PathBuf,
        /// The left side.
        ours: String,
        /// The right side.
        theirs: String,
        /// The signals there are.
        found: Vec<String>,
    },
}

impl ImportError {
    pub(crate) fn nothing(file: &Path, what: &str) -> Self {
        Self::Unusable { file: file.to_owned(), what: what.to_owned() }
    }

    pub(crate) fn unreadable(file: &Path) -> impl Fn(io::Error) -> Self + '_ {
        |source| Self::Unreadable { file: file.to_owned(), source }
    }
}

/// The first names: a bag may have hundreds.
fn shortened(names: &[String]) -> String {
    const MOST: usize = 40;
    let shown = names.iter().take(MOST).cloned().collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}
