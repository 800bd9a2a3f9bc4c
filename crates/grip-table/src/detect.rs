//! The form of a table, found in its first lines.
//!
//! Each delimiter splits the first lines; the one that makes the most numbers is taken. In its lines the first eight
//! neighbours with numbers in the same columns (or the longest run of such lines) show which columns hold numbers. The
//! first line with numbers in all of them is the first row; the last line of text above it that has as many cells is
//! the header.

mod doubts;

use crate::{
    LOOK_AHEAD_LINES,
    number::{self, Decimal, Digits, Points},
    records::{Delimiter, RecordFault, Records},
    text, unit,
};

/// Rows whose equal form is believed.
const BELIEVED: usize = 8;
/// Bytes of a text that may be a unit.
const LONGEST_UNIT: usize = 12;
/// The last line before a block of numbers in a file of LabVIEW.
const END_OF_HEADER: &[u8] = b"***End_of_Header***";

/// One column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its name as in the file without blanks around it, or `column_K` (from 0) where it has none or that of an
    /// earlier one.
    pub name: String,
    /// The name as in the file, empty where it has none.
    pub given: String,
    /// Its unit: that of a row of units, or of the name (`Time (ms)`, `acc [g]`, `t/ms`, `height_mm`).
    pub unit: Option<String>,
    /// Whether text stands in its first cells, and not in few of them by mistake. Its cells are not looked at unless
    /// asked for.
    pub is_text: bool,
    /// The earlier column of the same name.
    pub(crate) repeats: Option<usize>,
}

/// Where the names of the columns come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Header {
    /// From this line.
    Line(u64),
    /// From this line, but numbers are among them: those of arrays (`,0,1` of pandas) have no meaning, so times and
    /// signals have to be asked about.
    Numbers(u64),
    /// There is none: `column_0`, `column_1`, ..
    None,
}

#[derive(Debug)]
pub(crate) struct Shape {
    pub(crate) delimiter: Delimiter,
    pub(crate) decimal: Decimal,
    pub(crate) columns: Vec<Column>,
    /// Fewest cells of a row.
    pub(crate) least: usize,
    pub(crate) header: Header,
    /// Line of the first row.
    pub(crate) first: u64,
    pub(crate) last_column: Digits,
    /// What of each column points may be.
    pub(crate) points: Vec<Points>,
    /// The line and text of a row whose commas may be decimal.
    pub(crate) commas: Option<(u64, String)>,
}

