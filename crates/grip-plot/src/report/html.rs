//! The page of a report, from the templates beside `src`.

use super::{Block, Cell, Figure, Report, Table};
use crate::PlotError;
use askama::Template;

/// `templates/page.html`.
#[derive(Template)]
#[template(path = "page.html")]
pub(super) struct Page<'a> {
    pub(super) report: &'a Report,
}

/// `templates/blocks.html`.
#[derive(Template)]
#[template(path = "blocks.html")]
struct Blocks<'a> {
    blocks: &'a [Block],
}

/// Parts hold parts, which a template cannot.
trait Html {
    fn html(&self) -> askama::Result<String>;
}

impl Html for [Block] {
    fn html(&self) -> askama::Result<String> {
        Blocks { blocks: self }.render()
    }
}

impl Figure {
    /// Names inside a chart (of its clip paths) count for the whole page, so each chart gets its own.
    fn svg(&self) -> Result<String, PlotError> {
        let (svg, id) = (self.chart.svg()?, &self.id);
        Ok(svg
            .trim()
            .replace(" id=\"", &format!(" id=\"{id}-"))
            .replace("url(#", &format!("url(#{id}-")))
    }
}

impl Table {
    /// Whether a column has no number; a template hands out references.
    fn has_words(&self, &column: &usize) -> bool {
        self.rows.iter().all(|row| matches!(row.get(column), Some(Cell::Text(_)) | None))
    }
}
