//! Recording from columns of numbers, as readers of other formats give them; or from rows of them, a sample each.

use std::path::{Path, PathBuf};

use slip_core::sample::Sample;
use slip_core::units::Micros;

use crate::channels::Scale;
use crate::csv_read::CsvOptions;
use crate::error::CsvError;
use crate::recording::{Cells, Gathering, Recording, nth_time};
use crate::time::TimeUnit;

/// Numbers under the names of a recording's columns, each as long as the times.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    /// Device times, never decreasing; none where a rate gives them.
    pub times: Option<Vec<Micros>>,
    /// Names as in a CSV recording, in order.
    pub names: Vec<String>,
    /// Readings, NaN where there is none.
    pub values: Vec<Vec<f32>>,
}

impl Columns {
    fn rows(&self) -> usize {
        let longest = self.values.iter().map(Vec::len).max().unwrap_or(0);
        self.times.as_ref().map_or(longest, Vec::len)
    }
}

impl Recording {
    /// The recording that these columns are; `file` gives its name and stands in errors.
    ///
    /// # Errors
    /// As [`read_csv`](crate::read_csv), for columns that are none of a recording.
    pub fn of_columns(
        file: &Path,
        columns: &Columns,
        options: &CsvOptions,
    ) -> Result<Self, CsvError> {
        let time = columns.times.as_ref().map(|_| "t_s".to_owned());
        let header: Vec<String> = time.into_iter().chain(columns.names.iter().cloned()).collect();
        let mut gathering = Gathering::new(file, &header, options)?;
        let stylus = gathering.layout.stylus;
        let at = |values: &Vec<f32>, row: usize| values.get(row).copied().unwrap_or(f32::NAN);
        for line in 0..columns.rows() {
            let time = columns.times.as_ref().and_then(|times| times.get(line)).copied();
            let row: Vec<f32> = columns.values.iter().map(|values| at(values, line)).collect();
            let first = usize::from(columns.times.is_some());
            gathering.push(&NumberRow { file, line, time, first, stylus, row: &row })?;
        }
        gathering.finish()
    }
}

/// A row of numbers, and its time where it has one.
struct NumberRow<'a> {
    file: &'a Path,
    line: usize,
    time: Option<Micros>,
    /// Place of the first column of readings.
    first: usize,
    stylus: Option<usize>,
    row: &'a [f32],
}

impl Cells for NumberRow<'_> {
    fn stamp(&self, _column: usize, _unit: TimeUnit) -> Result<i64, CsvError> {
        let time = self.time.unwrap_or_default();
        Ok(i64::try_from(time.0).unwrap_or(i64::MAX).saturating_mul(1000))
    }

    fn place(&self, _column: usize) -> (&Path, u64, String) {
        (self.file, self.line as u64 + 1, "t_s".to_owned())
    }

    fn reading(&self, column: usize, scale: Scale) -> Result<Option<f32>, CsvError> {
        let value = column.checked_sub(self.first).and_then(|at| self.row.get(at)).copied();
        Ok(reading(value.unwrap_or(f32::NAN), scale, Some(column) == self.stylus))
    }

    fn micros(&self, _column: usize) -> Result<Option<Micros>, CsvError> {
        Ok(None)
    }
}

/// A number as a reading; only a stylus has a reading that is NaN.
fn reading(value: f32, scale: Scale, stylus: bool) -> Option<f32> {
    let value = match scale {
        Scale::MilliToUnit => value / 1000.0,
        Scale::Same | Scale::By(_) => value,
    };
    Some(value).filter(|value| stylus || !value.is_nan())
}

/// Rows of numbers, one after the other: what a live source gives. Only what was [kept](Rows::keep) is held.
#[derive(Debug)]
pub struct Rows {
    file: PathBuf,
    /// Of the rows that are kept.
    gathering: Gathering,
    /// Rows so far, and the last one.
    count: usize,
    sample: Sample,
    frame: Vec<f32>,
}

impl Rows {
    /// Rows with readings of these names, as in a CSV recording, at `rate_hz`. `source` stands in errors.
    ///
    /// # Errors
    /// As [`read_csv`](crate::read_csv), for columns that are none of a recording.
    pub fn new(source: &str, names: &[String], rate_hz: f32) -> Result<Self, CsvError> {
        let file = PathBuf::from(source);
        let options = CsvOptions { rate_hz: Some(rate_hz), ..CsvOptions::default() };
        let gathering = Gathering::new(&file, names, &options)?;
        let frame = Vec::with_capacity(gathering.layout.taxels.len());
        Ok(Self { file, gathering, count: 0, sample: Sample::default(), frame })
    }

    /// A recording of such rows, without samples.
    #[must_use]
    pub fn about(&self) -> Recording {
        let notes = self.gathering.notes.clone();
        Recording {
            name: self.file.display().to_string(),
            channels: self.gathering.layout.channels.clone(),
            samples: Vec::new(),
            taxels: None,
            rate_hz: notes.given_rate_hz.unwrap_or_default(),
            notes,
        }
    }

