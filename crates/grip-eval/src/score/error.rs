//! Why a folder of labelled recordings cannot be scored, with what to correct.

use super::network_test::UntrainedError;
use grip_record::{CsvError, LabelError, PhaseError};
use grip_session::tape::TapeError;
use slip_core::ConfigError;
use std::path::PathBuf;

/// Why a folder, or one detector on it, cannot be scored.
#[derive(Debug, thiserror::Error)]
pub enum ScoreError {
    /// The labels cannot be used.
    #[error(transparent)]
    Labels(#[from] LabelError),
    /// The phases cannot be used.
    #[error(transparent)]
    Phases(#[from] PhaseError),
    /// A recording cannot be used.
    #[error("{0}")]
    Recording(#[from] CsvError),
    /// A recording of everything cannot be used.
    #[error(transparent)]
    Tape(#[from] TapeError),
    /// What is scored is a folder.
    #[error("{}: not a folder; name one with labels.csv and its recordings", directory.display())]
    NoFolder {
        /// What was named.
        directory: PathBuf,
    },
    /// The folder has no labelled recording.
    #[error("{}: no recording is labelled; labels.csv needs a row for each", directory.display())]
    Nothing {
        /// The folder.
        directory: PathBuf,
    },
    /// A row about a recording that is not there.
    #[error("{}: the folder has no recording {recording:?}", file.display())]
    Absent {
        /// The file with the row.
        file: PathBuf,
        /// What it names.
        recording: String,
    },
    /// There are no labels, or an empty file.
    #[error(
        "{}: is missing or empty; `gripctl label` writes it, its first line is recording,kind,material,onset_s",
        file.display()
    )]
    Unlabelled {
        /// The file of the labels.
        file: PathBuf,
    },
    /// A recording that was read before is another one now.
    #[error("{recording} has changed while it was scored; score again when nothing writes to it")]
    Changed {
        /// The recording.
        recording: String,
    },
    /// An onset that the recording does not reach.
    #[error(
        "labels.csv: {recording}: the onset at {onset_s} s lies outside the recording ({first_s} to {last_s} s); correct onset_s"
    )]
    OnsetOutside {
        /// The recording.
        recording: String,
        /// The onset (s).
        onset_s: f64,
        /// Time of the first sample (s).
        first_s: f64,
        /// Time of the last sample (s).
        last_s: f64,
    },
    /// The settings do not fit a recording.
    #[error("{recording}: {source}")]
    Config {
        /// The recording.
        recording: String,
        /// What does not fit.
        source: ConfigError,
    },
    /// The calibration was made for another rate or stylus.
    #[error(transparent)]
    Calibration(#[from] grip_session::config::HostConfigError),
    /// No recording has what a detector looks at.
    #[error(
        "needs {needs}, which no recording of the folder has; leave {detector} out of --detectors"
    )]
    NoInput {
        /// The detector.
        detector: &'static str,
        /// What it looks at, and where that would be found.
        needs: &'static str,
    },
    /// A network cannot be trained for a material.
    #[error(
        "detector {detector} cannot be scored on material {material}, because the other materials do not train its network: {source}; label more of them, or leave it out of --detectors"
    )]
    Untrained {
        /// The detector.
        detector: &'static str,
        /// The material that would be scored.
        material: String,
        /// What is missing.
        source: Box<UntrainedError>,
    },
    /// No labelled rest to measure the floor on.
    #[error(
        "{}: no labelled rest to measure the noise floor on: no `rest` recording, and every onset lies within {guard_ms} ms of its start",
        directory.display()
    )]
    NoRest {
        /// The folder.
        directory: PathBuf,
        /// The guard before each onset.
        guard_ms: f64,
    },
}

impl ScoreError {
    /// Whether other detectors may still be scored.
    pub(super) fn is_of_one_detector(&self) -> bool {
        matches!(self, Self::NoInput { .. } | Self::Untrained { .. } | Self::NoRest { .. })
    }
}
