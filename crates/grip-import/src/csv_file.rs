//! A table of any program in: commas, semicolons or tabs, with a header or without.

use crate::{
    ImportOptions,
    error::ImportError,
    stream::{Room, Stream, Times, reading},
    time::{TimeUnit, is_time},
    tsf85,
};
use csv::{ByteRecord, ReaderBuilder};
use grip_record::files;
use std::{
    fs::File,
    io::{BufRead as _, BufReader, Read as _, Seek as _, SeekFrom},
    path::Path,
};

/// Longest line of a table (bytes), and lines of text before it.
const LONGEST_LINE: u64 = 1 << 20;
const MOST_PREAMBLE: usize = 100;

pub(crate) fn read(
    file: &Path,
    options: &ImportOptions,
) -> Result<(&'static str, Vec<Stream>), ImportError> {
    let input = files::open(file).map_err(ImportError::unreadable(file))?;
    let (start, delimiter, names) = head(file, &input)?;
    let tsf = tsf85::Layout::of(&names, options.finger);
    let tsf = tsf.map_err(|fault| ImportError::nothing(file, &fault))?;
    let time = time_column(&names, options);
    let columns: Vec<usize> = (0..names.len()).filter(|column| Some(*column) != time).collect();
    let mut table = Table {
        file,
        names: &names,
        columns: &columns,
        time,
        times: Vec::new(),
        stream: Stream::new("", columns.iter().map(|&at| names[at].clone()).collect()),
        room: Room::default(),
        skip: usize::from(tsf.is_some()),
        empty_lines: 0,
    };
    let mut body = BufReader::new(input);
    body.seek(SeekFrom::Start(start.offset)).map_err(ImportError::unreadable(file))?;
    table.rows(body, delimiter, start.line)?;
    let Table { times, mut stream, empty_lines, .. } = table;
    if empty_lines > 0 {
        stream.notes.push(format!("{empty_lines} rows without a number, left out"));
    }
    if let Some(column) = time {
        let name = names.get(column).map_or("", String::as_str);
        let unit = options
            .time_unit
            .or_else(|| TimeUnit::of_name(name))
            .map_or_else(|| TimeUnit::of_numbers(&times), Ok);
        let unit = unit.map_err(|fault| {
            ImportError::nothing(file, &format!("the times in {name:?} {fault}"))
        })?;
        stream.clock = format!("{name:?} ({})", unit.name());
        let stamps: Option<Vec<i64>> = times.into_iter().map(|t| unit.to_ns(t)).collect();
        let stamps = stamps.ok_or_else(|| {
            ImportError::nothing(
                file,
                &format!("a time in {name:?} is no number of {}", unit.name()),
            )
        })?;
        stream.times = Times::Stamps(stamps);
    }
    match tsf {
        Some(layout) => Ok(("Robotiq TSF-85", vec![layout.apply(stream)])),
        None if names.iter().enumerate().all(|(k, name)| *name == format!("column_{k}")) => {
            Ok(("CSV", vec![stream.without_names()]))
        }
        None => Ok(("CSV", vec![stream])),
    }
}

/// Where the rows begin.
struct Start {
    offset: u64,
    line: u64,
}

/// Finds delimiter and names; lines of text before them are passed over.
fn head(file: &Path, input: &File) -> Result<(Start, u8, Vec<String>), ImportError> {
    let mut reader = BufReader::new(input);
    let mut offset = 0;
    for line in 1..=MOST_PREAMBLE as u64 {
        let mut bytes = Vec::new();
        let read = (&mut reader).take(LONGEST_LINE).read_until(b'\n', &mut bytes);
        let read = read.map_err(ImportError::unreadable(file))? as u64;
        if read == LONGEST_LINE {
            let what = format!("is no table: line {line} has more than {LONGEST_LINE} bytes");
            return Err(ImportError::nothing(file, &what));
        }
        if read == 0 {
            break;
        }
        let text = String::from_utf8_lossy(&bytes);
        let text = text.trim_start_matches('\u{feff}').trim();
        let next = Start { offset: offset + read, line: line + 1 };
        let here = Start { offset, line };
        offset += read;
        if text.is_empty() || text.starts_with("//") {
            continue;
        }
        // A comment may be the header.
        let text = text.trim_start_matches(['#', '%']).trim();
        let delimiter =
            [b';', b'\t', b','].into_iter().max_by_key(|d| text.bytes().filter(|b| b == d).count());
        let delimiter = delimiter.filter(|d| text.contains(char::from(*d))).unwrap_or(b',');
        let cells: Vec<&str> =
            text.split(char::from(delimiter)).map(|cell| cell.trim().trim_matches('"')).collect();
        let numbers = cells.iter().filter(|cell| cell.parse::<f64>().is_ok()).count();
        if numbers == cells.len() {
            let names = (0..cells.len()).map(|k| format!("column_{k}")).collect();
            return Ok((here, delimiter, names));
        }
        if numbers == 0 && (cells.len() > 1 || is_table_below(&mut reader, offset)) {
            return Ok((next, delimiter, named(&cells)));
        }
    }
    Err(ImportError::nothing(
        file,
        "is no table: no line of names or numbers was found at its start",
    ))
}

