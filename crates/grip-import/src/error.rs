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
         `sox {} -r 48000 slower.wav`",
        file.display(), PipelineConfig::HIGHEST_RATE_HZ, file.display()
    )]
    TooFast {
        /// The file.
        file: PathBuf,
        /// Its rate (Hz).
        rate_hz: f32,
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
