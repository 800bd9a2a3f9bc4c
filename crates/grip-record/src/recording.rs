//! A recording, gathered from the cells of rows: what files of every kind share.

use std::path::{Path, PathBuf};

use slip_core::sample::{Arrival, Sample};
use slip_core::units::Micros;

use crate::channels::{ChannelSet, Scale};
use crate::clock::Clock;
use crate::csv_read::CsvOptions;
use crate::error::CsvError;
use crate::layout::Layout;
use crate::notes::{Notes, Steps};
use crate::pace::Pace;
use crate::plan::Plan;
use crate::taxels::Taxels;
use crate::time::TimeUnit;

/// Most bytes that the samples of one file may take, with their taxels: 17 million samples without, which is half an hour at 10 kHz.
pub const MOST_HELD: usize = 2 << 30;

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

impl Recording {
    /// Keeps its first `count` samples, with their taxels, alone, and gives the memory of the others back.
    pub fn truncate(&mut self, count: usize) {
        self.samples.truncate(count);
        self.samples.shrink_to_fit();
        if let Some(taxels) = &mut self.taxels {
            taxels.truncate(count);
        }
    }
}

/// The cells of one row, by the number of their column.
pub(crate) trait Cells {
    /// A stamp in `unit`, as ns.
    fn stamp(&self, column: usize, unit: TimeUnit) -> Result<i64, CsvError>;

    /// File, line and name of the column, for errors.
    fn place(&self, column: usize) -> (&Path, u64, String);

    /// A reading, `None` for an empty cell.
    fn reading(&self, column: usize, scale: Scale) -> Result<Option<f32>, CsvError>;

    /// Whole microseconds, `None` for an empty cell.
    fn micros(&self, column: usize) -> Result<Option<Micros>, CsvError>;
}

/// A recording on its way.
#[derive(Debug)]
pub(crate) struct Gathering {
    file: PathBuf,
    pub(crate) layout: Layout,
    pub(crate) notes: Notes,
    steps: Steps,
    unit: TimeUnit,
    clock: Option<Clock>,
    /// Samples so far.
    count: usize,
    /// The frame of the last sample.
    frame: Vec<f32>,
    samples: Vec<Sample>,
    taxels: Taxels,
}

impl Gathering {
    /// No rows yet, of a file with these columns.
    pub(crate) fn new(
        file: &Path,
        header: &[String],
        options: &CsvOptions,
    ) -> Result<Self, CsvError> {
        let ours = header.to_vec();
        let plan = Plan { names: header.to_vec(), ours, ..Plan::default() };
        Self::planned(file, &plan, options)
    }

    /// The same, of a file whose columns have names of their own.
    pub(crate) fn planned(
        file: &Path,
        plan: &Plan,
        options: &CsvOptions,
    ) -> Result<Self, CsvError> {
        let given_rate_hz = options.rate_hz.map(checked_rate).transpose()?;
        let layout = Layout::resolve(file, plan, given_rate_hz.is_some())?;
        let ignored = layout.ignored.iter().filter(|name| !name.is_empty());
        let ignored_columns = ignored.cloned().collect();
        let uses = plan.found.uses.clone();
        let notes = Notes { given_rate_hz, ignored_columns, uses, ..Notes::default() };
        let taxels = Taxels::new(layout.taxels.len());
        let unit = plan.unit.unwrap_or(TimeUnit::Seconds);
        let own = layout.channels.time_source.as_deref() == Some("t_s");
        Ok(Self {
            file: file.to_owned(),
            clock: layout.time.map(|_| Clock::new(unit, own, plan.pace)),
            layout,
            notes,
            steps: Steps::default(),
            unit,
            count: 0,
            frame: Vec::new(),
            samples: Vec::new(),
            taxels,
        })
    }

