//! A file that states how the window shall look and where it shall look: arrangements to share, and pictures that can be made again.

use crate::layout::{Layout, LayoutError};
use crate::state::ViewState;
use crate::time::TimeWindow;
use grip_scope::{EventKind, Model, SourceStatus, Span};
use serde::{Deserialize, Serialize};
use std::{fs, path::Path};

/// A view.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ViewFile {
    /// Arrangement of the window, as in layout.toml.
    pub layout: Layout,
    /// Where to look.
    pub look: LookAt,
}

/// Where to look.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LookAt {
    /// At the first event of this name after `from_s`; the newest data where absent.
    pub event: Option<EventKind>,
    /// Only data from here on count (s).
    pub from_s: f64,
    /// Wait until there is so much data (s).
    pub after_s: f64,
    /// How much is seen (s); all where absent.
    pub length_s: Option<f64>,
    /// Cursors A and B, seconds after the event, or after the left edge where there is none.
    pub cursors: Vec<f64>,
    /// Show the keys.
    pub help: bool,
    /// Explain the slip at the event.
    pub explain: bool,
    /// Show this hint of the tour, from 1 on.
    pub tour: Option<usize>,
    /// Give up after so many seconds.
    pub patience_s: f64,
}

impl Default for LookAt {
    fn default() -> Self {
        Self {
            event: None,
            from_s: f64::NEG_INFINITY,
            after_s: 0.0,
            length_s: None,
            cursors: Vec::new(),
            help: false,
            explain: false,
            tour: None,
            patience_s: 60.0,
        }
    }
}

impl ViewFile {
    /// Reads a view.
    ///
    /// # Errors
    /// [`LayoutError`], with the line that is wrong; a file that is not there is one too.
    pub fn read(path: &Path) -> Result<Self, LayoutError> {
        let text = fs::read_to_string(path)
            .map_err(|source| LayoutError::File { path: path.to_owned(), source })?;
        let reported = |source| LayoutError::Text { path: path.to_owned(), source };
        let file: Self = toml::from_str(&text).map_err(|error| reported(Box::new(error)))?;
        Ok(Self { layout: file.layout.within_limits(), ..file })
    }

    /// Puts the state there, where the data have come so far; `false` where they have not.
    pub fn place(&self, state: &mut ViewState, model: &Model) -> bool {
        let Some(data) = model.span() else {
            return model.study().is_some() && self.look.event.is_none();
        };
        let loading = matches!(
            model.status(),
            SourceStatus::Loading { .. } | SourceStatus::Connecting { .. }
        );
        if loading || data.length_s() < self.look.after_s {
            return false;
        }
        let length_s = self.look.length_s.unwrap_or_else(|| data.length_s());
        let Some(from_s) = self.left_edge_s(model, length_s, data) else { return false };
        let zero_s = if self.look.event.is_some() { from_s + length_s / 3.0 } else { from_s };
        state.window = TimeWindow::new(length_s);
        if self.look.event.is_some() || !self.look.cursors.is_empty() {
            state.window.show(Span::new(from_s, from_s + length_s));
        }
        let cursor = |i: usize| self.look.cursors.get(i).map(|after_s| zero_s + after_s);
        state.cursors = [cursor(0), cursor(1)];
        state.help = self.look.help;
        state.tour = self.look.tour.and_then(|hint| hint.checked_sub(1));
        // The sums above may have rounded it to just before the event.
        state.explain = self.look.explain.then_some(zero_s + 1e-9);
        true
    }

    /// The left edge; `None` while what is to be seen is not there.
    fn left_edge_s(&self, model: &Model, length_s: f64, data: Span) -> Option<f64> {
        let Some(kind) = self.look.event else { return Some(data.to_s - length_s) };
        let rest = Span { from_s: self.look.from_s, to_s: f64::INFINITY };
        let mark = model.events().marks.within(rest).find(|mark| mark.kind == kind)?;
        let from_s = mark.t_s - length_s / 3.0;
        (data.to_s >= from_s + length_s || !matches!(model.status(), SourceStatus::Live))
            .then_some(from_s)
    }
}

#[cfg(test)]
mod tests {
    use super::ViewFile;

    #[test]
    fn wrong_names_are_reported() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("view.toml");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            ViewFile::read(&path).map_err(|error| error.to_string())
        };
        let good =
            read("[layout]\ntheme = \"light\"\n[look]\nevent = \"gross slip\"\nlength_s = 0.2\n")
                .unwrap();
        assert_eq!(good.look.length_s, Some(0.2));
        assert!(read("[look]\nevent = \"earthquake\"\n").unwrap_err().contains("gross slip"));
        assert!(read("[look]\nevnt = \"gap\"\n").unwrap_err().contains("evnt"));
    }
}
