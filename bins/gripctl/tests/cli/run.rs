//! Arguments in, what gripctl printed and how it ended out.

use assert_cmd::Command;
use core::time::Duration;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Longer than any run, however busy the machine; a program that hangs is killed.
const PATIENCE: Duration = Duration::from_secs(300);

/// A run that has ended.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

/// Runs gripctl in `folder` to its end; a panic is never one.
pub(crate) fn gripctl(folder: &Path, args: &[&str]) -> Ran {
    let mut command = Command::new(crate::PROGRAM);
    let output = command.current_dir(folder).args(args).timeout(PATIENCE).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let (out, err) = (text(output.stdout), text(output.stderr));
    assert!(!err.contains("panicked"), "{err}");
    let code = output.status.code().unwrap_or_else(|| panic!("gripctl was killed: {err}"));
    Ran { code, out, err }
}

impl Ran {
    #[track_caller]
    pub(crate) fn done(self) -> Self {
        assert_eq!(self.code, 0, "{self:?}");
        self
    }

    /// Ended with `code`, said each of `words` once, and printed no result.
    #[track_caller]
    pub(crate) fn refused(self, code: i32, words: &[&str]) -> Self {
        assert_eq!(self.code, code, "{self:?}");
        for word in words {
            assert!(self.err.contains(word), "no {word:?} in {}", self.err);
        }
        let longest = self.err.lines().max_by_key(|line| line.len()).unwrap_or_default();
        let reported = longest.split_once(": ").map_or(longest, |(_, text)| text);
        assert_eq!(self.err.matches(reported).count(), 1, "reported twice: {}", self.err);
        assert!(self.out.is_empty(), "{self:?}");
        self
    }

    /// The lines of standard output as JSON.
    pub(crate) fn json(&self) -> Vec<Value> {
        self.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }
}

#[track_caller]
pub(crate) fn number(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or_else(|| panic!("no number {name} in {value}"))
}

/// The folder `name` of the real recordings, which are no part of the project.
pub(crate) fn real_data(name: &str) -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("GRIP_DATA").map_or_else(beside, PathBuf::from).join(name);
    assert!(folder.is_dir(), "no folder {}: set GRIP_DATA", folder.display());
    folder
}
