//! Columns of numbers in, a recording out: what readers of other formats give.

use std::path::Path;

use slip_core::units::Micros;

use crate::channels::Scale;
use crate::csv_read::CsvOptions;
use crate::error::CsvError;
use crate::recording::{Cells, Gathering, Recording};

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
        let first = usize::from(columns.times.is_some());
        let stylus = gathering.layout.stylus;
        for row in 0..columns.rows() {
            gathering.push(&ColumnRow { file, columns, first, stylus, row })?;
        }
        gathering.finish()
    }
}

struct ColumnRow<'a> {
    file: &'a Path,
    columns: &'a Columns,
    /// Place of the first column of readings.
    first: usize,
    stylus: Option<usize>,
    row: usize,
}

impl Cells for ColumnRow<'_> {
    fn time(&self, _column: usize, previous: Option<Micros>) -> Result<Micros, CsvError> {
        let times = self.columns.times.as_ref();
        let time = times.and_then(|times| times.get(self.row)).copied().unwrap_or_default();
        match previous.filter(|before| *before > time) {
            None => Ok(time),
            Some(before) => Err(CsvError::TimeBackwards {
                file: self.file.to_owned(),
                line: self.row as u64 + 1,
                column: "t_s".to_owned(),
                before,
                time,
            }),
        }
    }

    fn reading(&self, column: usize, scale: Scale) -> Result<Option<f32>, CsvError> {
        let values = column.checked_sub(self.first).and_then(|at| self.columns.values.get(at));
        let value = values.and_then(|values| values.get(self.row)).copied().unwrap_or(f32::NAN);
        let value = match scale {
            Scale::Same => value,
            Scale::MilliToUnit => value / 1000.0,
        };
        Ok(Some(value).filter(|value| Some(column) == self.stylus || !value.is_nan()))
    }

    fn micros(&self, _column: usize) -> Result<Option<Micros>, CsvError> {
        Ok(None)
    }
}
