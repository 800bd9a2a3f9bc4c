//! A recording as arrays, and an `.npz` of them in and out.
//!
//! Columns have the names, units and meanings of a CSV recording. A NaN is an empty cell, as NumPy has no other, but for the
//! stylus, where it is a bad reading.

use std::path::{Path, PathBuf};

use ndarray::{Array1, Array2};
use ndarray_npy::WriteNpzError;
use slip_core::sample::Sample;
use slip_core::units::Micros;

use crate::channels::{ARRIVAL, Channel, Scale, StylusKind};
use crate::csv_read::CsvOptions;
use crate::error::{CsvError, excerpt};
use crate::npz::{NpzArrays, NpzError, create};
use crate::numbers::{NumberRows, NumberTable, Pick};
use crate::recording::{Cells, Gathering, Recording};
use crate::taxels::PREFIX;

const NONE: &Vec<String> = &Vec::new();

/// Reads the recording in an `.npz`; arrays that are no columns of a recording are left alone.
pub(crate) fn read_npz(file: &Path, options: &CsvOptions) -> Result<Recording, CsvError> {
    NumberSamples::of_npz(file, options)?.hold()
}

/// The samples of a table of numbers one after the other, as the file is read: the memory does not depend on its length.
#[derive(Debug)]
pub struct NumberSamples {
    file: PathBuf,
    header: Vec<String>,
    rows: NumberRows,
    gathering: Gathering,
    row: Vec<f64>,
    count: u64,
}

impl NumberSamples {
    /// The recording in an `.npz`; arrays that are no columns of a recording are left alone.
    ///
    /// # Errors
    /// Where the file cannot be read, or its columns or an option is not usable.
    pub fn of_npz(file: &Path, options: &CsvOptions) -> Result<Self, CsvError> {
        let mut npz = NpzArrays::open(file)?;
        let header = npz.names().to_vec();
        let gathering = Gathering::new(file, &header, options)?;
        let mut table = NumberTable::new(file);
        let mut picks = Vec::new();
        for (at, name) in header.iter().enumerate() {
            let place = table.columns.len();
            let used = gathering.layout.uses(at);
            picks.push(Pick { column: used.then_some(place), ..Pick::plain(place) });
            if used {
                let column = npz.table(at)?;
                check_column(&table, &column, name)?;
                table.append(column);
            }
        }
        Self::gathered(&table, header, &picks, gathering)
    }

    /// The columns of `table` that are picked, each under its name in `header`: those of a CSV recording, `t_s` in seconds.
    ///
    /// # Errors
    /// As [`NumberSamples::of_npz`].
    pub fn open(
        table: &NumberTable,
        header: Vec<String>,
        picks: &[Pick],
        options: &CsvOptions,
    ) -> Result<Self, CsvError> {
        let gathering = Gathering::new(&table.file, &header, options)?;
        Self::gathered(table, header, picks, gathering)
    }

    fn gathered(
        table: &NumberTable,
        header: Vec<String>,
        picks: &[Pick],
        mut gathering: Gathering,
    ) -> Result<Self, CsvError> {
        let file = table.file.clone();
        let rows = table.rows(picks);
        let rows = rows.map_err(|source| CsvError::Unreadable { file: file.clone(), source })?;
        gathering.notes.cut.clone_from(&table.cut);
        Ok(Self { file, header, rows, gathering, row: Vec::new(), count: 0 })
    }

    /// The next sample and the frame of taxels that came with it, which is empty where none did; `None` at the end.
    ///
    /// # Errors
    /// Where a row is not usable, or the file cannot be read on.
    pub fn next_sample(&mut self) -> Result<Option<(Sample, &[f32])>, CsvError> {
        let sample = self.next()?;
        Ok(sample.map(|sample| (sample, self.gathering.frame())))
    }

    fn next(&mut self) -> Result<Option<Sample>, CsvError> {
        let Self { file, header, rows, gathering, row, count } = self;
        let more = rows.next_row(row);
        if !more.map_err(|source| CsvError::Unreadable { file: file.clone(), source })? {
            return Ok(None);
        }
        *count += 1;
        let stylus = gathering.layout.stylus;
        let sample = gathering.sample(&ArrayRow { file, header, row, stylus, line: *count });
        if sample.is_err() {
            // Damaged bytes make odd numbers: that is then the fault.
            rows.drain().map_err(|source| CsvError::Unreadable { file: file.clone(), source })?;
        }
        sample.map(Some)
    }

    /// The recording without its samples: channels, rate and what is odd about it. Reads what is left of the file.
    ///
    /// # Errors
    /// Where a row is not usable, there is none, or no rate.
    pub fn survey(mut self) -> Result<Recording, CsvError> {
        while self.next()?.is_some() {}
        self.gathering.finish()
    }

    /// The recording with its samples.
    ///
    /// # Errors
    /// As [`NumberSamples::survey`]; where there are more samples than are held, before any is read.
    pub fn hold(mut self) -> Result<Recording, CsvError> {
        self.gathering.check_room(self.rows.left())?;
        while let Some(sample) = self.next()? {
            self.gathering.keep(sample)?;
        }
        self.gathering.finish()
    }
}

/// Whether `column` is one, and as long as those before it.
fn check_column(table: &NumberTable, column: &NumberTable, name: &str) -> Result<(), NpzError> {
    let (file, array) = (table.file.clone(), name.to_owned());
    if column.columns.len() != 1 {
        let fault = format!("has {} columns; one is expected", column.columns.len());
        return Err(NpzError::Array { file, array, fault });
    }
    match table.columns.first() {
        Some(first) if table.rows != column.rows => Err(NpzError::Length {
            file,
            array,
            rows: column.rows,
            first: first.name.clone(),
            expected: table.rows,
        }),
        _ => Ok(()),
    }
}

