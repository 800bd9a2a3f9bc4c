//! A recording as arrays, and an `.npz` of them in and out.
//!
//! Columns have the names, units and meanings of a CSV recording. A NaN is an empty cell, as NumPy has no other, but for the
//! stylus, where it is a bad reading.

use std::io::{Seek, Write};
use std::path::{Path, PathBuf};

use grip_table::TableError;
use ndarray::{Array1, Array2};
use slip_core::sample::Sample;
use slip_core::units::Micros;
use zip::{ZipWriter, result::ZipResult};

use crate::channels::{ARRIVAL, Channel, Scale, StylusKind};
use crate::csv_read::CsvOptions;
use crate::error::{CsvError, excerpt};
use crate::find::Signal;
use crate::npz::{npz_table, write_array};
use crate::numbers::{Coding, NumberColumn, NumberRows, NumberTable};
use crate::pace::Pace;
use crate::plan::{Head, Plan, name_axes};
use crate::recording::{Cells, Gathering, Recording};
use crate::taxels::PREFIX;
use crate::time::TimeUnit;

const NONE: &Vec<String> = &Vec::new();

/// Reads the recording in an `.npz`.
pub(crate) fn read_npz(file: &Path, options: &CsvOptions) -> Result<Recording, CsvError> {
    NumberSamples::open(&npz_table(file)?, options)?.hold()
}

/// The samples of a table of numbers one after the other, as the file is read: the memory does not depend on its length.
#[derive(Debug)]
pub struct NumberSamples {
    file: PathBuf,
    plan: Plan,
    rows: NumberRows,
    gathering: Gathering,
    row: Vec<f64>,
    count: u64,
}

impl NumberSamples {
    /// Begins to read `table`.
    ///
    /// # Errors
    /// Where the file cannot be read, or its columns or an option is not usable.
    pub fn open(table: &NumberTable, options: &CsvOptions) -> Result<Self, CsvError> {
        Self::open_paced(table, options, None)
    }

    /// The same with the pace that [`survey`](Self::survey) has found in all of the file.
    ///
    /// # Errors
    /// As [`NumberSamples::open`].
    pub fn open_paced(
        table: &NumberTable,
        options: &CsvOptions,
        pace: Option<Pace>,
    ) -> Result<Self, CsvError> {
        let file = table.file.clone();
        let mut options = options.clone();
        options.rate_hz = options.rate_hz.or(table.rate_hz);
        let mut plan = plan(table, &mut options)?;
        plan.pace = pace.or(plan.pace);
        let mut gathering = Gathering::planned(&file, &plan, &options)?;
        let used = |at: usize| Some(at).filter(|at| gathering.layout.uses(*at));
        let picks: Vec<_> = (0..table.columns.len()).map(used).collect();
        let rows = table.rows(&picks);
        let rows = rows.map_err(|source| CsvError::Unreadable { file: file.clone(), source })?;
        let notes = &mut gathering.notes;
        notes.cut = table.cut.is_some();
        let found = core::mem::take(&mut plan.found.notes);
        notes.remarks.extend(found.into_iter().chain(table.notes.clone()).chain(table.cut.clone()));
        if plan.clock.is_empty() && table.rate_hz == options.rate_hz {
            plan.clock.clone_from(&table.clock);
        }
        Ok(Self { file, plan, rows, gathering, row: Vec::new(), count: 0 })
    }

    /// Where the times come from; empty where a rate that was given does.
    #[must_use]
    pub fn clock(&self) -> &str {
        &self.plan.clock
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
        let Self { file, plan, rows, gathering, row, count } = self;
        let unreadable = |source| CsvError::Unreadable { file: file.clone(), source };
        if !rows.next_row(row).map_err(unreadable)? {
            return Ok(None);
        }
        *count += 1;
        let stylus = gathering.layout.stylus;
        let header = &plan.names;
        let sample = gathering.sample(&ArrayRow { file, header, row, stylus, line: *count });
        if sample.is_err() {
            // Damaged bytes make odd numbers: that is then the fault.
            rows.drain().map_err(unreadable)?;
        }
        sample.map(Some)
    }