    /// What is known before the first row.
    pub(crate) fn about(&self, plan: &Plan) -> Result<Recording, CsvError> {
        let mut notes = self.notes.clone();
        let pace = plan.pace.filter(|_| self.layout.time.is_some());
        let rate_hz = notes.given_rate_hz.or(pace.map(|pace| pace.rate_hz()));
        let file = || self.file.clone();
        let rate_hz = rate_hz.ok_or_else(|| match plan.timed {
            0 => CsvError::NoRows { file: file() },
            rows => CsvError::NoRate { file: file(), rows },
        })?;
        let said = pace.map(|pace| pace.to_string()).filter(|text| !text.is_empty());
        notes.remarks.extend(plan.found.notes.iter().cloned().chain(said));
        let name = self.file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let channels = self.layout.channels.clone();
        Ok(Recording { name, channels, samples: Vec::new(), taxels: None, rate_hz, notes })
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The sample of the next row; its frame is [`Gathering::frame`].
    pub(crate) fn sample(&mut self, row: &impl Cells) -> Result<Sample, CsvError> {
        let time = match self.layout.time.zip(self.clock.as_mut()) {
            Some((column, clock)) => {
                let stamp = row.stamp(column, self.unit)?;
                clock.time(stamp).map_err(|before| {
                    let (file, line, column) = row.place(column);
                    let [before, time] = [before, stamp].map(|ns| ns as f64 / 1e9);
                    CsvError::TimeBackwards { file: file.to_owned(), line, column, before, time }
                })?
            }
            None => nth_time(self.count, self.notes.given_rate_hz),
        };
        let sample = sample_of(row, &self.layout, time, &mut self.notes)?;
        frame_of(row, &self.layout, &mut self.notes, &mut self.frame)?;
        self.note(time);
        Ok(sample)
    }

    /// The sample of a row of one column that is reported later, its time then.
    pub(crate) fn uncounted(&mut self, row: &impl Cells) -> Result<Sample, CsvError> {
        sample_of(row, &self.layout, Micros(0), &mut self.notes)
    }

    /// In a file of one column an empty stylus cell is a blank line; without it all later times would shift.
    pub(crate) fn without_stylus(&mut self) -> Sample {
        self.notes.empty_stylus += 1;
        self.timed(Sample::stylus(Micros(0), f32::NAN))
    }

    /// The sample at the time of the next row, where a rate gives it.
    pub(crate) fn timed(&mut self, sample: Sample) -> Sample {
        let t = nth_time(self.count, self.notes.given_rate_hz);
        self.frame.clear();
        self.note(t);
        Sample { t, ..sample }
    }

    fn note(&mut self, time: Micros) {
        self.count += 1;
        if self.layout.time.is_some() {
            self.steps.push(time);
        }
    }

    /// The frame of the last sample; empty where none came with it.
    pub(crate) fn frame(&self) -> &[f32] {
        &self.frame
    }

    /// Puts a sample and the last frame by.
    pub(crate) fn keep(&mut self, sample: Sample) -> Result<(), CsvError> {
        self.check_room(self.samples.len() as u64 + 1)?;
        self.samples.push(sample);
        self.taxels.push(&self.frame);
        Ok(())
    }

    /// Whether so many samples may be held.
    pub(crate) fn check_room(&self, rows: u64) -> Result<(), CsvError> {
        let most = MOST_HELD / (size_of::<Sample>() + 4 * self.layout.taxels.len());
        if rows <= most as u64 {
            return Ok(());
        }
        Err(CsvError::TooManyRows { file: self.file.clone(), most })
    }

    pub(crate) fn push(&mut self, row: &impl Cells) -> Result<(), CsvError> {
        let sample = self.sample(row)?;
        self.keep(sample)
    }

    /// The pace of the stamps so far.
    pub(crate) fn pace(&self) -> Option<Pace> {
        let pace = self.clock.as_ref()?.pace()?;
        Some(self.notes.given_rate_hz.map_or(pace, |rate_hz| pace.with_rate(rate_hz)))
    }

    /// The same, where rows are not placed by it and have to be.
    pub(crate) fn unseen_pace(&self) -> Option<Pace> {
        let places = self.clock.as_ref().is_some_and(Clock::places);
        self.pace().filter(|pace| pace.coarse && !places)
    }

    /// The recording, with what was kept of its samples.
    pub(crate) fn finish(mut self) -> Result<Recording, CsvError> {
        if self.count == 0 {
            return Err(CsvError::NoRows { file: self.file });
        }
        let pace = self.pace().filter(|pace| pace.coarse);
        if let Some((pace, clock)) = pace.zip(self.clock.as_ref()) {
            if !clock.places() && !self.samples.is_empty() {
                // Coarse only behind the rows that were looked at before.
                self.steps = Steps::default();
                let mut clock = Clock::new(TimeUnit::Nanos, true, Some(pace));
                for sample in &mut self.samples {
                    let stamp = i64::try_from(sample.t.0).unwrap_or(i64::MAX).saturating_mul(1000);
                    sample.t = clock.time(stamp).unwrap_or(sample.t);
                    self.steps.push(sample.t);
                }
            }
            self.notes.remarks.push(pace.to_string());
        }
        self.notes.remarks.extend(self.clock.iter().flat_map(Clock::notes));
        self.notes.take_steps(&self.steps);
        let Self { file, layout, mut notes, samples, taxels, .. } = self;
        notes.measured_rate_hz = pace.map(|pace| pace.rate_hz()).or(notes.measured_rate_hz);
        let rate_hz = notes
            .given_rate_hz
            .or(notes.measured_rate_hz)
            .ok_or_else(|| CsvError::NoRate { file: file.clone(), rows: self.count })?;
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let taxels = Some(taxels).filter(|taxels| taxels.count() > 0);
        Ok(Recording { name, channels: layout.channels, samples, taxels, rate_hz, notes })
    }
}

fn checked_rate(rate_hz: f32) -> Result<f32, CsvError> {
    if (0.001..=1e6).contains(&rate_hz) { Ok(rate_hz) } else { Err(CsvError::BadRate { rate_hz }) }
}

/// Time of row `index` at `rate` samples per second; [`Layout`] has made sure that there is one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rounded, not negative, saturating"
)]
pub(crate) fn nth_time(index: usize, rate: Option<f32>) -> Micros {
    let period_us = rate.map_or(0.0, |rate| 1e6 / f64::from(rate));
    Micros((index as f64 * period_us).round() as u64)
}

