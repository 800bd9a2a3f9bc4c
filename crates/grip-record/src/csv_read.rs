//! Reader of a table: its samples, and what is odd about them.

use std::borrow::Cow;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

use grip_table::{Loss, Row, Table};
use slip_core::sample::Sample;
use slip_core::units::Micros;

use crate::channels::{COLUMN_NAMES, Scale};
use crate::error::{CsvError, excerpt};
use crate::files;
use crate::pace::Pace;
use crate::plan::Plan;
use crate::recording::{Cells, Gathering, Recording};
use crate::time::{TimeFault, TimeUnit, parse_stamp};

/// What the file itself does not show.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CsvOptions {
    /// Samples per second, 0.001 to 1e6 Hz. Needed without a column of times (t = i / rate); beside one it is the rate reported,
    /// and rows whose stamps are coarser than their steps are placed by it; regular stamps stay.
    pub rate_hz: Option<f32>,
    /// Renamings: (known name, the file's column); see [`COLUMN_NAMES`](crate::COLUMN_NAMES).
    pub map: Vec<(String, String)>,
    /// Unit of the times, where name and numbers leave it open.
    pub time_unit: Option<TimeUnit>,
    /// Finger of a TSF-85 recording, by the number in its columns; the first one otherwise.
    pub finger: Option<u32>,
}

/// Reads the recording in `file`, line by line: only its samples are held, at most [`MOST_HELD`](crate::MOST_HELD) bytes.
///
/// # Errors
/// Where the file cannot be read, or its header, a row or an option is not usable; see [`CsvError`].
pub fn read_csv(file: &Path, options: &CsvOptions) -> Result<Recording, CsvError> {
    CsvSamples::open(file, options)?.hold()
}

/// Reads the recording in `file`: an `.npz` by its name (with the feature `arrays`), any other as CSV.
///
/// # Errors
/// Where the file cannot be read, or its columns, a row or an option is not usable; see [`CsvError`].
pub fn read_recording(file: &Path, options: &CsvOptions) -> Result<Recording, CsvError> {
    #[cfg(feature = "arrays")]
    if crate::npz::is_npz(file) {
        return crate::arrays::read_npz(file, options);
    }
    read_csv(file, options)
}

/// The recording whose bytes are `bytes`; `file` gives its name and stands in errors.
///
/// # Errors
/// Where the header, a row or an option is not usable; see [`CsvError`].
pub fn parse_csv(file: &Path, bytes: &[u8], options: &CsvOptions) -> Result<Recording, CsvError> {
    CsvSamples::of(file, || Ok(bytes), options, None)?.hold()
}

/// The samples of a table one after the other, as the file is read: the memory does not depend on its length.
///
/// Its first rows are read twice: what its times are and how evenly they come is found before the first sample.
#[derive(Debug)]
pub struct CsvSamples<R> {
    table: Table<R>,
    gathering: Gathering,
    plan: Plan,
    one_column: bool,
    /// Rows at the start that are none.
    skip: usize,
    /// Blank lines that stand for samples, and the sample behind them.
    blank: usize,
    behind: Option<Sample>,
}

impl CsvSamples<File> {
    /// Opens `file`.
    ///
    /// # Errors
    /// Where it cannot be read, or its header or an option is not usable.
    pub fn open(file: &Path, options: &CsvOptions) -> Result<Self, CsvError> {
        Self::open_paced(file, options, None)
    }

    /// The same with the pace that [`survey`](Self::survey) has found in all of the file.
    ///
    /// # Errors
    /// As [`CsvSamples::open`].
    pub fn open_paced(
        file: &Path,
        options: &CsvOptions,
        pace: Option<Pace>,
    ) -> Result<Self, CsvError> {
        Self::of(file, || files::open(file), options, pace)
    }

    /// What all of `file` shows: [`survey_of`](Self::survey_of) of its bytes.
    ///
    /// # Errors
    /// Those of [`CsvSamples::open`] and [`CsvSamples::survey`].
    pub fn surveyed(
        file: &Path,
        options: &CsvOptions,
    ) -> Result<(Recording, usize, Option<Pace>), CsvError> {
        Self::survey_of(file, || files::open(file), options)
    }
}

