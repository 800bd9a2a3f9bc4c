//! The name of recordings with its places in; the name of one file out.

use super::address::Uid;
use crate::utc;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A path with the places `{start}` (wall clock at its start, UTC, `20261121T225908Z`), `{uid}` (identity of the gripper)
/// and `{n}` (number of the file of this run, from 1). It ends with `.mcap` or `.csv`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct RecordTemplate(String);

/// Why a text is no name of recordings.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TemplateError {
    /// Another kind of file.
    #[error("record = {0}: recordings are written as .mcap or .csv")]
    Kind(String),
    /// A place that nothing is known for.
    #[error("record: `{{{0}}}` is unknown; there are {{start}}, {{uid}} and {{n}}")]
    Place(String),
    /// A brace without the other one.
    #[error("record: a brace in `{0}` has no other one; places are {{start}}, {{uid}} and {{n}}")]
    Brace(String),
}

/// What a template is filled with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordName {
    /// Wall clock at the start of the file (s since 1970, UTC).
    pub start_s: u64,
    /// The gripper, once it is known.
    pub uid: Option<Uid>,
    /// Number of the file in this run, from 1.
    pub n: u32,
}

impl RecordTemplate {
    /// Checks a text.
    ///
    /// # Errors
    /// Where it ends otherwise, or has an unknown place.
    pub fn new(text: &str) -> Result<Self, TemplateError> {
        if !(text.ends_with(".mcap") || text.ends_with(".csv")) {
            return Err(TemplateError::Kind(text.to_owned()));
        }
        fill(text, |place| matches!(place, "start" | "uid" | "n").then(String::new))?;
        Ok(Self(text.to_owned()))
    }

    /// The text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Whether two files of one run have two names: without `{n}` or `{start}` a number must be added.
    #[must_use]
    pub fn tells_files_apart(&self) -> bool {
        self.0.contains("{n}") || self.0.contains("{start}")
    }

    /// The name of one file. An unknown gripper is `unknown`.
    #[must_use]
    pub fn file(&self, name: &RecordName) -> PathBuf {
        let text = fill(&self.0, |place| {
            Some(match place {
                "start" => utc::compact(name.start_s),
                "uid" => name.uid.map_or_else(|| "unknown".to_owned(), |uid| uid.to_string()),
                "n" => format!("{:04}", name.n),
                _ => return None,
            })
        });
        // It was checked when the template was made.
        text.unwrap_or_else(|_| self.0.clone()).into()
    }
}

/// `text` with what `value` gives for each place.
fn fill(text: &str, value: impl Fn(&str) -> Option<String>) -> Result<String, TemplateError> {
    let mut filled = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('{') {
        let Some((place, next)) = after.split_once('}').filter(|_| !before.contains('}')) else {
            return Err(TemplateError::Brace(text.to_owned()));
        };
        filled.push_str(before);
        filled.push_str(&value(place).ok_or_else(|| TemplateError::Place(place.to_owned()))?);
        rest = next;
    }
    if rest.contains('}') {
        return Err(TemplateError::Brace(text.to_owned()));
    }
    filled.push_str(rest);
    Ok(filled)
}

impl TryFrom<String> for RecordTemplate {
    type Error = TemplateError;

    fn try_from(text: String) -> Result<Self, TemplateError> {
        Self::new(&text)
    }
}

impl From<RecordTemplate> for String {
    fn from(template: RecordTemplate) -> Self {
        template.0
    }
}

#[cfg(test)]
mod tests {
    use super::{RecordName, RecordTemplate, TemplateError};

    #[test]
    fn places_are_filled() {
        let template = RecordTemplate::new("/var/lib/gripd/{uid}-{start}-{n}.mcap").unwrap();
        let name = RecordName { start_s: 1_795_301_948, uid: None, n: 3 };
        let file = template.file(&name);
        assert_eq!(file.to_str(), Some("/var/lib/gripd/unknown-20261121T225908Z-0003.mcap"));
        assert!(template.tells_files_apart());
        assert!(!RecordTemplate::new("run.csv").unwrap().tells_files_apart());
    }

    #[test]
    fn what_cannot_be_filled_is_refused() {
        assert!(matches!(RecordTemplate::new("x.bag"), Err(TemplateError::Kind(_))));
        assert!(matches!(RecordTemplate::new("{date}.mcap"), Err(TemplateError::Place(_))));
        for text in ["{n.mcap", "n}.mcap", "}{n}.mcap", "{n}}.mcap"] {
            assert!(matches!(RecordTemplate::new(text), Err(TemplateError::Brace(_))), "{text}");
        }
    }
}
