//! Arguments in, what gripd printed and how it ended out.

use assert_cmd::Command;
use core::time::Duration;
use serde_json::Value;
use std::path::Path;

/// Longer than any run, however busy the machine; a program that hangs is killed.
const PATIENCE: Duration = Duration::from_secs(120);

/// A run that has ended.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

/// gripd in `folder`, unaware of the settings of whoever runs the tests.
pub(crate) fn command(folder: &Path, args: &[&str]) -> std::process::Command {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_gripd"));
    command.current_dir(folder).env_clear().env("HOME", folder).args(args);
    command
}

/// Runs gripd in `folder` to its end.
pub(crate) fn gripd(folder: &Path, args: &[&str]) -> Ran {
    ended(command(folder, args))
}

/// Waits for the end; a panic is never one.
pub(crate) fn ended(command: std::process::Command) -> Ran {
    let output = Command::from_std(command).timeout(PATIENCE).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let (out, err) = (text(output.stdout), text(output.stderr));
    assert!(!err.contains("panicked"), "{err}");
    let code = output.status.code().unwrap_or_else(|| panic!("gripd was killed: {err}"));
    Ran { code, out, err }
}

impl Ran {
    /// Done, or done with the loss of data that a busy machine may cause.
    #[track_caller]
    pub(crate) fn done(self) -> Self {
        assert!([0, 3].contains(&self.code), "{self:?}");
        self
    }

    /// Ended with `code`, and said each of `words`.
    #[track_caller]
    pub(crate) fn refused(self, code: i32, words: &[&str]) -> Self {
        assert_eq!(self.code, code, "{self:?}");
        for word in words {
            assert!(self.err.contains(word), "no {word:?} in {}", self.err);
        }
        assert!(self.out.is_empty(), "{self:?}");
        self
    }

    /// The lines of standard output as JSON.
    pub(crate) fn json(&self) -> Vec<Value> {
        self.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }
}
