//! What is wrong with an MCAP file: where, and what to do about it.

use std::io;
use std::path::{Path, PathBuf};

use super::cdr::CdrError;
use super::schema::Topic;
use crate::error::shell;

/// Why an MCAP file could not be read (to its end). Offsets count bytes from the start of the file.
#[derive(Debug, thiserror::Error)]
pub enum McapError {
    /// The file is missing or cannot be read.
    #[error("{}: cannot be read ({source}); check the path and its permissions", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// The file does not begin as an MCAP file does.
    #[error("{}: is no MCAP file: it does not begin with the bytes of one", file.display())]
    NoMcap {
        /// The file.
        file: PathBuf,
    },
    /// The file holds topics or messages of others.
    #[error("{}: was not recorded by gripd: {what}", file.display())]
    Foreign {
        /// The file.
        file: PathBuf,
        /// What was found, and what can be done.
        what: String,
    },
    /// The file ends before its end: the program that wrote it was killed, or the disk was full.
    #[error(
        "{}: ends at byte {offset} without the end of a recording; `gripctl recover` makes a whole file of what is there",
        file.display()
    )]
    Truncated {
        /// The file.
        file: PathBuf,
        /// Where the last whole record ends.
        offset: u64,
    },
    /// Bytes that are not what they were.
    #[error("{}: is damaged at byte {offset}: {what}; `gripctl recover` saves what is whole", file.display())]
    Damaged {
        /// The file.
        file: PathBuf,
        /// Where the damaged record begins.
        offset: u64,
        /// What does not fit.
        what: String,
    },
    /// A message that is not what its schema states.
    #[error("{}: the message on {} in the record at byte {offset} cannot be read: {source}", file.display(), topic.name())]
    Message {
        /// The file.
        file: PathBuf,
        /// Where its chunk or record begins.
        offset: u64,
        /// Its topic.
        topic: Topic,
        /// What is wrong with it.
        source: CdrError,
    },
}

impl McapError {
    /// A file of another program, which goes through an import first.
    pub(super) fn foreign(file: &Path, what: &str) -> Self {
        let named = shell(&file.display().to_string());
        let what = format!("{what}; `gripctl import {named} -o run.mcap` makes a recording of it");
        Self::Foreign { file: file.to_owned(), what }
    }

    /// Where the damage begins (bytes from the start of the file), where it is damage and what lies behind it may be whole.
    #[must_use]
    pub const fn damaged_at(&self) -> Option<u64> {
        match self {
            Self::Truncated { offset, .. }
            | Self::Damaged { offset, .. }
            | Self::Message { offset, .. } => Some(*offset),
            Self::Unreadable { .. } | Self::NoMcap { .. } | Self::Foreign { .. } => None,
        }
    }
}

/// Why a recording cannot be written on.
#[derive(Debug, thiserror::Error)]
#[error("the recording cannot be written: {}", cause(.0))]
pub struct McapWriteError(#[from] pub(super) mcap::McapError);

/// What the operating system said, where it was asked.
fn cause(error: &mcap::McapError) -> String {
    match error {
        mcap::McapError::Io(error) => error.to_string(),
        other => other.to_string(),
    }
}

impl From<io::Error> for McapWriteError {
    fn from(error: io::Error) -> Self {
        Self(error.into())
    }
}