    /// The recording without its samples, and the pace to [open](NumberSamples::open_paced) it with again, where its first rows
    /// did not show that its stamps are coarse. Reads what is left of the file.
    ///
    /// # Errors
    /// Where a row is not usable, there is none, or no rate.
    pub fn survey(mut self) -> Result<(Recording, Option<Pace>), CsvError> {
        while self.next()?.is_some() {}
        let pace = self.gathering.unseen_pace();
        Ok((self.gathering.finish()?, pace))
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

/// What the columns are, and where the times come from.
fn plan(table: &NumberTable, options: &mut CsvOptions) -> Result<Plan, CsvError> {
    let signal = |column: &NumberColumn| Signal {
        name: column.name.clone(),
        unit: column.unit.map(str::to_owned).or_else(|| Some(grip_table::of_name(&column.name)?.1)),
        ..Signal::default()
    };
    let mut signals: Vec<Signal> = table.columns.iter().map(signal).collect();
    let rated = table.rate_hz.is_some();
    if rated && !table.named {
        name_axes(&mut signals, &[]);
    }
    let times = table.columns.iter().find(|column| column.is_time);
    if let Some(times) = times.filter(|_| !options.map.iter().any(|(ours, _)| ours == "t_s")) {
        options.map.push(("t_s".to_owned(), times.name.clone()));
    }
    let head = Head { signals, named: table.named || rated, nameless: Vec::new() };
    let (mut fault, mut coarse) = (None, None);
    let plan = Plan::find(&table.file, &head, options, |column| {
        let times = table.columns.get(column);
        coarse = times.filter(|times| (times.cell.coding, times.cell.size) == (Coding::Float, 2));
        let times = table.first(column).unwrap_or_else(|source| {
            fault = Some(source);
            Vec::new()
        });
        (times, Vec::new())
    });
    if let Some(source) = fault {
        return Err(CsvError::Unreadable { file: table.file.clone(), source });
    }
    match coarse.filter(|_| options.rate_hz.is_none()) {
        Some(NumberColumn { name, .. }) => Err(CsvError::Times {
            file: table.file.clone(),
            fault: format!(
                "the times in {name:?} are float16, which keeps 3 digits; give --rate HZ"
            ),
            found: table.columns.iter().map(|column| column.name.clone()).collect(),
        }),
        None => plan,
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
    fn stamp(&self, column: usize, unit: TimeUnit) -> Result<i64, CsvError> {
        let value = self.value(column);
        unit.to_ns(value).ok_or_else(|| CsvError::TimeOutOfRange {
            file: self.file.to_owned(),
            line: self.line,
            column: self.name(column),
            text: excerpt(&value.to_string()),
        })
    }

    fn place(&self, column: usize) -> (&Path, u64, String) {
        (self.file, self.line, self.name(column))
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
                line: self.line,
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

    /// Writes to `out` an `.npz` that [`read_recording`](crate::read_recording) reads back: `t_s` and the arrivals as float64, readings as float32.
    /// A NaN reading of another channel than the stylus comes back as none.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write_npz(&self, out: impl Write + Seek) -> ZipResult<()> {
        let mut npz = ZipWriter::new(out);
        write_array(&mut npz, "t_s", self.times_s().iter().map(|time| time.to_le_bytes()))?;
        let readings = self.readings();
        for (name, column) in self.columns().iter().zip(readings.columns()) {
            write_array(&mut npz, name, column.iter().map(|value| value.to_le_bytes()))?;
        }
        if self.channels.arrivals {
            for (name, age) in ARRIVAL.into_iter().zip([false, true]) {
                let column = self.samples.iter().map(|sample| {
                    let time = sample.arrival.map(|a| if age { a.age } else { a.at });
                    time.map_or(f64::NAN, |time| time.0 as f64).to_le_bytes()
                });
                write_array(&mut npz, name, column)?;
            }
        }
        Ok(npz.finish()?.flush()?)
    }

    fn taxel_count(&self) -> usize {
        self.taxels.as_ref().map_or(0, crate::Taxels::count)
    }
}
