//! Template for the names of recordings, with a placeholder; it gives the name of one file.

use crate::utc;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A path in which `{start}` stands for the wall clock at the start of the run (UTC, `20261121T225908Z`). It ends with `.mcap`
/// or `.csv`; the recorder adds a number to every further file.
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
    #[error("record: `{{{0}}}` is unknown; there is {{start}}")]
    Place(String),
    /// A brace without the other one.
    #[error("record: a brace in `{0}` has no other one; there is {{start}}")]
    Brace(String),
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
        fill(text, |place| (place == "start").then(String::new))?;
        Ok(Self(text.to_owned()))
    }

    /// The text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The name of the first file of a run that began at `start_s` (s since 1970, UTC).
    #[must_use]
    pub fn file(&self, start_s: u64) -> PathBuf {
        let text = fill(&self.0, |place| (place == "start").then(|| utc::compact(start_s)));
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
    use super::{RecordTemplate, TemplateError};

    #[test]
    fn the_start_is_filled_in() {
        let template = RecordTemplate::new("/var/lib/gripd/cell-{start}.mcap").unwrap();
        let file = template.file(1_795_301_948);
        assert_eq!(file.to_str(), Some("/var/lib/gripd/cell-20261121T225908Z.mcap"));
        assert_eq!(RecordTemplate::new("run.csv").unwrap().file(0).to_str(), Some("run.csv"));
    }

    #[test]
    fn what_cannot_be_filled_is_refused() {
        assert!(matches!(RecordTemplate::new("x.bag"), Err(TemplateError::Kind(_))));
        for text in ["{date}.mcap", "{uid}.mcap", "{start}-{n}.mcap"] {
            assert!(matches!(RecordTemplate::new(text), Err(TemplateError::Place(_))), "{text}");
        }
        for text in ["{start.mcap", "start}.mcap", "}{start}.mcap", "{start}}.mcap"] {
            assert!(matches!(RecordTemplate::new(text), Err(TemplateError::Brace(_))), "{text}");
        }
    }
}