/// A line of the look-ahead, split.
struct Line {
    line: u64,
    cells: Vec<Vec<u8>>,
    ended: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Cell {
    Blank,
    Number,
    Text,
}

fn cell_of(cell: &[u8], decimal: Decimal) -> Cell {
    match number::parse(cell, decimal) {
        _ if cell.is_empty() => Cell::Blank,
        Some(value) if value.is_nan() => Cell::Blank,
        Some(_) => Cell::Number,
        None => Cell::Text,
    }
}

/// Lines split by one delimiter and numbers read with one decimal sign.
struct Candidate {
    delimiter: Delimiter,
    decimal: Decimal,
    lines: Vec<Line>,
    /// Of each line, what its cells are.
    cells: Vec<Vec<Cell>>,
    /// Lines of the rows that show the form.
    run: core::ops::Range<usize>,
    score: i64,
}

/// The form of the table whose first bytes are `start`, all of it where `whole`. In a table written `by_hand` the
/// first line is the header.
pub(crate) fn shape(
    start: &[u8],
    whole: bool,
    by_hand: bool,
) -> Result<Option<Shape>, (u64, RecordFault)> {
    let separator = start
        .strip_prefix(b"sep=")
        .and_then(|rest| rest.first())
        .map(|byte| Delimiter::Byte(*byte));
    let delimiters: &[Delimiter] = match &separator {
        Some(given) => core::slice::from_ref(given),
        None => &[
            Delimiter::Byte(b'\t'),
            Delimiter::Byte(b';'),
            Delimiter::Byte(b'|'),
            Delimiter::Byte(b','),
            Delimiter::Blanks,
        ],
    };
    let mut best: Option<Candidate> = None;
    let mut fault = None;
    for &delimiter in delimiters {
        let lines = match lines(start, whole, delimiter) {
            Ok(lines) => lines,
            Err(found) => {
                fault = Some(found);
                continue;
            }
        };
        let lines = if separator.is_some() {
            lines.into_iter().filter(|line| line.line > 1).collect()
        } else {
            lines
        };
        let candidate = Candidate::new(delimiter, lines, by_hand);
        let is_better = |best: &Candidate| {
            candidate.score > best.score
                && !(delimiter == Delimiter::Byte(b',') && best.is_one_column_above(&candidate))
        };
        if best.as_ref().is_none_or(is_better) {
            best = Some(candidate);
        }
    }
    match (best, fault) {
        (Some(best), _) => Ok(best.shape(by_hand)),
        (None, Some(fault)) => Err(fault),
        (None, None) => Ok(None),
    }
}

fn lines(start: &[u8], whole: bool, delimiter: Delimiter) -> Result<Vec<Line>, (u64, RecordFault)> {
    let mut records = Records::new(start, delimiter);
    let mut lines = Vec::new();
    while lines.len() < LOOK_AHEAD_LINES {
        match records.advance() {
            Ok(true) => {}
            Ok(false) => break,
            // What is cut at the end of the look-ahead.
            Err(RecordFault::OpenQuote) if !whole && !lines.is_empty() => break,
            Err(fault) => return Err((records.now.line, fault)),
        }
        let ended = records.now.ended.by_line_end;
        if !ended && !whole {
            break;
        }
        let cells = records.now.cells().map(<[u8]>::to_vec).collect();
        lines.push(Line { line: records.now.line, cells, ended });
    }
    Ok(lines)
}

/// Whether a line is a comment, and the text of its first cell without the mark.
pub(crate) fn comment(cell: &[u8]) -> Option<&[u8]> {
    let mark = [b"//".as_slice(), b"#", b"%"].into_iter().find(|mark| cell.starts_with(mark))?;
    let is_value = str::from_utf8(cell).is_ok_and(number::is_missing);
    (!is_value).then(|| cell.trim_ascii_start().strip_prefix(mark).unwrap_or(cell).trim_ascii())
}

impl Candidate {
    fn new(delimiter: Delimiter, lines: Vec<Line>, by_hand: bool) -> Self {
        let with = |decimal| Self::of(delimiter, decimal, &lines, by_hand);
        let mut best = with(Decimal::Point);
        // Where commas separate, a cell has one only within quotes.
        let comma = with(Decimal::Comma);
        let separates = delimiter == Delimiter::Byte(b',');
        let is_fraction_in = |line: &Line| line.cells.iter().any(|cell| is_fraction(cell));
        if by_hand {
            best.3 = if separates { Decimal::Point } else { Decimal::Open };
        } else if comma.2 > best.2 {
            best = comma;
        } else if !separates && !lines.iter().any(is_fraction_in) {
            best.3 = Decimal::Open;
        }
        let (cells, run, score, decimal) = best;
        Self { delimiter, decimal, lines, cells, run, score }
    }