/// One row of numbers.
struct ArrayRow<'a> {
    file: &'a Path,
    header: &'a [String],
    row: &'a [f64],
    stylus: Option<usize>,
    line: u64,
}

impl ArrayRow<'_> {
    fn value(&self, column: usize) -> f64 {
        self.row.get(column).copied().unwrap_or(f64::NAN)
    }

    fn name(&self, column: usize) -> String {
        self.header.get(column).cloned().unwrap_or_default()
    }
}

impl Cells for ArrayRow<'_> {
    fn time(&self, column: usize, previous: Option<Micros>) -> Result<Micros, CsvError> {
        let (file, line, seconds) = (self.file.to_owned(), self.line, self.value(column));
        let column = self.name(column);
        let Some(time) = micros(1e6 * seconds) else {
            let text = excerpt(&seconds.to_string());
            return Err(CsvError::TimeOutOfRange { file, line, column, text });
        };
        match previous.filter(|before| *before > time) {
            None => Ok(time),
            Some(before) => Err(CsvError::TimeBackwards { file, line, column, before, time }),
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "rounding to the precision of a Sample")]
    fn reading(&self, column: usize, scale: Scale) -> Result<Option<f32>, CsvError> {
        let value = match scale {
            Scale::Same => self.value(column),
            Scale::MilliToUnit => self.value(column) / 1000.0,
        };
        Ok(Some(value as f32).filter(|value| Some(column) == self.stylus || !value.is_nan()))
    }

    fn micros(&self, column: usize) -> Result<Option<Micros>, CsvError> {
        let value = self.value(column);
        if value.is_nan() {
            return Ok(None);
        }
        let whole = micros(value).filter(|_| value.fract() == 0.0);
        whole.map(Some).ok_or_else(|| CsvError::NotANumber {
            file: self.file.to_owned(),
            line: self.line,
            column: self.name(column),
            text: excerpt(&value.to_string()),
            remedy: "write whole microseconds",
        })
    }
}

/// Whole microseconds, as those of a CSV cell: what is not below 0 by more than 0.1 us and finds room.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked before")]
fn micros(us: f64) -> Option<Micros> {
    (us > -0.1 && us < 1.8e19).then(|| Micros(us.round() as u64))
}

impl Recording {
    /// Times of the samples (s).
    #[must_use]
    pub fn times_s(&self) -> Array1<f64> {
        self.samples.iter().map(|sample| sample.t.0 as f64 / 1e6).collect()
    }

    /// Names of the columns of [`Recording::readings`]: the stylus and the channels there are, then the taxels.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        let channels = self.channels.columns().into_iter().map(str::to_owned);
        let taxels = (0..self.taxel_count()).map(|taxel| format!("{PREFIX}{taxel}"));
        channels.chain(taxels).collect()
    }

    /// All readings in the units of a CSV recording, samples x columns; NaN where a channel shows nothing.
    #[must_use]
    pub fn readings(&self) -> Array2<f32> {
        let mut readings = Array2::from_elem((self.samples.len(), self.columns().len()), f32::NAN);
        let has_stylus = self.channels.stylus != StylusKind::Absent;
        for (at, (sample, mut row)) in self.samples.iter().zip(readings.rows_mut()).enumerate() {
            let further = |names: &Vec<String>| names.len().saturating_sub(1);
            let axes = sample.stylus_axes.into_iter().take(further(&self.channels.axes));
            let values = self.channels.optional.keys().flat_map(|channel| {
                let own = if *channel == Channel::Reference {
                    &self.channels.reference_axes
                } else {
                    NONE
                };
                let axes = sample.reference_axes.into_iter().take(further(own));
                let axes = axes.map(|axis| sample.reference.map(|_| axis));
                core::iter::once(channel.reading(sample)).chain(axes)
            });
            let frame = self.taxels.as_ref().map_or(&[] as &[f32], |taxels| taxels.frame(at));
            let stylus = has_stylus.then_some(Some(sample.stylus));
            let stylus = stylus.into_iter().chain(axes.map(Some));
            let values = stylus.chain(values).chain(frame.iter().copied().map(Some));
            for (place, value) in row.iter_mut().zip(values) {
                *place = value.unwrap_or(f32::NAN);
            }
        }
        readings
    }

    /// Writes `file` as an `.npz` that [`read_recording`](crate::read_recording) reads back: `t_s` and the arrivals as float64, readings as float32.
    /// A NaN reading of another channel than the stylus comes back as none.
    ///
    /// # Errors
    /// Where the file cannot be written.
    pub fn write_npz(&self, file: &Path) -> Result<(), WriteNpzError> {
        let mut npz = create(file)?;
        npz.add_array("t_s", &self.times_s())?;
        let readings = self.readings();
        for (name, column) in self.columns().iter().zip(readings.columns()) {
            npz.add_array(name.as_str(), &column)?;
        }
        if self.channels.arrivals {
            let us = |time: Micros| time.0 as f64;
            for (name, age) in ARRIVAL.into_iter().zip([false, true]) {
                let column = self.samples.iter().map(|sample| {
                    let arrival = sample.arrival;
                    arrival.map_or(f64::NAN, |a| us(if age { a.age } else { a.at }))
                });
                npz.add_array(name, &column.collect::<Array1<f64>>())?;
            }
        }
        npz.finish().map(drop)
    }

    fn taxel_count(&self) -> usize {
        self.taxels.as_ref().map_or(0, crate::Taxels::count)
    }
}
