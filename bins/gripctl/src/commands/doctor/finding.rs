//! Finding about one thing that was looked at: a line with its verdict, and the command that fixes it.

use core::fmt;
use serde::Serialize;

/// How it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Verdict {
    Ok,
    /// It works, but not as well as it could.
    Warning,
    /// It does not work.
    Fault,
}

/// What was found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "type", rename = "finding")]
pub(crate) struct Finding {
    pub(crate) check: &'static str,
    pub(crate) verdict: Verdict,
    pub(crate) text: String,
    pub(crate) remedy: Option<String>,
}

impl Finding {
    pub(crate) fn ok(check: &'static str, text: String) -> Self {
        Self { check, verdict: Verdict::Ok, text, remedy: None }
    }

    pub(crate) fn warning(check: &'static str, text: String, remedy: String) -> Self {
        Self { check, verdict: Verdict::Warning, text, remedy: Some(remedy) }
    }

    pub(crate) fn fault(check: &'static str, text: String, remedy: String) -> Self {
        Self { check, verdict: Verdict::Fault, text, remedy: Some(remedy) }
    }

    /// `ok` where `good`, else a warning.
    pub(crate) fn judge(good: bool, check: &'static str, text: String, remedy: &str) -> Self {
        if good { Self::ok(check, text) } else { Self::warning(check, text, remedy.to_owned()) }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = match self.verdict {
            Verdict::Ok => "ok",
            Verdict::Warning => "warning",
            Verdict::Fault => "FAULT",
        };
        write!(f, "{verdict:8} {:14} {}", self.check, self.text)?;
        match &self.remedy {
            Some(remedy) => write!(f, "\n{:24}fix: {remedy}", ""),
            None => Ok(()),
        }
    }
}