    /// Cells, the run of rows, the score of the reading and its decimal sign.
    fn of(
        delimiter: Delimiter,
        decimal: Decimal,
        lines: &[Line],
        by_hand: bool,
    ) -> (Vec<Vec<Cell>>, core::ops::Range<usize>, i64, Decimal) {
        let of_line = |line: &Line| line.cells.iter().map(|cell| cell_of(cell, decimal)).collect();
        let cells: Vec<Vec<Cell>> = lines.iter().map(of_line).collect();
        let run = longest_run(&cells);
        let rows = cells.iter().zip(lines).skip(run.start).take(run.len());
        let mut score = 0;
        for (kinds, line) in rows {
            for (kind, cell) in kinds.iter().zip(&line.cells) {
                let others = cell.iter().filter(|byte| matches!(byte, b';' | b'\t' | b'|')).count();
                score += match kind {
                    Cell::Blank => 0,
                    Cell::Number => 2,
                    Cell::Text if delimiter == Delimiter::Blanks => -2,
                    Cell::Text => -1 - 3 * i64::try_from(others).unwrap_or(0),
                };
            }
        }
        // Commas are decimal in one column below a name without one; otherwise they separate.
        let is_one = cells.get(run.start).is_some_and(|kinds| kinds.len() == 1);
        if is_one && decimal == Decimal::Comma && delimiter != Delimiter::Byte(b',') {
            let above = run.start.checked_sub(1).and_then(|above| lines.get(above));
            let is_named = above.is_some_and(|line| !line.cells.concat().contains(&b','));
            score = if is_named { score } else { -1 };
        }
        if run.is_empty() || by_hand {
            // Text alone: the delimiter that the first line has most of.
            score = lines.first().map_or(0, |line| i64::try_from(line.cells.len()).unwrap_or(0));
            score -= if delimiter == Delimiter::Blanks { 1 << 20 } else { 0 };
            score -= if by_hand { 0 } else { 1 << 30 };
        }
        (cells, run, score, decimal)
    }

    fn shape(mut self, by_hand: bool) -> Option<Shape> {
        let first_line = self.lines.first()?;
        if by_hand || self.run.is_empty() {
            let first = first_line.line + 1;
            return Some(self.finish(&[], Some(0), None, 1, first));
        }
        let width = self.cells.get(self.run.start).map_or(0, Vec::len);
        let numbers = self.number_columns(width);
        let marker = self.lines.iter().rposition(|line| {
            line.cells.first().is_some_and(|cell| cell.starts_with(END_OF_HEADER))
        });
        let after = marker.map_or(0, |at| at + 1);
        let is_row = |cells: &Vec<Cell>| {
            let of = |column: &usize| cells.get(*column).copied().unwrap_or(Cell::Blank);
            cells.len() == width
                && numbers.iter().all(|column| of(column) != Cell::Text)
                && numbers.iter().any(|column| of(column) == Cell::Number)
        };
        let found = self.cells.iter().skip(after).position(is_row).map(|at| at + after);
        let mut start = found.unwrap_or(self.run.start);
        if after == 0 && self.is_numbers_above(start, width) {
            let line = self.lines.get(start + 1).map_or(0, |line| line.line);
            return Some(self.finish(&numbers, Some(start), None, start + 1, line));
        }
        let mut header = self.header_above(start, after, width);
        // A line with numbers and text below a line of text is a row with a fault.
        if let Some(at) = header
            && self.is_mixed(at, &numbers)
            && let Some(above) =
                self.header_above(at, after, width).filter(|above| !self.is_mixed(*above, &numbers))
        {
            header = Some(above);
            start = at;
        }
        let mut units = None;
        if let Some(at) = header
            && let Some(above) = self.header_above(at, after, width)
            && self.is_units(at, above, &numbers)
            && !(width == 2 && self.is_pair(above) && !self.are_symbols(at))
        {
            units = Some(at);
            header = Some(above);
        }
        header = header.filter(|at| units.is_some() || !self.are_settings(*at, &numbers));
        let commas = self.decimal_commas(start, header);
        let line = self.lines.get(start).map_or(0, |line| line.line);
        Some(Shape { commas, ..self.finish(&numbers, header, units, start, line) })
    }

    /// Whether `0,5` is one number here and two cells in `pairs`: below a name of one column, where no point is
    /// decimal.
    fn is_one_column_above(&self, pairs: &Self) -> bool {
        let (Some(rows), Some(above)) =
            (self.lines.get(self.run.clone()), self.run.start.checked_sub(1))
        else {
            return false;
        };
        let named = pairs.lines.get(above).is_some_and(|line| line.cells.len() == 1);
        let commas = |line: &Line| {
            line.cells.len() == 1 && line.cells.iter().all(|cell| !cell.contains(&b'.'))
        };
        self.decimal == Decimal::Comma && named && !rows.is_empty() && rows.iter().all(commas)
    }

