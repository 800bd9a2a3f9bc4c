//! Table of cells, as HTML and as JSON.

use serde_json::{Value, json};

/// One field of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number, shown with three or four digits that count.
    Number(f64),
    /// A count, shown in full.
    Count(usize),
    /// A share from 0 to 1, shown in percent with one decimal.
    Percent(f64),
    /// Nothing to report.
    Empty,
}

impl Cell {
    /// Words.
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// As people read it.
    #[must_use]
    pub fn shown(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(number) => shown(*number),
            Self::Count(count) => count.to_string(),
            Self::Percent(share) if share.is_finite() => format!("{:.1}", 100.0 * share),
            Self::Percent(_) | Self::Empty => "–".to_owned(),
        }
    }

    /// As programs read it, in full; shares stay shares.
    #[must_use]
    pub fn json(&self) -> Value {
        match self {
            Self::Text(text) => json!(text),
            Self::Number(number) | Self::Percent(number) => json!(number),
            Self::Count(count) => json!(count),
            Self::Empty => Value::Null,
        }
    }
}

fn shown(number: f64) -> String {
    let size = number.abs();
    match number {
        _ if !number.is_finite() => "–".to_owned(),
        0.0 => "0".to_owned(),
        _ if (1e-3..1e5).contains(&size) => {
            let decimals = (0..6).find(|&digits| size >= 100.0 / 10_f64.powi(digits)).unwrap_or(6);
            format!("{number:.*}", usize::try_from(decimals).unwrap_or(0))
        }
        _ => format!("{number:.2e}"),
    }
}

/// Rows of cells under heads.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Its anchor, unique in the report: `a-z`, `0-9` and `-`.
    pub id: String,
    /// What it shows.
    pub caption: String,
    /// Heads of the columns.
    pub columns: Vec<String>,
    /// Rows, each with a cell for each column.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table without rows.
    pub fn new<T: Into<String> + Clone>(
        id: impl Into<String>,
        caption: impl Into<String>,
        columns: &[T],
    ) -> Self {
        let columns = columns.iter().cloned().map(Into::into).collect();
        Self { id: id.into(), caption: caption.into(), columns, rows: Vec::new() }
    }

    /// Puts a row below the others; missing cells stay empty.
    pub fn push(&mut self, mut row: Vec<Cell>) {
        row.resize(self.columns.len().max(row.len()), Cell::Empty);
        self.rows.push(row);
    }

    /// As Markdown: caption, heads and cells.
    #[must_use]
    pub fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let mut text = format!("{}\n\n", self.caption);
        text += &line(self.columns.clone());
        text += &format!("|{}\n", "---|".repeat(self.columns.len()));
        for row in &self.rows {
            text += &line(row.iter().map(Cell::shown).collect());
        }
        text
    }

    /// Heads and cells.
    #[must_use]
    pub fn json(&self) -> Value {
        let rows: Vec<Vec<Value>> =
            self.rows.iter().map(|row| row.iter().map(Cell::json).collect()).collect();
        json!({"id": self.id, "caption": self.caption, "columns": self.columns, "rows": rows})
    }
}
