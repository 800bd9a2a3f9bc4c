//! Distance moved at any time, from `NAME_pose.csv` beside a recording.

use std::path::{Path, PathBuf};

use slip_core::units::Micros;

use crate::csv_read::{read_bytes, read_optional, time};
use crate::error::CsvError;
use grip_table::Table;

/// The true motion beside a recording: columns `t_s` and `travel_mm` at their own, possibly irregular rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Travel {
    /// Times, never decreasing, and distances moved (mm), finite; at least one.
    points: Vec<(Micros, f64)>,
}

impl Travel {
    /// The companion of the recording `NAME.csv`: `NAME_pose.csv` in the same folder.
    #[must_use]
    pub fn companion(recording: &Path) -> PathBuf {
        let stem = recording.file_stem().unwrap_or_default().to_string_lossy();
        recording.with_file_name(format!("{stem}_pose.csv"))
    }

    /// Reads the companion of `recording`, `None` if there is none.
    ///
    /// # Errors
    /// As [`Travel::read`], where the companion exists.
    pub fn read_beside(recording: &Path) -> Result<Option<Self>, CsvError> {
        let file = Self::companion(recording);
        read_optional(&file)?.map(|bytes| Self::parse(&file, &bytes)).transpose()
    }

    /// Reads the motion in `file`.
    ///
    /// # Errors
    /// Where the file cannot be read, a column is absent, a number is missing or not finite, or time goes
    /// backwards; see [`CsvError`].
    pub fn read(file: &Path) -> Result<Self, CsvError> {
        Self::parse(file, &read_bytes(file)?)
    }

    fn parse(file: &Path, bytes: &[u8]) -> Result<Self, CsvError> {
        let mut table = Table::open(file, bytes)?;
        let time_column = table.required("t_s")?;
        let (travel_column, travel_m) = table.quantity(&["travel"], "mm")?;
        let mut points: Vec<(Micros, f64)> = Vec::new();
        while let Some(row) = table.next_row()? {
            let at = time(&row, time_column, points.last().map(|point| point.0))?;
            points.push((at, row.finite(travel_column)? * travel_m / 1e-3));
        }
        if points.is_empty() {
            return Err(CsvError::NoRows { file: file.to_owned() });
        }
        Ok(Self { points })
    }

    /// The times and distances (mm) as they stand in the file.
    #[must_use]
    pub fn points(&self) -> &[(Micros, f64)] {
        &self.points
    }

    /// Distance moved at `time` (mm), linear between the two neighbours; `None` outside the times known.
    /// Of several points at the same time the last one holds.
    #[must_use]
    pub fn travel_at(&self, time: Micros) -> Option<f64> {
        let after = self.points.partition_point(|point| point.0 <= time);
        let &(t0, mm0) = self.points.get(after.checked_sub(1)?)?;
        if t0 == time {
            return Some(mm0);
        }
        let &(t1, mm1) = self.points.get(after)?;
        let fraction = time.since(t0).0 as f64 / t1.since(t0).0 as f64;
        Some(mm0 + fraction * (mm1 - mm0))
    }
}
