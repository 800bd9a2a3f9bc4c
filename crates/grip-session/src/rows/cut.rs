//! Parser of bytes in any pieces into rows of values, one after the other, or what is wrong with one.

use super::header::{Header, RowFormat};

/// Longest line (bytes).
const LONGEST: usize = 4096;
/// Times of the first two rows that are so far apart, in seconds and in periods, are not of one stream.
const APART: f64 = 1.5;
const APART_PERIODS: f64 = 1500.0;
/// Bytes that are kept until their rows are taken: a datagram of any size, its rows with a number each, beside as many that wait.
const MOST: usize = 192 * 1024;

/// What is wrong with a row; rows are counted from 1, without the header.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CutError {
    /// Another number of values than the header has columns.
    #[error("row {row}: {got} values, the header names {need} columns")]
    Count {
        /// The row.
        row: u64,
        /// Values in it.
        got: usize,
        /// Columns.
        need: usize,
    },
    /// A value that is no number.
    #[error("row {row}: `{text}` is no number ({column})")]
    Number {
        /// The row.
        row: u64,
        /// Name of the column.
        column: String,
        /// The value.
        text: String,
    },
    /// A value that is infinite, or absent where it must be there.
    #[error("row {row}: {column} has no finite value")]
    NotFinite {
        /// The row.
        row: u64,
        /// Name of the column.
        column: String,
    },
    /// A line without an end.
    #[error("row {row}: no end of line within {LONGEST} bytes")]
    Long {
        /// The row.
        row: u64,
    },
    /// A time that the row after it does not follow.
    #[error("row {row}: t_s is {time_s} and then {next_s}")]
    Time {
        /// The row.
        row: u64,
        /// Its time.
        time_s: f64,
        /// That of the row after it.
        next_s: f64,
    },
    /// The input ended within a packed row.
    #[error("row {row}: the input ends after {got} of {need} bytes")]
    Partial {
        /// The row.
        row: u64,
        /// Bytes there are.
        got: usize,
        /// Bytes of a row.
        need: usize,
    },
}

/// Cuts rows off a stream of bytes. At most 192 KiB are kept.
#[derive(Debug)]
pub struct RowCutter {
    header: Header,
    kept: Vec<u8>,
    start: usize,
    row: u64,
    ended: bool,
    /// Within a line that is too long: its end is no row.
    skipping: bool,
    /// Each packed row follows its number, as of a datagram.
    numbered: bool,
    time_s: Option<f64>,
    values: Vec<f32>,
}

impl RowCutter {
    /// For rows as `header` describes them.
    #[must_use]
    pub fn new(header: Header) -> Self {
        let values = Vec::with_capacity(header.values());
        Self {
            header,
            kept: Vec::new(),
            start: 0,
            row: 0,
            ended: false,
            skipping: false,
            numbered: false,
            time_s: None,
            values,
        }
    }

    /// The header.
    #[must_use]
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Number of the last row, from 1 on.
    #[must_use]
    pub fn row(&self) -> u64 {
        self.row
    }

    /// Whether rows bring their time, or a number that gives it.
    #[must_use]
    pub fn is_timed(&self) -> bool {
        self.numbered || self.header.time.is_some()
    }

    /// Time (s) of the last row, where it has one.
    #[must_use]
    pub fn time_s(&self) -> Option<f64> {
        self.time_s
    }

    /// Values of the last row in the units of the channels; NaN where there is none.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Bytes that [`RowCutter::push`] still takes.
    #[must_use]
    pub fn room(&self) -> usize {
        MOST.saturating_sub(self.kept.len() - self.start)
    }

    /// Takes bytes; no more than there is room for, the rest is dropped.
    pub fn push(&mut self, bytes: &[u8]) {
        self.kept.drain(..self.start);
        self.start = 0;
        self.kept.extend(bytes.iter().take(MOST.saturating_sub(self.kept.len())));
    }