    /// The sample of the next row, at `t` or as the rate gives it, and the frame of taxels that came with it. Costs a fraction of
    /// what a kept row costs, and gives the same sample.
    #[inline]
    pub fn sample(&mut self, t: Option<Micros>, row: &[f32]) -> (&Sample, &[f32]) {
        let Gathering { layout, notes, .. } = &self.gathering;
        let value = |column: usize| row.get(column).copied().unwrap_or(f32::NAN);
        let sample = &mut self.sample;
        sample.t = t.unwrap_or_else(|| nth_time(self.count, notes.given_rate_hz));
        self.count += 1;
        sample.stylus = layout.stylus.map_or(0.0, value);
        for &(column, channel, scale) in &layout.optional {
            channel.set(sample, reading(value(column), scale, false));
        }
        for (axis, &column) in sample.stylus_axes.iter_mut().zip(&layout.axes) {
            *axis = value(column);
        }
        for (axis, &column) in sample.reference_axes.iter_mut().zip(&layout.reference_axes) {
            *axis = value(column);
            // A vector without one of its components is none.
            sample.reference = sample.reference.filter(|_| !value(column).is_nan());
        }
        if sample.reference.is_none() {
            sample.reference_axes = Default::default();
        }
        self.frame.clear();
        if layout.taxels.iter().any(|column| !value(*column).is_nan()) {
            self.frame.extend(layout.taxels.iter().map(|column| value(*column)));
        }
        (&self.sample, &self.frame)
    }

    /// Takes the next row and keeps its sample for [`Rows::finish`].
    ///
    /// # Errors
    /// Where there are more samples than are held.
    pub fn keep(&mut self, t: Option<Micros>, row: &[f32]) -> Result<(), CsvError> {
        let Self { file, gathering, .. } = self;
        let (line, stylus) = (0, gathering.layout.stylus);
        let sample =
            gathering.sample(&NumberRow { file, line, time: None, first: 0, stylus, row })?;
        gathering.keep(Sample { t: t.unwrap_or(sample.t), ..sample })
    }

    /// The recording of the rows that were kept.
    ///
    /// # Errors
    /// Where there were none.
    pub fn finish(self) -> Result<Recording, CsvError> {
        self.gathering.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::{Columns, Rows};
    use crate::{CsvOptions, Recording};
    use slip_core::{sample::Sample, units::Micros};
    use std::path::Path;

    const NAMES: [&str; 12] = [
        "vibration_x",
        "vibration_y",
        "vibration_z",
        "reference_x",
        "reference_y",
        "travel_mm",
        "pressure_0",
        "pressure_1",
        "force_n",
        "tangential_n",
        "motion",
        "pressure",
    ];

    #[test]
    fn rows_are_the_same_samples_as_columns() {
        let names: Vec<String> = NAMES.map(str::to_owned).to_vec();
        // Every seventh cell is empty, so that each column has rows with and without a reading.
        let cell = |row: u16, column: u16| {
            let at = row * 12 + column;
            if at.is_multiple_of(7) { f32::NAN } else { f32::from(at) + 0.5 }
        };
        let values: Vec<Vec<f32>> =
            (0..12).map(|column| (0..50).map(|row| cell(row, column)).collect()).collect();
        let columns = Columns { times: None, names: names.clone(), values: values.clone() };
        let options = CsvOptions { rate_hz: Some(333.0), ..CsvOptions::default() };
        let whole = Recording::of_columns(Path::new("x"), &columns, &options).unwrap();
        let mut rows = Rows::new("x", &names, 333.0).unwrap();
        let mut kept = Rows::new("x", &names, 333.0).unwrap();
        assert_eq!(rows.about().channels, whole.channels);
        // As text, in which a NaN equals itself.
        let text = |sample: &Sample| format!("{sample:?}");
        for (at, expected) in whole.samples.iter().enumerate() {
            let row: Vec<f32> = values.iter().map(|column| column[at]).collect();
            kept.keep(None, &row).unwrap();
            let (sample, frame) = rows.sample(None, &row);
            assert_eq!(text(sample), text(expected));
            let taxels = whole.taxels.as_ref().unwrap().frame(at);
            assert_eq!(format!("{frame:?}"), format!("{taxels:?}"));
        }
        assert_eq!(rows.sample(Some(Micros(99_000)), &[1.0; 12]).0.t, Micros(99_000));
        let kept = kept.finish().unwrap();
        assert_eq!((kept.notes, kept.taxels), (whole.notes, whole.taxels));
        let all = |samples: &[Sample]| samples.iter().map(text).collect::<Vec<_>>();
        assert_eq!(all(&kept.samples), all(&whole.samples));
    }

    #[test]
    fn without_a_stylus_it_is_0() {
        let mut rows = Rows::new("x", &["travel_m".to_owned()], 1000.0).unwrap();
        assert_eq!(rows.sample(None, &[0.5]).0.travel_m, Some(0.5));
        assert_eq!(*rows.sample(None, &[f32::NAN]).0, Sample::stylus(Micros(1000), 0.0));
    }
}
