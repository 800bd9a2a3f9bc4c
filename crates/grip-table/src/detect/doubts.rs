//! What of a table means two things: its commas, its points, and lines of a log above it.

use super::{Candidate, Cell, Line, cell_of};
use crate::{
    number::{self, Decimal, Points},
    records::Delimiter,
    text, unit,
};

impl Candidate {
    /// What commas may be that separate cells of digits alone: decimal ones of half as many numbers.
    pub(super) fn decimal_commas(
        &self,
        start: usize,
        header: Option<usize>,
    ) -> Option<(u64, String)> {
        let rows = self.lines.get(start..).filter(|_| self.delimiter == Delimiter::Byte(b','))?;
        let width = rows.first()?.cells.len();
        let is_whole = |cell: &Vec<u8>| {
            let digits = cell.strip_prefix(b"-").unwrap_or(cell);
            !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
        };
        let is_pairs = |row: &Line| {
            row.cells.len() == width
                && row.cells.iter().all(is_whole)
                && row.cells.iter().skip(1).step_by(2).all(|cell| cell.first() != Some(&b'-'))
        };
        if header.is_some() || width % 2 != 0 || !rows.iter().all(is_pairs) {
            return None;
        }
        let above = start.checked_sub(1).and_then(|above| self.cells.get(above));
        let half_named = above.is_some_and(|kinds| {
            2 * kinds.len() == width && kinds.iter().all(|kind| *kind == Cell::Text)
        });
        let cell = |row: &Line, at: usize| row.cells.get(at).cloned().unwrap_or_default();
        let number = |row: &Line| text(&cell(row, 0)).parse::<i64>().unwrap_or(0);
        let counts_up = rows.windows(2).all(|pair| number(&pair[0]) < number(&pair[1]));
        let is_padded = |row: &Line| {
            (row.cells.first().is_some_and(|cell| cell.starts_with(b"-0")))
                || (cell(row, 1).len() > 1 && cell(row, 1).starts_with(b"0"))
        };
        let digits = cell(rows.first()?, 1).len();
        let is_one = width == 2
            && (rows.iter().any(is_padded)
                || (!counts_up && rows.iter().all(|row| cell(row, 1).len() == digits)));
        (half_named || is_one).then(|| {
            let shown = rows.iter().find(|row| is_padded(row)).or(rows.first());
            shown.map(|row| (row.line, text(&row.cells.join(&b',')).into_owned()))
        })?
    }

    /// What a column leaves open about points: `1.184` may be thousands among whole numbers.
    pub(super) fn points(&self, rows: &[&Line], column: usize) -> Points {
        let by_mark = matches!(self.delimiter, Delimiter::Byte(b';' | b'\t' | b'|'));
        let is_grouped = |cell: &Vec<u8>| number::is_grouped(&text(cell), '.');
        let cells = || rows.iter().filter_map(|row| row.cells.get(column));
        let pointed = |cell: &&Vec<u8>| cell.contains(&b'.');
        let shown = rows
            .iter()
            .flat_map(|row| &row.cells)
            .filter(pointed)
            .any(|cell| !is_grouped(cell) && cell_of(cell, Decimal::Point) == Cell::Number);
        if !by_mark || !cells().filter(pointed).all(is_grouped) {
            return Points::Clear;
        }
        match (cells().any(|cell| pointed(&cell)), cells().any(|cell| number::is_hundreds(cell))) {
            (true, true) => Points::Whole,
            (false, true) if !shown => Points::Whole,
            (true, false) if !shown => Points::Grouped,
            _ => Points::Clear,
        }
    }
}

/// Whether a line is one of a log: `[I] sensor ok, 2.0 g`, `I (31) boot: mode, done`, `mode:DIO, clock:1`.
pub(super) fn is_log(cells: &[Vec<u8>]) -> bool {
    let first = cells.first().map(|cell| text(cell)).unwrap_or_default();
    let is_marked = first.starts_with('[') && first.split_once("] ").is_some();
    let is_sentence = first.contains(": ") && first.split_whitespace().count() > 2;
    let is_amount = |cell: &Vec<u8>| {
        text(cell).split_once(' ').is_some_and(|(number, unit)| {
            number.parse::<f64>().is_ok() && unit::scale(unit).is_some()
        })
    };
    let is_setting = |cell: &Vec<u8>| cell.contains(&b':');
    is_marked
        || (cells.len() > 1
            && (is_sentence || cells.iter().any(is_amount) || cells.iter().all(is_setting)))
}