    /// Columns with a number and no text in the run.
    fn number_columns(&self, width: usize) -> Vec<usize> {
        let rows = || self.cells.iter().skip(self.run.start).take(self.run.len());
        let is = |column: usize, kind| move |cells: &Vec<Cell>| cells.get(column) == Some(&kind);
        (0..width)
            .filter(|column| {
                rows().any(is(*column, Cell::Number)) && !rows().any(is(*column, Cell::Text))
            })
            .collect()
    }

    /// The last line of text above `start` with as many cells, split by any delimiter where it is the nearest one.
    fn header_above(&mut self, start: usize, after: usize, width: usize) -> Option<usize> {
        let mut nearest = true;
        for at in (after..start).rev() {
            let cells = self.cells.get(at)?;
            let [has_text, has_number] =
                [Cell::Text, Cell::Number].map(|kind| cells.contains(&kind));
            let line = self.lines.get_mut(at)?;
            let is_comma_off = |count: usize| count == width + 1 || count + 1 == width;
            let last_is_blank = line.cells.last().is_some_and(Vec::is_empty);
            let near = nearest && is_comma_off(line.cells.len()) && width > 1 && !has_number;
            let has_text = has_text && !doubts::is_log(&line.cells);
            if has_text
                && (line.cells.len() == width || (last_is_blank && line.cells.len() == width + 1))
            {
                return Some(at);
            }
            let split =
                has_text && nearest && width > 1 && split_otherwise(line, self.delimiter, width);
            if split || (has_text && near) {
                return Some(at);
            }
            nearest &= !cells.contains(&Cell::Text)
                || line.cells.first().is_some_and(|cell| comment(cell).is_some());
        }
        None
    }

    fn is_mixed(&self, at: usize, numbers: &[usize]) -> bool {
        let kinds = self.cells.get(at);
        numbers
            .iter()
            .any(|column| kinds.and_then(|kinds| kinds.get(*column)) == Some(&Cell::Number))
    }

    /// Whether a line holds units: below the names of numbers units alone, or short texts with one unit among them
    /// directly below as many names, or numbers in columns that have none below (Rigol).
    fn is_units(&self, at: usize, above: usize, numbers: &[usize]) -> bool {
        let (Some(line), Some(kinds)) = (self.lines.get(at), self.cells.get(at)) else {
            return false;
        };
        let elsewhere =
            |(column, kind): (usize, &Cell)| *kind == Cell::Number && !numbers.contains(&column);
        if kinds.iter().enumerate().any(elsewhere) {
            return true;
        }
        let of = |column: &usize| line.cells.get(*column).filter(|cell| !cell.is_empty());
        let is_known = |cell: &&Vec<u8>| unit::of_cell(&text(cell)).is_some();
        let cells = || numbers.iter().filter_map(of);
        let is_below = above + 1 == at
            && self.lines.get(above).is_some_and(|names| {
                let is_name = |cell: &Vec<u8>| !cell.is_empty() && !cell.contains(&b':');
                names.cells.len() == line.cells.len() && names.cells.iter().all(is_name)
            })
            && !self.is_mixed(above, numbers)
            && line.cells.iter().all(|cell| cell.len() <= LONGEST_UNIT);
        cells().any(|cell| is_known(&cell)) && (is_below || cells().all(|cell| is_known(&cell)))
    }

    /// Whether the line above `at` is a pair too: a list of settings, not a header.
    fn is_pair(&self, at: usize) -> bool {
        let above = at.checked_sub(1).and_then(|above| self.lines.get(above));
        above.is_some_and(|line| line.cells.len() == 2)
    }

