//! A CSV recording in, its samples and what is odd about them out.

use std::fs;
use std::path::Path;

use slip_core::sample::{Arrival, Sample};
use slip_core::units::Micros;

use crate::channels::{ChannelSet, Scale};
use crate::error::CsvError;
use crate::layout::Layout;
use crate::notes::Notes;
use crate::number::parse_reading;
use crate::table::{Row, Table};
use crate::taxels::Taxels;

/// What the file itself does not tell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CsvOptions {
    /// Samples per second, 0.001 to 1e6 Hz. Needed without a time column (t = i / rate); beside one it is the
    /// rate reported, and the file's times stay.
    pub rate_hz: Option<f32>,
    /// Renamings: (known name, the file's column); see [`COLUMN_NAMES`](crate::COLUMN_NAMES).
    pub map: Vec<(String, String)>,
}

/// A recording read from a file: at least one sample, times never decreasing.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// File name without its ending.
    pub name: String,
    /// The columns present and where they came from.
    pub channels: ChannelSet,
    /// The rows, in order.
    pub samples: Vec<Sample>,
    /// The frames of the taxel array, where there is one.
    pub taxels: Option<Taxels>,
    /// Samples per second (Hz): given, else measured from the times (robust against gaps).
    pub rate_hz: f32,
    /// Counts of what is odd.
    pub notes: Notes,
}

/// Reads the recording in `file`.
///
/// # Errors
/// Where the file cannot be read, or its header, a row or an option is not usable; see [`CsvError`].
pub fn read_csv(file: &Path, options: &CsvOptions) -> Result<Recording, CsvError> {
    parse_csv(file, &read_bytes(file)?, options)
}

/// The recording whose bytes are `bytes`; `file` gives its name and stands in errors.
///
/// # Errors
/// Where the header, a row or an option is not usable; see [`CsvError`].
pub fn parse_csv(file: &Path, bytes: &[u8], options: &CsvOptions) -> Result<Recording, CsvError> {
    let given_rate = options.rate_hz.map(checked_rate).transpose()?;
    let mut table = Table::open(file, bytes)?;
    let layout = Layout::resolve(file, table.header(), options)?;
    let mut notes = Notes {
        trailing_comma: table.header().last().is_some_and(String::is_empty),
        given_rate_hz: given_rate,
        ignored_columns: layout.ignored.iter().filter(|name| !name.is_empty()).cloned().collect(),
        ..Notes::default()
    };
    let one_column = table.header().len() == 1;
    let mut samples: Vec<Sample> = Vec::new();
    let mut taxels = Taxels::new(layout.taxels.len());
    while let Some(row) = table.next_row()? {
        if one_column && !samples.is_empty() {
            push_blank_lines(&mut samples, &mut notes, (row.blank_before, given_rate));
        } else {
            notes.blank_lines += row.blank_before;
        }
        let time = match layout.time {
            Some(column) => row.time(column, samples.last().map(|sample| sample.t))?,
            None => nth_time(samples.len(), given_rate),
        };
        samples.push(sample_of(&row, &layout, time, &mut notes)?);
        taxels.push(&frame_of(&row, &layout, &mut notes)?);
    }
    if samples.is_empty() {
        return Err(CsvError::NoRows { file: file.to_owned() });
    }
    if layout.time.is_some() {
        notes.count_steps(&samples);
    }
    let rate_hz = given_rate
        .or(notes.measured_rate_hz)
        .ok_or_else(|| CsvError::NoRate { file: file.to_owned(), rows: samples.len() })?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let taxels = Some(taxels).filter(|taxels| taxels.count() > 0);
    Ok(Recording { name, channels: layout.channels, samples, taxels, rate_hz, notes })
}

pub(crate) fn read_bytes(file: &Path) -> Result<Vec<u8>, CsvError> {
    fs::read(file).map_err(|source| CsvError::Unreadable { file: file.to_owned(), source })
}

fn checked_rate(rate_hz: f32) -> Result<f32, CsvError> {
    if (0.001..=1e6).contains(&rate_hz) { Ok(rate_hz) } else { Err(CsvError::BadRate { rate_hz }) }
}

/// In a file of one column an empty stylus cell is a blank line; without it all later times would shift.
fn push_blank_lines(
    samples: &mut Vec<Sample>,
    notes: &mut Notes,
    (count, rate): (usize, Option<f32>),
) {
    notes.empty_stylus += count;
    for _ in 0..count {
        samples.push(Sample::stylus(nth_time(samples.len(), rate), f32::NAN));
    }
}

/// Time of row `index` at `rate` samples per second; [`Layout`] has made sure that there is one.
#[expect(clippy::cast_precision_loss, reason = "exact up to 2^53 rows")]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rounded, not negative, saturating"
)]
fn nth_time(index: usize, rate: Option<f32>) -> Micros {
    let period_us = rate.map_or(0.0, |rate| 1e6 / f64::from(rate));
    Micros((index as f64 * period_us).round() as u64)
}

fn sample_of(
    row: &Row<'_>,
    layout: &Layout,
    time: Micros,
    notes: &mut Notes,
) -> Result<Sample, CsvError> {
    let stylus = match reading(row, layout.stylus, Scale::Same)? {
        Some(stylus) => {
            notes.count_reading(stylus);
            stylus
        }
        None => {
            notes.empty_stylus += 1;
            f32::NAN
        }
    };
    let mut sample = Sample::stylus(time, stylus);
    for &(column, channel, scale) in &layout.optional {
        let value = reading(row, column, scale)?;
        if let Some(value) = value {
            notes.count_reading(value);
        }
        channel.set(&mut sample, value);
    }
    sample.arrival = arrival(row, layout)?;
    Ok(sample)
}

/// When the computer took the row in; `None` where a cell is empty.
fn arrival(row: &Row<'_>, layout: &Layout) -> Result<Option<Arrival>, CsvError> {
    let Some([at, age]) = layout.arrival else { return Ok(None) };
    let micros = |column| {
        let text = row.cell(column);
        let wrong = || row.not_a_number(column, "write whole microseconds");
        if text.is_empty() {
            Ok(None)
        } else {
            text.parse().map(|us| Some(Micros(us))).map_err(|_| wrong())
        }
    };
    Ok(micros(at)?.zip(micros(age)?).map(|(at, age)| Arrival { at, age }))
}

/// The frame in a row; empty where every cell is.
fn frame_of(row: &Row<'_>, layout: &Layout, notes: &mut Notes) -> Result<Vec<f32>, CsvError> {
    let mut frame = Vec::with_capacity(layout.taxels.len());
    let mut any = false;
    for &column in &layout.taxels {
        let value = reading(row, column, Scale::Same)?;
        any |= value.is_some();
        if let Some(value) = value {
            notes.count_reading(value);
        }
        frame.push(value.unwrap_or(f32::NAN));
    }
    if !any {
        frame.clear();
    }
    Ok(frame)
}

const READING: &str = "write digits with a decimal point, NaN for a bad reading";

/// The reading in a cell, `None` if it is empty.
fn reading(row: &Row<'_>, column: usize, scale: Scale) -> Result<Option<f32>, CsvError> {
    let text = row.cell(column);
    if text.is_empty() {
        return Ok(None);
    }
    parse_reading(&text, scale).map(Some).ok_or_else(|| row.not_a_number(column, READING))
}