/// Whether a line of one word is the header of one column: a number follows.
fn is_table_below(reader: &mut BufReader<&File>, offset: u64) -> bool {
    let mut line = Vec::new();
    let read = reader.take(LONGEST_LINE).read_until(b'\n', &mut line).is_ok();
    let number = String::from_utf8_lossy(&line).trim().parse::<f64>().is_ok();
    read && reader.seek(SeekFrom::Start(offset)).is_ok() && number
}

/// Names, those without one or with that of another by their place.
fn named(cells: &[&str]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (k, cell) in cells.iter().enumerate() {
        let taken = cell.is_empty() || names.iter().any(|name| name == cell);
        names.push(if taken { format!("column_{k}") } else { (*cell).to_owned() });
    }
    names
}

/// The column of times: named by the caller, or by itself.
pub(crate) fn time_column(names: &[String], options: &ImportOptions) -> Option<usize> {
    if let Some((_, theirs)) = options.map.iter().find(|(ours, _)| ours == "t_s") {
        return names.iter().position(|name| name == theirs);
    }
    if options.rate_hz.is_some() {
        return names.iter().position(|name| name == "t_s");
    }
    let named = names.iter().position(|name| is_time(name));
    // Without names, several columns begin with the times.
    named.or_else(|| {
        (names.len() > 1 && names.first().is_some_and(|name| name == "column_0")).then_some(0)
    })
}

struct Table<'a> {
    file: &'a Path,
    names: &'a [String],
    columns: &'a [usize],
    time: Option<usize>,
    times: Vec<f64>,
    stream: Stream,
    room: Room,
    /// Rows at the start that are none.
    skip: usize,
    empty_lines: usize,
}

impl Table<'_> {
    fn rows(
        &mut self,
        input: impl std::io::Read,
        delimiter: u8,
        first_line: u64,
    ) -> Result<(), ImportError> {
        let mut reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(delimiter)
            .from_reader(input);
        let mut record = ByteRecord::new();
        loop {
            let more = reader.read_byte_record(&mut record).map_err(|error| {
                ImportError::Unreadable { file: self.file.to_owned(), source: error.into() }
            })?;
            if !more {
                return Ok(());
            }
            let line = first_line + record.position().map_or(0, |at| at.line().saturating_sub(1));
            if self.skip > 0 {
                self.skip -= 1;
                continue;
            }
            self.row(&record, line)?;
        }
    }

    fn row(&mut self, record: &ByteRecord, line: u64) -> Result<(), ImportError> {
        // A line may end with a delimiter.
        let width = record.len()
            - usize::from(
                record.len() == self.names.len() + 1 && record.iter().next_back() == Some(b""),
            );
        if width != self.names.len() {
            let what =
                format!("line {line} has {width} cells where the names are {}", self.names.len());
            return Err(ImportError::nothing(self.file, &what));
        }
        let cell = |column: usize| record.get(column).unwrap_or_default().trim_ascii();
        if self.columns.iter().all(|column| cell(*column).is_empty()) {
            self.empty_lines += 1;
            return Ok(());
        }
        if let Some(column) = self.time {
            let time = self.number(cell(column), column, line)?;
            if let Some(before) =
                self.times.last().filter(|before| time.is_nan() || time < **before)
            {
                let name = self.names.get(column).map_or("", String::as_str);
                let what = format!(
                    "line {line}, column {name}: time goes from {before} to {time}; sort the rows or split the file there"
                );
                return Err(ImportError::nothing(self.file, &what));
            }
            self.times.push(time);
        }
        self.room.take(self.file, record.len() + 1)?;
        for (at, &column) in self.columns.iter().enumerate() {
            let text = cell(column);
            let value = if text.is_empty() { f64::NAN } else { self.number(text, column, line)? };
            if let Some(values) = self.stream.values.get_mut(at) {
                values.push(reading(value));
            }
        }
        Ok(())
    }

    fn number(&self, text: &[u8], column: usize, line: u64) -> Result<f64, ImportError> {
        let shown = String::from_utf8_lossy(text);
        shown.parse().map_err(|_| {
            let name = self.names.get(column).map_or("", String::as_str);
            let shown: String = shown.chars().take(40).collect();
            let comma = if shown.contains(',') { " (a decimal comma is not read)" } else { "" };
            let what = format!("line {line}, column {name}: {shown:?} is not a number{comma}");
            ImportError::nothing(self.file, &what)
        })
    }
}