    /// Whether these units are no names: in brackets, or no words.
    fn are_symbols(&self, at: usize) -> bool {
        let is_symbol = |cell: &Vec<u8>| {
            cell.len() <= 3 || cell.contains(&b'/') || matches!(cell.first(), Some(b'(' | b'['))
        };
        self.lines.get(at).is_some_and(|line| line.cells.iter().all(is_symbol))
    }

    /// Whether the line at `at` and the one above it are settings: texts with numbers behind.
    fn are_settings(&self, at: usize, numbers: &[usize]) -> bool {
        let above = at.checked_sub(1).filter(|above| self.is_mixed(*above, numbers));
        let is_text =
            |above: usize| self.cells.get(above).is_some_and(|kinds| kinds.contains(&Cell::Text));
        self.is_mixed(at, numbers) && above.is_some_and(is_text)
    }

    /// Whether the row at `at` is a header of numbers: `,0,1` or `0,1,2` above fractions.
    fn is_numbers_above(&self, at: usize, width: usize) -> bool {
        let Some(line) = self.lines.get(at) else { return false };
        let rows: Vec<&Line> =
            self.lines.iter().skip(at + 1).filter(|line| line.cells.len() == width).collect();
        let unnamed = line.cells.first().is_some_and(Vec::is_empty);
        let names = line.cells.iter().skip(usize::from(unnamed));
        let counts = names.enumerate().all(|(k, cell)| *cell == k.to_string().into_bytes());
        if at != 0 || width < 2 || rows.len() < 2 || !counts {
            return false;
        }
        let first = |line: &&Line| line.cells.first().is_some_and(|cell| !cell.is_empty());
        let fractions = |line: &&Line| {
            line.cells.iter().skip(1).all(|cell| cell.is_empty() || is_fraction(cell))
        };
        rows.iter().all(|row| if unnamed { first(row) } else { fractions(row) })
    }

