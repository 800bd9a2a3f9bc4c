//! A table of numbers (WAV, NPY, NPZ) in, its channels out, and its samples as the file is read.

use crate::{
    ImportOptions, Imported,
    assign::{self, Found},
    csv_file::time_column,
    error::ImportError,
    stream::Stream,
    time::TimeUnit,
};
use grip_record::{Coding, CsvError, CsvOptions, NumberSamples, NumberTable, Pick};
use std::{io, path::Path};

/// Rows whose times show their unit.
const FIRST_ROWS: usize = 1 << 16;

/// A table, and what its format states of it.
pub(crate) struct Array {
    pub(crate) format: &'static str,
    pub(crate) table: NumberTable,
    /// Unit of every signal, where the format knows it.
    pub(crate) unit: Option<&'static str>,
    /// Samples per second, and where that stands.
    pub(crate) rate: Option<(f64, String)>,
}

/// The samples of a table, which can be read as often as they are wanted.
#[derive(Debug)]
pub struct ArrayRows {
    table: NumberTable,
    header: Vec<String>,
    picks: Vec<Pick>,
    options: CsvOptions,
}

impl ArrayRows {
    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        usize::try_from(self.table.rows).unwrap_or(usize::MAX)
    }

    /// Begins to read them.
    ///
    /// # Errors
    /// Where the file cannot be read.
    pub fn samples(&self) -> Result<NumberSamples, CsvError> {
        NumberSamples::open(&self.table, self.header.clone(), &self.picks, &self.options)
    }
}

impl Array {
    /// Finds the channels; the samples are held, or read once to see what they are.
    pub(crate) fn import(
        mut self,
        file: &Path,
        options: &ImportOptions,
        hold: bool,
    ) -> Result<Imported, ImportError> {
        let mut notes = core::mem::take(&mut self.table.notes);
        let names: Vec<String> =
            self.table.columns.iter().map(|column| column.name.clone()).collect();
        let time = if self.rate.is_some() { None } else { self.time_column(&names, options) };
        let ramp = self.ramp(file, time, options, &mut notes)?;
        let free = |at: &usize| Some(*at) != time && Some(*at) != ramp;
        let signals: Vec<usize> = (0..names.len()).filter(free).collect();
        if signals.is_empty() {
            return Err(ImportError::nothing(file, "it holds no numbers beside times"));
        }
        let mut stream = Stream::new("", signals.iter().map(|at| names[*at].clone()).collect());
        stream.units.fill(self.unit);
        if names.iter().enumerate().all(|(k, name)| is_numbered(name, k)) {
            stream = stream.without_names();
        }
        let (mut header, mut picks, mut clock) = (Vec::new(), Vec::new(), String::new());
        if let Some(time) = time {
            header.push("t_s".to_owned());
            picks.push(self.time(file, time, options, &mut clock, &mut notes)?);
        }
        let Found { taken, uses, unused, .. } = assign::find(file, &[stream], options)?;
        for (ours, ((_, signal), scale, _)) in taken {
            header.push(ours);
            picks.push(Pick { column: signals.get(signal).copied(), zero: 0.0, scale });
        }
        let mut rate_hz = options.rate_hz;
        if let Some((rate, place)) = self.rate.filter(|_| rate_hz.is_none()) {
            #[expect(clippy::cast_possible_truncation, reason = "a rate has 24 bits")]
            let rate = rate as f32;
            if rate <= 0.0 {
                return Err(ImportError::nothing(file, &format!("{place}; give --rate HZ")));
            }
            (rate_hz, clock) = (Some(rate), place);
        }
        if time.is_none() && rate_hz.is_none() {
            let what = "no column of times; give --rate HZ, or --map t_s=NAME";
            return Err(ImportError::nothing(file, what));
        }
        let options = CsvOptions { rate_hz, map: Vec::new() };
        let rows = ArrayRows { table: self.table, header, picks, options };
        let samples = rows.samples()?;
        let recording = if hold { samples.hold()? } else { samples.survey()? };
        let rows = Some(rows).filter(|_| !hold);
        Ok(Imported { format: self.format, clock, uses, unused, notes, recording, rows })
    }