    /// Takes one datagram of whole rows; packed ones follow the number of the first, a u32 in little endian. A header that comes again
    /// is left out. What there is no room for is dropped: the gap in times or numbers shows it.
    ///
    /// # Errors
    /// A sentence about a datagram that holds no whole rows.
    pub fn push_datagram(&mut self, bytes: &[u8]) -> Result<(), &'static str> {
        if str::from_utf8(bytes).is_ok_and(|text| text.contains("rate=")) {
            return Ok(());
        }
        if self.header.format == RowFormat::Csv {
            if bytes.len() < self.room() {
                self.push(bytes);
                self.push(b"\n");
            }
            return Ok(());
        }
        self.numbered = true;
        let Some((first, rows)) = bytes.split_first_chunk::<4>() else {
            return Err(
                "a datagram of packed rows begins with the number of its first row, 4 bytes",
            );
        };
        let rows = rows.chunks_exact(4 * self.header.names.len());
        if !rows.remainder().is_empty() {
            return Err("a datagram ends within a row");
        }
        if self.room() < bytes.len() + 4 * rows.len() {
            return Ok(());
        }
        for (at, row) in (0_u32..).zip(rows) {
            let number = u32::from_le_bytes(*first).wrapping_add(at);
            self.push(&number.to_le_bytes());
            self.push(row);
        }
        Ok(())
    }

    /// No more bytes come.
    pub fn end(&mut self) {
        self.ended = true;
    }

    /// Cuts the next row off: its values then stand in [`RowCutter::values`]. `None` where there is none yet.
    pub fn next_row(&mut self) -> Option<Result<(), CutError>> {
        match self.header.format {
            RowFormat::Csv => self.next_line(),
            RowFormat::F32 => self.next_packed(),
        }
    }

    /// As [`RowCutter::next_row`], for the first row of a text stream: it waits for the one after it where it has a time, and is bad
    /// where that one is older or far away.
    pub fn first_row(&mut self) -> Option<Result<(), CutError>> {
        let (start, row, skipping) = (self.start, self.row, self.skipping);
        let first = self.next_row()?;
        let Some(time_s) = self.time_s.filter(|_| first.is_ok()) else { return Some(first) };
        let (values, after) = (self.values.clone(), (self.start, self.row));
        let next = self.next_row();
        let next_s = self.time_s.filter(|_| matches!(next, Some(Ok(()))));
        if next.is_none() && !self.ended {
            (self.start, self.row, self.skipping) = (start, row, skipping);
            return None;
        }
        (self.start, self.row) = after;
        (self.skipping, self.time_s, self.values) = (false, Some(time_s), values);
        let apart_s = APART.max(1e-6 * APART_PERIODS * self.header.period_us());
        let wrong = next_s.filter(|next_s| !(0.0..apart_s).contains(&(next_s - time_s)));
        Some(wrong.map_or(Ok(()), |next_s| Err(CutError::Time { row: self.row, time_s, next_s })))
    }

    fn next_line(&mut self) -> Option<Result<(), CutError>> {
        loop {
            let left = self.kept.get(self.start..).unwrap_or(&[]);
            let end = left.iter().position(|byte| *byte == b'\n');
            if self.skipping || end.unwrap_or(left.len()) > LONGEST {
                self.start += end.map_or(left.len(), |end| end + 1);
                if core::mem::replace(&mut self.skipping, end.is_none()) {
                    end?;
                    continue;
                }
                self.row += 1;
                return Some(Err(CutError::Long { row: self.row }));
            }
            let (line, taken) = match end {
                Some(end) => (left.get(..end).unwrap_or(left), end + 1),
                None if left.is_empty() => return None,
                None if self.ended => (left, left.len()),
                None => return None,
            };
            let from = self.start;
            self.start += taken;
            if line.trim_ascii().is_empty() {
                continue;
            }
            self.row += 1;
            let length = line.len();
            return Some(self.read_line(from, length));
        }
    }

    fn read_line(&mut self, from: usize, length: usize) -> Result<(), CutError> {
        let Self { header, kept, row, .. } = self;
        let (row, need) = (*row, header.values());
        let line = kept.get(from..from + length).unwrap_or(&[]);
        let got = line.split(|byte| *byte == b',').count();
        if got != need {
            return Err(CutError::Count { row, got, need });
        }
        self.values.clear();
        self.time_s = None;
        for (place, cell) in line.split(|byte| *byte == b',').enumerate() {
            let cell = cell.trim_ascii();
            if header.time == Some(place) {
                let time_s = number::<f64>(cell, row, || "t_s".to_owned())?;
                let possible = time_s.is_finite() && (0.0..1e12).contains(&time_s);
                let column = || "t_s".to_owned();
                self.time_s = Some(time_s).filter(|_| possible);
                self.time_s.ok_or_else(|| CutError::NotFinite { row, column: column() })?;
                continue;
            }
            let at = self.values.len();
            let column = || header.names.get(at).cloned().unwrap_or_default();
            let value = if cell.is_empty() { f32::NAN } else { number(cell, row, column)? };
            self.values.push(checked(header, at, value, row)?);
        }
        Ok(())
    }

    fn next_packed(&mut self) -> Option<Result<(), CutError>> {
        let number = if self.numbered { 4 } else { 0 };
        let need = number + 4 * self.header.names.len();
        let left = self.kept.get(self.start..).unwrap_or(&[]);
        let Some(bytes) = left.get(..need) else {
            let got = left.len();
            if !self.ended || got == 0 {
                return None;
            }
            self.start = self.kept.len();
            self.row += 1;
            return Some(Err(CutError::Partial { row: self.row, got, need }));
        };
        self.start += need;
        self.row += 1;
        self.values.clear();
        let (mut cells, _) = bytes.as_chunks::<4>();
        if self.numbered
            && let Some((number, rest)) = cells.split_first()
        {
            self.time_s = Some(f64::from(u32::from_le_bytes(*number)) / self.header.rate_hz);
            cells = rest;
        }
        for (at, cell) in cells.iter().enumerate() {
            match checked(&self.header, at, f32::from_le_bytes(*cell), self.row) {
                Ok(value) => self.values.push(value),
                Err(error) => return Some(Err(error)),
            }
        }
        Some(Ok(()))
    }
}

