//! An error in; the exit code of the contract and the text for the person at the keyboard out.

use crate::{
    calibrate::CalibrationError, collect::CollectError, config::HostConfigError, model::ModelError,
    profile::ProfileError, scene::SceneFileError, score::ScoreError, tape::TapeError,
};
use core::error::Error;
use grip_record::{
    CsvError, LabelError, NpzError, PhaseError,
    mcap::{McapError, RecoverError},
};
use mlp::train::DataSetError;
use slip_core::ConfigError;
use std::process::ExitCode;

/// Arguments that the parser of the command line cannot check.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct WrongArgument(pub String);

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// 0: done.
    Done,
    /// 1: failed.
    Failed,
    /// 2: wrong arguments or configuration, or a file that cannot be read or is not what it has to be.
    WrongArguments,
    /// 3: done, but data were lost on the way.
    DataLost,
}

impl Exit {
    /// What an error means: arguments, configurations, recordings, models and scenes that cannot be used are the
    /// caller's to correct, everything else has failed.
    #[must_use]
    pub fn of(error: &(dyn Error + 'static)) -> Self {
        let mut cause = Some(error);
        while let Some(error) = cause {
            let wrong = error.is::<WrongArgument>()
                || error.is::<HostConfigError>()
                || error.is::<ModelError>()
                || error.is::<SceneFileError>()
                || error.is::<grip_sim::SceneError>()
                || is_input(error);
            if wrong {
                return Self::WrongArguments;
            }
            cause = error.source();
        }
        Self::Failed
    }
}

/// Recordings, folders of them, labels and rows that cannot be read or used. A recording that can be read and does not
/// give a calibration has failed.
fn is_input(error: &(dyn Error + 'static)) -> bool {
    error.is::<CsvError>()
        || error.is::<NpzError>()
        || error.is::<McapError>()
        || error.is::<TapeError>()
        || error.is::<LabelError>()
        || error.is::<PhaseError>()
        || error.is::<ScoreError>()
        || error.is::<CollectError>()
        || error.is::<DataSetError>()
        || error.is::<ConfigError>()
        || error.is::<ProfileError>()
        || matches!(error.downcast_ref(), Some(RecoverError::Read(_)))
        || matches!(error.downcast_ref(), Some(CalibrationError::Config(_)))
}

/// The longest message that is printed (characters): a file of rubbish has a header of any length.
const LONGEST: usize = 2000;

/// The message of an error and of its causes, joined by `: `.
///
/// A cause that the message names already is left out; control characters, which a file may hold, are shown escaped.
#[must_use]
pub fn message(error: &(dyn Error + 'static)) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let words = error.to_string();
        if !text.contains(words.trim_end()) {
            text = format!("{}: {words}", text.trim_end());
        }
        cause = error.source();
    }
    let mut shown = String::new();
    for (count, c) in text.trim_end().chars().enumerate() {
        if count == LONGEST {
            shown.push_str(" ...");
            break;
        }
        match c {
            '\n' => shown.push(c),
            c if c.is_control() => shown.extend(c.escape_default()),
            c => shown.push(c),
        }
    }
    shown
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(match exit {
            Exit::Done => 0,
            Exit::Failed => 1,
            Exit::WrongArguments => 2,
            Exit::DataLost => 3,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Exit, message};
    use crate::{calibrate::CalibrationError, model::parse_estimator, score::ScoreError};
    use grip_record::CsvError;

    #[test]
    fn a_cause_is_told_once() {
        let error = parse_estimator("m.json", "{").unwrap_err();
        assert_eq!(message(&error), "m.json: line 1, column 1: EOF while parsing an object");
    }

    #[test]
    fn rubbish_is_escaped_and_cut() {
        let text = format!("\x1b[31m{}", "x".repeat(5000));
        let shown = message(&super::WrongArgument(text));
        assert!(shown.starts_with("\\u{1b}[31mxxx") && shown.ends_with(" ..."), "{shown}");
        assert!(shown.len() < 2100, "{}", shown.len());
    }

    #[test]
    fn what_the_caller_can_correct_is_told_from_what_failed() {
        let empty = || CsvError::Empty { file: "x".into() };
        assert_eq!(Exit::of(&empty()), Exit::WrongArguments);
        assert_eq!(Exit::of(&ScoreError::Recording(empty())), Exit::WrongArguments);
        assert_eq!(Exit::of(&CalibrationError::Short { rest_s: 1.0 }), Exit::Failed);
        assert_eq!(Exit::of(&std::io::Error::other("disk full")), Exit::Failed);
    }
}