    /// The form, where these columns hold numbers, the names stand in the line `header` and the rows begin at the line
    /// `start`.
    fn finish(
        self,
        numbers: &[usize],
        header: Option<usize>,
        units: Option<usize>,
        start: usize,
        first: u64,
    ) -> Shape {
        let rows: Vec<&Line> = self.lines.iter().skip(start).take(LOOK_AHEAD_LINES).collect();
        let mut given: Vec<String> = header
            .and_then(|at| self.lines.get(at))
            .map(|line| line.cells.iter().enumerate().map(|(at, cell)| name(cell, at)).collect())
            .unwrap_or_default();
        let widths = || rows.iter().map(|row| row.cells.len());
        let usual = usual(&widths()).unwrap_or(given.len());
        let all = |wanted: usize| widths().count() > 0 && widths().all(|width| width == wanted);
        let ends_blank = rows.iter().all(|row| row.cells.last().is_some_and(Vec::is_empty));
        let mut least = given.len();
        if given.is_empty() {
            given = vec![String::new(); usual];
            least = usual;
        } else if all(given.len() + 1) && !ends_blank && !numbers.is_empty() {
            // Names of rows, as R writes them, have no name themselves.
            given.insert(0, String::new());
            least += 1;
        } else if all(given.len() - 1)
            && given.last().is_some_and(|name| name.is_empty() || name == "Comment")
        {
            least -= 1;
        }
        let mut columns: Vec<Column> = Vec::with_capacity(given.len());
        for (at, given) in given.into_iter().enumerate() {
            let repeats =
                columns.iter().position(|column| column.given == given && !given.is_empty());
            let name = if given.is_empty() || repeats.is_some() {
                format!("column_{at}")
            } else {
                given.clone()
            };
            let of_row = units
                .and_then(|line| self.lines.get(line)?.cells.get(at))
                .filter(|cell| cell_of(cell, self.decimal) == Cell::Text)
                .map(|cell| unit::of_cell(&text(cell)).unwrap_or_else(|| text(cell).into_owned()));
            let unit = of_row.or_else(|| unit::of_name(&given).map(|(_, unit)| unit));
            let cells = || rows.iter().filter_map(|row| row.cells.get(at));
            let has_text = cells().any(|cell| cell_of(cell, self.decimal) == Cell::Text);
            let is_text = has_text
                && !numbers.contains(&at)
                && !cells().any(|cell| number::has_thousands(&text(cell)));
            columns.push(Column { name, given, unit, is_text, repeats });
        }
        let mut last_column = Digits::default();
        for row in rows.iter().filter(|row| row.ended && row.cells.len() >= least) {
            last_column.see(row.cells.get(columns.len() - 1).map_or(&[], Vec::as_slice));
        }
        let is_number = |column: &Column| column.given.parse::<f64>().is_ok_and(f64::is_finite);
        let header = match header.and_then(|at| self.lines.get(at)).map(|line| line.line) {
            None => Header::None,
            Some(line) if columns.iter().any(is_number) => Header::Numbers(line),
            Some(line) => Header::Line(line),
        };
        let points = (0..columns.len()).map(|at| self.points(&rows, at)).collect();
        // 1,250 alone may be thousands.
        let mut cells = rows
            .iter()
            .flat_map(|row| &row.cells)
            .filter(|cell| cell.contains(&b','))
            .map(|cell| text(cell));
        let is_open =
            self.decimal == Decimal::Comma && cells.all(|cell| number::is_grouped(&cell, ','));
        Shape {
            delimiter: self.delimiter,
            decimal: if is_open { Decimal::Open } else { self.decimal },
            columns,
            least,
            header,
            first,
            last_column,
            points,
            commas: None,
        }
    }
}

/// A name, without the mark of a comment before the first.
fn name(cell: &[u8], at: usize) -> String {
    let bare = if at == 0 { comment(cell).unwrap_or(cell) } else { cell };
    text(bare).split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The first run of [`BELIEVED`] neighbours with numbers in the same columns, or the longest.
fn longest_run(cells: &[Vec<Cell>]) -> core::ops::Range<usize> {
    let mut best = 0..0;
    let mut start = 0;
    let mut merged: Vec<Cell> = Vec::new();
    for (at, kinds) in cells.iter().enumerate() {
        let fits = kinds.len() == merged.len()
            && kinds
                .iter()
                .zip(&merged)
                .all(|(one, other)| one == other || [*one, *other].contains(&Cell::Blank));
        if !fits {
            start = at;
            merged.clone_from(kinds);
        }
        for (kept, kind) in merged.iter_mut().zip(kinds) {
            if *kept == Cell::Blank {
                *kept = *kind;
            }
        }
        if merged.contains(&Cell::Number) && at + 1 - start > best.len() {
            best = start..at + 1;
        }
        if best.len() >= BELIEVED {
            break;
        }
    }
    best
}

/// The number of cells that most rows have.
fn usual(widths: &(impl Iterator<Item = usize> + Clone)) -> Option<usize> {
    widths.clone().max_by_key(|width| widths.clone().filter(|other| other == width).count())
}

fn is_fraction(cell: &[u8]) -> bool {
    cell.contains(&b'.') || cell.contains(&b',')
}

/// Splits a line of names by another delimiter than the rows, where that gives as many.
fn split_otherwise(line: &mut Line, delimiter: Delimiter, width: usize) -> bool {
    let joiner = match delimiter {
        Delimiter::Byte(byte) => byte,
        Delimiter::Blanks => b' ',
    };
    let mut whole = line.cells.join(&joiner);
    if let Some(bare) = comment(&whole) {
        whole = bare.to_vec();
    }
    for other in
        [b',', b';', b'\t', b'|'].map(Delimiter::Byte).into_iter().chain([Delimiter::Blanks])
    {
        let mut records = Records::new(whole.as_slice(), other);
        let is_name = |cell: &[u8]| cell_of(cell, Decimal::Point) == Cell::Text;
        if matches!(records.advance(), Ok(true))
            && records.now.len() == width
            && records.now.cells().all(is_name)
        {
            line.cells = records.now.cells().map(<[u8]>::to_vec).collect();
            return true;
        }
    }
    false
}
