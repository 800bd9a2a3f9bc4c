//! Import of numbers of a fixed size (WAV, NPY, NPZ): a recording and its samples as the file is read.

use crate::{ImportOptions, Imported, error::ImportError, has_ending, wav};
use grip_record::{
    CsvError, CsvOptions, NumberSamples, NumberTable, npy_table, npz_table, pace::Pace,
};
use std::path::Path;

/// The samples of a file, which can be read as often as they are wanted.
#[derive(Debug)]
pub struct ArrayRows {
    table: NumberTable,
    options: CsvOptions,
    pace: Option<Pace>,
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
        NumberSamples::open_paced(&self.table, &self.options, self.pace)
    }
}

/// Where the numbers of such a file lie; `None` for another one.
pub(crate) fn table(file: &Path) -> Result<Option<(&'static str, NumberTable)>, ImportError> {
    Ok(if has_ending(file, "wav") || has_ending(file, "w64") {
        Some(("WAV", wav::read(file)?))
    } else if has_ending(file, "npy") {
        let table = npy_table(file);
        let fault = |fault| ImportError::nothing(file, &format!("the array {fault}"));
        Some(("NPY", table.map_err(fault)?))
    } else if has_ending(file, "npz") {
        Some(("NPZ", npz_table(file).map_err(CsvError::from)?))
    } else {
        None
    })
}

/// The recording; its samples are held, or read once or twice to see what they are.
pub(crate) fn import(
    format: &'static str,
    mut table: NumberTable,
    options: &ImportOptions,
    hold: bool,
) -> Result<Imported, ImportError> {
    let options = options.csv();
    if table.rate_hz.is_some_and(|rate_hz| rate_hz <= 0.0) && options.rate_hz.is_none() {
        let what = format!("{}; give --rate HZ", table.clock);
        return Err(ImportError::nothing(&table.file, &what));
    }
    if let Some((ours, theirs)) = options.rate_hz.zip(table.rate_hz)
        && theirs > 0.0
        && (ours - theirs).abs() > f32::EPSILON * theirs
    {
        table.notes.push(format!(
            "taken at {ours} Hz as --rate states, not at the {theirs} Hz of its header"
        ));
    }
    let samples = NumberSamples::open(&table, &options)?;
    let clock = samples.clock().to_owned();
    if hold {
        return Ok(Imported::of(format, clock, samples.hold()?));
    }
    let (mut recording, pace) = samples.survey()?;
    let rows = ArrayRows { table, options, pace };
    if pace.is_some() {
        (recording, _) = rows.samples()?.survey()?;
    }
    Ok(Imported { rows: Some(rows), ..Imported::of(format, clock, recording) })
}