impl<R: Read> CsvSamples<R> {
    /// The samples of a table whose bytes `input` gives from their start, each time it is called, with the pace that is known.
    ///
    /// # Errors
    /// As [`CsvSamples::open`].
    pub fn of(
        file: &Path,
        input: impl Fn() -> std::io::Result<R>,
        options: &CsvOptions,
        pace: Option<Pace>,
    ) -> Result<Self, CsvError> {
        let input =
            || input().map_err(|source| CsvError::Unreadable { file: file.to_owned(), source });
        let mut plan = Plan::of(file, Table::open(file, input()?)?, options)?;
        plan.pace = pace.or(plan.pace);
        let table = Table::open(file, input()?)?;
        let is_mapped = |name: &str| options.map.iter().any(|(_, theirs)| theirs == name);
        table.check_repeated(|name| COLUMN_NAMES.contains(&name) || is_mapped(name))?;
        let one_column = table.header().len() == 1;
        let mut gathering = Gathering::planned(file, &plan, options)?;
        let last = table.columns().last();
        gathering.notes.trailing_comma = last.is_some_and(|column| column.given.is_empty())
            && matches!(table.header_line(), grip_table::Header::Line(_));
        let skip = plan.skip;
        Ok(Self { table, gathering, plan, one_column, skip, blank: 0, behind: None })
    }

    /// What all of a table shows, as every program reads one of any length before its samples: the recording without them, how many
    /// there are, and the pace to read it with. It is read once, or twice where its first rows do not show how coarse its stamps are.
    ///
    /// # Errors
    /// Those of [`CsvSamples::of`] and [`CsvSamples::survey`].
    pub fn survey_of(
        file: &Path,
        input: impl Fn() -> std::io::Result<R>,
        options: &CsvOptions,
    ) -> Result<(Recording, usize, Option<Pace>), CsvError> {
        let mut first = Self::of(file, &input, options, None)?;
        let mut count = 0;
        while first.next()?.is_some() {
            count += 1;
        }
        let (mut recording, pace) = first.survey()?;
        if pace.is_some() {
            (recording, _) = Self::of(file, &input, options, pace)?.survey()?;
        }
        Ok((recording, count, pace))
    }

    /// What kind of table it is, and where its times come from; the latter is empty where a rate gives them.
    #[must_use]
    pub fn kind(&self) -> (&'static str, &str) {
        (self.plan.format, &self.plan.clock)
    }

    /// What is known before the first sample: channels, rate, and what the columns are.
    ///
    /// # Errors
    /// Where no rate is given and the first rows show none.
    pub fn about(&self) -> Result<Recording, CsvError> {
        self.gathering.about(&self.plan)
    }

    /// What was left out so far.
    #[must_use]
    pub fn losses(&self) -> &[Loss] {
        self.table.losses()
    }

    /// The next sample and the frame of taxels that came with it, which is empty where none did; `None` at the end.
    ///
    /// # Errors
    /// Where a row is not usable.
    pub fn next_sample(&mut self) -> Result<Option<(Sample, &[f32])>, CsvError> {
        let sample = self.next()?;
        Ok(sample.map(|sample| (sample, self.gathering.frame())))
    }

    fn next(&mut self) -> Result<Option<Sample>, CsvError> {
        while self.skip > 0 && self.table.next_row()?.is_some() {
            self.skip -= 1;
        }
        if self.blank > 0 {
            self.blank -= 1;
            return Ok(Some(self.gathering.without_stylus()));
        }
        if let Some(sample) = self.behind.take() {
            return Ok(Some(self.gathering.timed(sample)));
        }
        let Some(row) = self.table.next_row()? else { return Ok(None) };
        if !self.one_column || self.gathering.is_empty() || row.blank_before == 0 {
            self.gathering.notes.blank_lines += row.blank_before;
            return self.gathering.sample(&row).map(Some);
        }
        self.blank = row.blank_before;
        self.behind = Some(self.gathering.uncounted(&row)?);
        self.next()
    }

