//! Report of sections of text, tables and figures: one self-contained HTML page, JSON and charts.
//!
//! A number is stored once, in a [`Cell`]; page and JSON both show that one, so they cannot differ.

mod html;
mod table;

pub use table::{Cell, Table};

use crate::Chart;
use askama::Template as _;
use serde_json::{Value, json};

/// The page of a report could not be made, because a chart of it could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct ReportError(#[from] askama::Error);

/// A chart with its place in the report.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name of its file without ending, unique in the report: `a-z`, `0-9` and `-`.
    pub id: String,
    /// What it shows.
    pub caption: String,
    /// The chart.
    pub chart: Chart,
}

/// A part of a section.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// A heading inside a section.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// A table.
    Table(Table),
    /// A figure.
    Figure(Figure),
    /// Parts that are folded away under a heading.
    Folded {
        /// The heading.
        title: String,
        /// What is folded away.
        blocks: Vec<Block>,
    },
}

impl From<&str> for Block {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Block {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<Table> for Block {
    fn from(table: Table) -> Self {
        Self::Table(table)
    }
}

impl From<Figure> for Block {
    fn from(figure: Figure) -> Self {
        Self::Figure(figure)
    }
}

/// A chapter of the report.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Its anchor, unique in the report: `a-z`, `0-9` and `-`.
    pub id: String,
    /// Its heading.
    pub title: String,
    /// Its parts, in order.
    pub blocks: Vec<Block>,
}

impl Section {
    /// An empty section.
    pub fn new(id: impl Into<String>, title: impl Into<String>) -> Self {
        Self { id: id.into(), title: title.into(), blocks: Vec::new() }
    }

    /// With one more part: a text (`&str`, `String`), a [`Table`], a [`Figure`] or a [`Block`].
    #[must_use]
    pub fn with(mut self, block: impl Into<Block>) -> Self {
        self.blocks.push(block.into());
        self
    }

    /// Its tables and figures with every number.
    #[must_use]
    pub fn json(&self) -> Value {
        let all = flattened(&self.blocks);
        let texts: Vec<&str> = all
            .iter()
            .filter_map(|block| match block {
                Block::Text(text) => Some(text.as_str()),
                _ => None,
            })
            .collect();
        let tables: Vec<Value> = all
            .iter()
            .filter_map(|block| match block {
                Block::Table(table) => Some(table.json()),
                _ => None,
            })
            .collect();
        let figures: Vec<Value> = figures(&all).map(figure_json).collect();
        json!({"id": self.id, "title": self.title, "texts": texts, "tables": tables, "figures": figures})
    }
}

/// The whole report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Its title.
    pub title: String,
    /// What a reader must know before anything else.
    pub summary: Vec<String>,
    /// Its chapters.
    pub sections: Vec<Section>,
    /// Fields of the JSON beside `title` and `sections`.
    pub fields: serde_json::Map<String, Value>,
}

impl Report {
    /// Puts a chapter behind the others.
    pub fn push(&mut self, section: Section) {
        self.sections.push(section);
    }

    /// One page that needs nothing from elsewhere: styles and charts stand in it.
    ///
    /// # Errors
    /// [`ReportError`] where a chart has nothing to show or a number without a place.
    pub fn html(&self) -> Result<String, ReportError> {
        Ok(html::Page { report: self }.render()?)
    }

    /// Every number of the page, and more digits of it.
    #[must_use]
    pub fn json(&self) -> Value {
        let mut fields = self.fields.clone();
        fields.insert("title".to_owned(), json!(self.title));
        fields.insert("summary".to_owned(), json!(self.summary));
        let sections: Vec<Value> = self.sections.iter().map(Section::json).collect();
        fields.insert("sections".to_owned(), Value::Array(sections));
        Value::Object(fields)
    }

    /// Every figure in order, those folded away too.
    #[must_use]
    pub fn figures(&self) -> Vec<&Figure> {
        let blocks: Vec<&Block> =
            self.sections.iter().flat_map(|section| flattened(&section.blocks)).collect();
        figures(&blocks).collect()
    }

    /// Every table in order, those folded away too.
    #[must_use]
    pub fn tables(&self) -> Vec<&Table> {
        let blocks = self.sections.iter().flat_map(|section| flattened(&section.blocks));
        blocks
            .filter_map(|block| match block {
                Block::Table(table) => Some(table),
                _ => None,
            })
            .collect()
    }
}

fn flattened(blocks: &[Block]) -> Vec<&Block> {
    blocks
        .iter()
        .flat_map(|block| match block {
            Block::Folded { blocks, .. } => flattened(blocks),
            other => vec![other],
        })
        .collect()
}

fn figures<'a>(blocks: &[&'a Block]) -> impl Iterator<Item = &'a Figure> {
    blocks.iter().filter_map(|block| match block {
        Block::Figure(figure) => Some(figure),
        _ => None,
    })
}

fn figure_json(figure: &Figure) -> Value {
    let layers: Vec<Value> = figure
        .chart
        .layers
        .iter()
        .map(|layer| json!({"name": layer.name, "points": layer.points, "labels": layer.labels}))
        .collect();
    json!({
        "id": figure.id,
        "caption": figure.caption,
        "x": figure.chart.x.label,
        "y": figure.chart.y.label,
        "layers": layers,
    })
}

#[cfg(test)]
mod tests;