fn number<N: core::str::FromStr>(
    cell: &[u8],
    row: u64,
    column: impl FnOnce() -> String,
) -> Result<N, CutError> {
    let text = str::from_utf8(cell).ok();
    text.and_then(|text| text.parse().ok()).ok_or_else(|| CutError::Number {
        row,
        column: column(),
        text: String::from_utf8_lossy(cell).chars().take(40).collect(),
    })
}

/// A value in the unit of its channel. Only a stylus that is a column must be there, and nothing may be infinite.
fn checked(header: &Header, at: usize, value: f32, row: u64) -> Result<f32, CutError> {
    let value = value * header.factors.get(at).copied().unwrap_or(1.0);
    if value.is_infinite() || (value.is_nan() && Some(at) == header.stylus) {
        let column = header.names.get(at).cloned().unwrap_or_default();
        return Err(CutError::NotFinite { row, column });
    }
    Ok(value)
}

#[cfg(test)]
mod tests {
    use super::{CutError, MOST, RowCutter};

    fn cutter(header: &str) -> RowCutter {
        RowCutter::new(header.parse().unwrap())
    }

    fn all(cutter: &mut RowCutter) -> Vec<Result<Vec<f32>, CutError>> {
        let mut rows = Vec::new();
        while let Some(row) = cutter.next_row() {
            rows.push(row.map(|()| cutter.values().to_vec()));
        }
        rows
    }

    #[test]
    fn pieces_of_any_size_give_the_same_rows() {
        let text = "0,1,2\r\n\n0.5, -3e-2 ,\n1,4,nan\n2,5,6";
        let mut wanted = None;
        for size in 1..=text.len() {
            let mut cutter = cutter("t_s,vibration,travel_mm,rate=100");
            let mut rows = Vec::new();
            for piece in text.as_bytes().chunks(size) {
                cutter.push(piece);
                rows.extend(all(&mut cutter));
            }
            cutter.end();
            rows.extend(all(&mut cutter));
            let shown = format!("{rows:?}");
            assert_eq!(*wanted.get_or_insert(shown.clone()), shown, "pieces of {size}");
            assert_eq!((rows.len(), cutter.time_s()), (4, Some(2.0)));
            assert_eq!(rows[0], Ok(vec![1.0, 2e-3]));
            assert!(rows[1].as_ref().unwrap()[1].is_nan() && rows[2].as_ref().unwrap()[1].is_nan());
        }
    }

    #[test]
    fn packed_rows_are_the_same_numbers() {
        let mut cutter = cutter("force_n,vibration,rate=100,format=f32");
        let bytes: Vec<u8> =
            [f32::NAN, 1.0, 3.0, -2.0, 7.0].into_iter().flat_map(f32::to_le_bytes).collect();
        for byte in bytes {
            cutter.push(&[byte]);
        }
        cutter.end();
        let rows = all(&mut cutter);
        assert!(rows[0].as_ref().unwrap()[0].is_nan());
        assert_eq!(rows[1], Ok(vec![3.0, -2.0]));
        assert_eq!(rows[2], Err(CutError::Partial { row: 3, got: 4, need: 8 }));
    }

    #[test]
    fn a_bad_row_is_named_and_the_next_one_is_good() {
        let mut cutter = cutter("t_s,vibration,force_n,rate=100");
        let long = "9".repeat(5000);
        let cases = [
            ("1,2\n", "row 1: 2 values, the header names 3 columns"),
            ("1,2,3,4\n", "row 2: 4 values, the header names 3 columns"),
            ("1,x,3\n", "row 3: `x` is no number (vibration)"),
            ("1,nan,3\n", "row 4: vibration has no finite value"),
            ("1,,3\n", "row 5: vibration has no finite value"),
            ("1,2,inf\n", "row 6: force_n has no finite value"),
            (",2,3\n", "row 7: `` is no number (t_s)"),
            ("-1,2,3\n", "row 8: t_s has no finite value"),
            ("1,1e39,3\n", "row 9: vibration has no finite value"),
            ("1,\u{1F980},3\n", "is no number (vibration)"),
            (&long, "row 11: no end of line within 4096 bytes"),
        ];
        for (text, words) in cases {
            cutter.push(text.as_bytes());
            let error = cutter.next_row().unwrap().unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
        cutter.push(b"00000.101,99.5,7\n1,2,3\n");
        assert_eq!(all(&mut cutter), [Ok(vec![2.0, 3.0])], "the end of a line is no row");
        cutter.push(format!("{long}\n4,5,6\n").as_bytes());
        let rows = all(&mut cutter);
        assert_eq!(rows, [Err(CutError::Long { row: 13 }), Ok(vec![5.0, 6.0])]);
    }

    #[test]
    fn memory_is_bounded() {
        let mut cutter = cutter("vibration,rate=100");
        for _ in 0..100 {
            cutter.push(&[b'1'; 4000]);
        }
        assert_eq!((cutter.room(), cutter.kept.len()), (0, MOST));
    }
}
