//! Exit code of the contract for an error, and its text for the person at the keyboard.

use crate::{config::HostConfigError, model::ModelError, tape::TapeError};
use core::error::Error;
use grip_record::{
    CsvError, LabelError, PhaseError,
    mcap::{McapError, RecoverError},
};
use slip_core::ConfigError;
use std::{env, process::ExitCode};

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
    /// What an error means: arguments, configurations, recordings and models that cannot be used are the caller's to correct,
    /// everything else has failed.
    #[must_use]
    pub fn of(error: &(dyn Error + 'static)) -> Self {
        Self::of_any(error, |_| false)
    }

    /// As [`Exit::of`]; errors, or causes of them, of which `is_argument` holds are the caller's to correct as well.
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
                || is_input(error)
                || is_argument(error);
            if wrong {
                return Self::WrongArguments;
            }
            cause = error.source();
        }
        Self::Failed
    }
}

/// Recordings, labels and rows that cannot be read or used.
fn is_input(error: &(dyn Error + 'static)) -> bool {
    error.is::<CsvError>()
        || error.is::<McapError>()
        || error.is::<TapeError>()
        || error.is::<LabelError>()
        || error.is::<PhaseError>()
        || error.is::<ConfigError>()
        || matches!(error.downcast_ref(), Some(RecoverError::Read(_)))
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
    let text = text.trim_end();
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{} ...", lines(text.get(..end).unwrap_or(text))),
        None => lines(text),
    }
}

/// One line of text from a file, a network or a device, for a terminal: what would clear it, forge a line or turn the direction of
/// writing is shown escaped.
#[must_use]
pub fn escape(text: &str) -> String {
    escaped(text, false)
}

/// The same for text of several lines.
#[must_use]
pub fn lines(text: &str) -> String {
    escaped(text, true)
}

fn escaped(text: &str, lines: bool) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        // Marks of direction, and what is not seen at all: U+2028 also ends lines.
        let marks = matches!(c, '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}');
        let hidden = marks || matches!(c, '\u{ad}' | '\u{2060}'..='\u{206f}' | '\u{feff}');
        if (c.is_control() || hidden) && !(lines && c == '\n') {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
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

/// How to run another program: the file beside this one or on the PATH, else how it is built in the folder fleet.
#[must_use]
pub fn fleet_program(name: &str) -> String {
    let beside = env::current_exe().ok().and_then(|file| Some(file.parent()?.to_owned()));
    let path = env::var_os("PATH").unwrap_or_default();
    let folders = beside.into_iter().chain(env::split_paths(&path));
    match folders.map(|folder| folder.join(name)).find(|file| file.is_file()) {
        Some(file) => grip_record::shell(&file.display().to_string()),
        None => format!("cargo build --release -p {name} in the folder fleet"),
    }
}

#[cfg(test)]
mod tests {
    use super::{Exit, escape, lines, message};
    use crate::model::parse_estimator;
    use grip_record::CsvError;

    #[test]
    fn a_cause_is_reported_once() {
        let error = parse_estimator("m.json", "{").unwrap_err();
        assert_eq!(message(&error), "m.json: line 1, column 1: EOF while parsing an object");
    }

    #[test]
    fn a_name_stays_one_line_that_changes_no_terminal() {
        assert_eq!(escape("gripper \u{b5}\u{e9}\u{65e5} 7"), "gripper \u{b5}\u{e9}\u{65e5} 7");
        let hostile = "a\x1b[2J\n\r\t\x07\u{9b}31m\u{202e}\u{2028}";
        let shown = escape(hostile);
        assert_eq!(shown, "a\\u{1b}[2J\\n\\r\\t\\u{7}\\u{9b}31m\\u{202e}\\u{2028}");
        assert_eq!(lines("a\nb\x1b"), "a\nb\\u{1b}");
    }

    #[test]
    fn rubbish_is_escaped_and_cut() {
        let text = format!("\x1b[31m{}", "x".repeat(5000));
        let shown = message(&super::WrongArgument(text));
        assert!(shown.starts_with("\\u{1b}[31mxxx") && shown.ends_with(" ..."), "{shown}");
        assert!(shown.len() < 2100, "{}", shown.len());
    }

    #[test]
    fn what_the_caller_can_correct_is_reported_from_what_failed() {
        assert_eq!(Exit::of(&CsvError::NoRows { file: "x".into() }), Exit::WrongArguments);
        assert_eq!(Exit::of(&std::io::Error::other("disk full")), Exit::Failed);
        let disk = |error: &(dyn core::error::Error + 'static)| error.is::<std::io::Error>();
        assert_eq!(Exit::of_any(&std::io::Error::other("disk full"), disk), Exit::WrongArguments);
    }
}
