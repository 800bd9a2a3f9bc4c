//! An error in; the exit code of the contract and the text for the person at the keyboard out.

use crate::{config::HostConfigError, model::ModelError};
use core::error::Error;
use grip_record::CsvError;
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
    /// 2: wrong arguments or configuration.
    WrongArguments,
    /// 3: done, but data were lost on the way.
    DataLost,
}

impl Exit {
    /// What an error means: arguments, configurations and models that cannot be used are the caller's to mend, everything else has
    /// failed.
    #[must_use]
    pub fn of(error: &(dyn Error + 'static)) -> Self {
        Self::of_any(error, |_| false)
    }

    /// As [`Exit::of`]; errors, or causes of them, of which `is_argument` says so are the caller's to mend as well.
    #[must_use]
    pub fn of_any(
        error: &(dyn Error + 'static),
        is_argument: impl Fn(&(dyn Error + 'static)) -> bool,
    ) -> Self {
        let mut cause = Some(error);
        while let Some(error) = cause {
            let wrong = error.is::<WrongArgument>()
                || error.is::<HostConfigError>()
                || error.is::<ModelError>()
                || error.downcast_ref().is_some_and(CsvError::is_argument)
                || is_argument(error);
            if wrong {
                return Self::WrongArguments;
            }
            cause = error.source();
        }
        Self::Failed
    }
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
    use crate::model::parse_estimator;
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
    fn wrong_arguments_are_told_from_wrong_files() {
        let rate = || CsvError::BadRate { rate_hz: 0.0 };
        assert_eq!(Exit::of(&rate()), Exit::WrongArguments);
        assert_eq!(Exit::of(&CsvError::Empty { file: "x".into() }), Exit::Failed);
    }
}