fn sample_of(
    row: &impl Cells,
    layout: &Layout,
    time: Micros,
    notes: &mut Notes,
) -> Result<Sample, CsvError> {
    let stylus =
        match layout.stylus.map(|column| row.reading(column, layout.scale(column))).transpose()? {
            Some(Some(stylus)) => {
                notes.count_reading(stylus);
                stylus
            }
            Some(None) => {
                notes.empty_stylus += 1;
                f32::NAN
            }
            None => 0.0,
        };
    let mut sample = Sample::stylus(time, stylus);
    for &(column, channel, scale) in &layout.optional {
        let value = row.reading(column, scale)?;
        if let Some(value) = value {
            notes.count_reading(value);
        }
        channel.set(&mut sample, value);
    }
    for (axis, &column) in sample.stylus_axes.iter_mut().zip(&layout.axes) {
        *axis = axis_of(row, layout, column, notes)?.unwrap_or(f32::NAN);
    }
    for (axis, &column) in sample.reference_axes.iter_mut().zip(&layout.reference_axes) {
        match axis_of(row, layout, column, notes)? {
            Some(value) => *axis = value,
            // A vector without one of its components is none.
            None => sample.reference = None,
        }
    }
    if sample.reference.is_none() {
        sample.reference_axes = Default::default();
    }
    if layout.stylus.is_some() {
        let axes = notes.ends.iter_mut().zip(sample.vibration());
        axes.filter(|(_, value)| value.is_finite()).for_each(|(end, value)| end.push(value));
    }
    sample.arrival = arrival(row, layout)?;
    Ok(sample)
}

/// A component of a vector, `None` for an empty cell.
fn axis_of(
    row: &impl Cells,
    layout: &Layout,
    column: usize,
    notes: &mut Notes,
) -> Result<Option<f32>, CsvError> {
    let value = row.reading(column, layout.scale(column))?;
    if let Some(value) = value {
        notes.count_reading(value);
    }
    Ok(value)
}

/// When the computer took the row in; `None` where a cell is empty.
fn arrival(row: &impl Cells, layout: &Layout) -> Result<Option<Arrival>, CsvError> {
    let Some([at, age]) = layout.arrival else { return Ok(None) };
    Ok(row.micros(at)?.zip(row.micros(age)?).map(|(at, age)| Arrival { at, age }))
}

/// The frame in a row; empty where every cell is.
fn frame_of(
    row: &impl Cells,
    layout: &Layout,
    notes: &mut Notes,
    frame: &mut Vec<f32>,
) -> Result<(), CsvError> {
    frame.clear();
    let mut any = false;
    for &column in &layout.taxels {
        let value = row.reading(column, layout.scale(column))?;
        any |= value.is_some();
        if let Some(value) = value {
            notes.count_reading(value);
        }
        frame.push(value.unwrap_or(f32::NAN));
    }
    if !any {
        frame.clear();
    }
    Ok(())
}
