//! A recording as arrays, and an `.npz` of them in and out.
//!
//! Columns have the names, units and meanings of a CSV recording. A NaN is an empty cell, as NumPy has no other, but for the
//! stylus, where it is a bad reading.

use std::path::Path;

use grip_table::TableError;
use ndarray::{Array1, Array2};
use ndarray_npy::WriteNpzError;
use slip_core::units::Micros;

use crate::channels::{ARRIVAL, Channel, Scale, StylusKind};
use crate::csv_read::CsvOptions;
use crate::error::{CsvError, excerpt};
use crate::find::Signal;
use crate::npz::{Npz, create};
use crate::plan::{Head, Plan};
use crate::recording::{Cells, Gathering, Recording};
use crate::taxels::PREFIX;
use crate::time::TimeUnit;

const NONE: &Vec<String> = &Vec::new();

/// Reads the recording in an `.npz`; arrays that are no columns of a recording are left alone.
pub(crate) fn read_npz(file: &Path, options: &CsvOptions) -> Result<Recording, CsvError> {
    let mut npz = Npz::open(file)?;
    let header = npz.names().to_vec();
    let signal = |name: &String| Signal {
        name: name.clone(),
        unit: grip_table::of_name(name).map(|(_, unit)| unit),
        ..Signal::default()
    };
    let signals = header.iter().map(signal).collect();
    let head = Head { signals, named: true, nameless: Vec::new() };
    let plan = Plan::find(file, &head, options, |column| {
        let times = header.get(column).map(|name| npz.numbers(name));
        let times = times.and_then(Result::ok).map(|times| times.to_vec());
        (times.unwrap_or_default(), Vec::new())
    })?;
    let mut gathering = Gathering::planned(file, &plan, options)?;
    let columns: Vec<Option<Array1<f64>>> = header
        .iter()
        .enumerate()
        .map(|(at, name)| gathering.layout.uses(at).then(|| npz.numbers(name)).transpose())
        .collect::<Result<_, _>>()?;
    let (stylus, rows) = (gathering.layout.stylus, npz.rows());
    for row in 0..rows {
        gathering.push(&ArrayRow { file, header: &header, columns: &columns, stylus, row })?;
    }
    gathering.notes.remarks.extend(plan.found.notes);
    gathering.finish()
}

/// One row of an `.npz`.
struct ArrayRow<'a> {
    file: &'a Path,
    header: &'a [String],
    columns: &'a [Option<Array1<f64>>],
    stylus: Option<usize>,
    row: usize,
}

impl ArrayRow<'_> {
    fn value(&self, column: usize) -> f64 {
        let column = self.columns.get(column).and_then(Option::as_ref);
        column.and_then(|column| column.get(self.row)).copied().unwrap_or(f64::NAN)
    }

    fn line(&self) -> u64 {
        self.row as u64 + 1
    }

    fn name(&self, column: usize) -> String {
        self.header.get(column).cloned().unwrap_or_default()
    }
}

impl Cells for ArrayRow<'_> {
    fn stamp(&self, column: usize, unit: TimeUnit) -> Result<i64, CsvError> {
        let value = self.value(column);
        unit.to_ns(value).ok_or_else(|| CsvError::TimeOutOfRange {
            file: self.file.to_owned(),
            line: self.line(),
            column: self.name(column),
            text: excerpt(&value.to_string()),
        })
    }

    fn place(&self, column: usize) -> (&Path, u64, String) {
        (self.file, self.line(), self.name(column))
    }

    fn reading(&self, column: usize, scale: Scale) -> Result<Option<f32>, CsvError> {
        let value = scale.narrow(self.value(column));
        Ok(Some(value).filter(|value| Some(column) == self.stylus || !value.is_nan()))
    }

    fn micros(&self, column: usize) -> Result<Option<Micros>, CsvError> {
        let value = self.value(column);
        if value.is_nan() {
            return Ok(None);
        }
        let whole = micros(value).filter(|_| value.fract() == 0.0);
        whole.map(Some).ok_or_else(|| {
            TableError::NotANumber {
                file: self.file.to_owned(),
                line: self.line(),
                column: self.name(column),
                text: excerpt(&value.to_string()),
                remedy: "write whole microseconds",
            }
            .into()
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