    /// The recording without its samples: channels, rate and what is odd about it; and the pace to [open](CsvSamples::open_paced)
    /// it with again, where its first rows did not show that its stamps are coarse. Reads what is left of the file.
    ///
    /// # Errors
    /// Where a row is not usable, there is none, or no rate.
    pub fn survey(mut self) -> Result<(Recording, Option<Pace>), CsvError> {
        while self.next()?.is_some() {}
        let pace = self.gathering.unseen_pace();
        Ok((self.finish()?, pace))
    }

    /// The recording with all of its samples.
    ///
    /// # Errors
    /// Where a row is not usable, there is none, no rate, or more samples than are held.
    pub fn hold(mut self) -> Result<Recording, CsvError> {
        while let Some(sample) = self.next()? {
            self.gathering.keep(sample)?;
        }
        self.finish()
    }

    fn finish(mut self) -> Result<Recording, CsvError> {
        let losses = self.table.losses();
        self.gathering.notes.cut = losses.iter().any(Loss::is_data);
        let losses = losses.iter().map(Loss::to_string);
        self.gathering.notes.remarks.extend(self.plan.found.notes.into_iter().chain(losses));
        self.gathering.finish()
    }
}

pub(crate) fn read_bytes(file: &Path) -> Result<Vec<u8>, CsvError> {
    files::read(file, files::MOST_TABLE)
        .map_err(|source| CsvError::Unreadable { file: file.to_owned(), source })
}

/// The bytes of a file that may be absent.
pub(crate) fn read_optional(file: &Path) -> Result<Option<Vec<u8>>, CsvError> {
    match read_bytes(file) {
        Err(CsvError::Unreadable { source, .. }) if source.kind() == ErrorKind::NotFound => {
            Ok(None)
        }
        bytes => bytes.map(Some),
    }
}

/// The cell at `column` as a time (s), from 0 on, that is not before `previous`.
pub(crate) fn time(
    row: &Row<'_>,
    column: usize,
    previous: Option<Micros>,
) -> Result<Micros, CsvError> {
    let stamp = Cells::stamp(row, column, TimeUnit::Seconds)?;
    let (file, line, name) = (row.file().to_owned(), row.line, row.name(column));
    // Halves are rounded up.
    let time = u64::try_from((stamp + 500).div_euclid(1000)).map(Micros);
    let Ok(time) = time else {
        let text = excerpt(&row.cell(column));
        return Err(CsvError::TimeOutOfRange { file, line, column: name, text });
    };
    match previous.filter(|before| *before > time) {
        None => Ok(time),
        Some(before) => {
            let (before, time) = (before.as_seconds(), time.as_seconds());
            Err(CsvError::TimeBackwards { file, line, column: name, before, time })
        }
    }
}

const READING: &str = "write digits with a decimal point, NaN for a bad reading";

impl Cells for Row<'_> {
    fn stamp(&self, column: usize, unit: TimeUnit) -> Result<i64, CsvError> {
        let text = self.digits(column);
        parse_stamp(&text, unit).map_err(|fault| match fault {
            TimeFault::NotANumber => {
                self.not_a_number(column, "write digits with a decimal point").into()
            }
            TimeFault::OutOfRange => CsvError::TimeOutOfRange {
                file: self.file().to_owned(),
                line: self.line,
                column: self.name(column),
                text: excerpt(&text),
            },
        })
    }

    fn place(&self, column: usize) -> (&Path, u64, String) {
        (self.file(), self.line, self.name(column))
    }

    fn reading(&self, column: usize, scale: Scale) -> Result<Option<f32>, CsvError> {
        let text: Cow<'_, str> = self.digits(column);
        if text.is_empty() {
            return Ok(None);
        }
        if let Some(reading) = scale.parse(&text) {
            return Ok(Some(reading));
        }
        // A spelling of a value that is missing.
        let value = self.value(column).map_err(|_| self.not_a_number(column, READING))?;
        Ok(value.map(|value| scale.narrow(value)))
    }

    fn micros(&self, column: usize) -> Result<Option<Micros>, CsvError> {
        let text = self.cell(column);
        if text.is_empty() {
            return Ok(None);
        }
        let wrong = |_| self.not_a_number(column, "write whole microseconds");
        Ok(text.parse().map(|us| Some(Micros(us))).map_err(wrong)?)
    }
}
