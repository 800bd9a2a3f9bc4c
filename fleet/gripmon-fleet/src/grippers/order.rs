//! Order of a roster: the rows that fit what a person wants to see of it, in that order.

use super::column::{Column, Key};
use super::roster::Roster;
use super::row::Row;
use core::cmp::Ordering;

/// What the table is ordered by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sorting {
    /// By which column.
    pub column: Column,
    /// The largest first. What is not known stands last in any case.
    pub descending: bool,
}

impl Default for Sorting {
    fn default() -> Self {
        Self { column: Column::Site, descending: false }
    }
}

impl Sorting {
    /// What a click on the title of a column makes of it: that column, or the other way round where it is that one already.
    #[must_use]
    pub fn clicked(self, column: Column) -> Self {
        let again = self.column == column;
        let descending = if again { !self.descending } else { column.begins_large() };
        Self { column, descending }
    }
}

/// Places of the rows that hold every word of the filter, in order; rows that are alike by site and identity.
#[must_use]
pub fn order(roster: &Roster, sorting: Sorting, filter: &str) -> Vec<usize> {
    let (rows, now_s) = (roster.rows(), roster.now_s());
    let words: Vec<String> = filter.split_whitespace().map(str::to_lowercase).collect();
    let key = |row| sorting.column.value(row, now_s).map(|(key, _)| key);
    let fitting = rows.iter().enumerate().filter(|(_, row)| holds(row, &words, now_s));
    let mut found: Vec<_> = fitting.map(|(place, row)| (place, &row.member, key(row))).collect();
    found.sort_by(|(_, a, key_a), (_, b, key_b)| {
        by_key(key_a.as_ref(), key_b.as_ref(), sorting.descending).then_with(|| a.cmp(b))
    });
    found.into_iter().map(|(place, ..)| place).collect()
}

fn by_key(a: Option<&Key>, b: Option<&Key>, descending: bool) -> Ordering {
    match (a, b) {
        (Some(a), Some(b)) if descending => b.compare(a),
        (Some(a), Some(b)) => a.compare(b),
        (a, b) => a.is_none().cmp(&b.is_none()),
    }
}

/// Whether each word stands in one of the columns of words.
fn holds(row: &Row, words: &[String], now_s: f64) -> bool {
    if words.is_empty() {
        return true;
    }
    let texts = Column::WORDS.map(|column| column.text(row, now_s).to_lowercase());
    words.iter().all(|word| texts.iter().any(|text| text.contains(word.as_str())))
}