    /// Its times: named by the caller, times by their type, or by their name.
    fn time_column(&self, names: &[String], options: &ImportOptions) -> Option<usize> {
        let given = options.rate_hz.is_some() || options.map.iter().any(|(ours, _)| ours == "t_s");
        let typed = self.table.columns.iter().position(|column| column.times_ns.is_some());
        typed.filter(|_| !given).or_else(|| time_column(names, options))
    }

    /// The first numbers of a column.
    fn first(&self, at: usize) -> io::Result<Vec<f64>> {
        let mut rows = self.table.rows(&[Pick::plain(at)])?;
        let (mut row, mut first) = (Vec::new(), Vec::new());
        while first.len() < FIRST_ROWS && rows.next_row(&mut row)? {
            first.extend(row.first());
        }
        Ok(first)
    }

    /// A first column without a name that only rises, beside others and with a rate given: no vibration does.
    fn ramp(
        &self,
        file: &Path,
        time: Option<usize>,
        options: &ImportOptions,
        notes: &mut Vec<String>,
    ) -> Result<Option<usize>, ImportError> {
        let [first, _, ..] = &self.table.columns[..] else { return Ok(None) };
        let asked = options.map.iter().any(|(_, theirs)| *theirs == first.name);
        if time.is_some() || asked || first.name != "column_0" {
            return Ok(None);
        }
        let numbers = self.first(0).map_err(ImportError::unreadable(file))?;
        if numbers.len() < 3 || !numbers.is_sorted_by(|one, next| one < next) {
            return Ok(None);
        }
        notes.push("column_0 only rises: times or a counter, not used beside --rate".to_owned());
        Ok(Some(0))
    }

    /// How the times are read, in seconds.
    fn time(
        &mut self,
        file: &Path,
        at: usize,
        options: &ImportOptions,
        clock: &mut String,
        notes: &mut Vec<String>,
    ) -> Result<Pick, ImportError> {
        let column = &self.table.columns[at];
        let name = column.name.clone();
        let fault =
            |fault: &str| ImportError::nothing(file, &format!("the times in {name} {fault}"));
        if (column.cell.coding, column.cell.size) == (Coding::Float, 2) {
            return Err(fault("are float16, which keeps 3 digits; give --rate HZ"));
        }
        let first = self.first(at).map_err(ImportError::unreadable(file))?;
        if name == "column_0" && !first.is_sorted() {
            let what = "column_0 never decreasing would be its times, but it does; give --rate HZ where there are none";
            return Err(ImportError::nothing(file, what));
        }
        let (ns, unit) = match column.times_ns {
            Some(ns) => (ns, "datetime64"),
            None => {
                let unit = options.time_unit.or_else(|| TimeUnit::of_name(&name));
                let unit = unit.map_or_else(|| TimeUnit::of_numbers(&first), Ok);
                let unit = unit.map_err(|what| fault(&what))?;
                (unit.ns(), unit.name())
            }
        };
        *clock = format!("{name} ({unit})");
        let first = first.first().copied().unwrap_or(0.0);
        #[expect(clippy::cast_possible_truncation, reason = "what has no room is refused before")]
        let zero = if (first * ns).abs() < 9.2e18 {
            assign::first_time((first * ns).round() as i64, notes)
        } else {
            return Err(fault("begin with no time"));
        };
        let mut pick = Pick { column: Some(at), zero: 0.0, scale: ns / 1e9 };
        if zero != 0 {
            let zeroed = self.table.count_from_first(at);
            pick.zero = zeroed.map_err(ImportError::unreadable(file))?;
        }
        Ok(pick)
    }
}

/// Whether a name is but the place of a column.
fn is_numbered(name: &str, k: usize) -> bool {
    name == format!("column_{k}") || name == format!("channel_{}", k + 1)
}
