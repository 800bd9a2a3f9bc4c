//! A CSV file with `x_mm` and `height_um` in, a height profile at equal steps out.

use std::path::Path;

use crate::csv_read::read_bytes;
use crate::error::CsvError;
use grip_table::{Row, Table};

/// A height profile at equal steps.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightProfile {
    /// Heights (m), finite, at least [`HeightProfile::FEWEST`].
    pub heights_m: Vec<f64>,
    /// Distance between two heights along the surface (m), positive.
    pub step_m: f64,
}

/// How far a step may lie from the median of all (part of it): the last digit of `x_mm` is rounded.
const STEP_TOLERANCE: f64 = 0.1;

impl HeightProfile {
    /// Fewest heights of a profile.
    pub const FEWEST: usize = 3;

    /// Reads the profile in `file`: columns `x_mm`, rising by equal steps, and `height_um`; others are passed over.
    /// With `step_m` (m, positive) given, the steps are that long and `x_mm` is not looked at.
    ///
    /// # Errors
    /// Where the file cannot be read, a column is absent, a number is missing or not finite, there are fewer than three
    /// rows, or a step of `x_mm` differs from their median by more than a tenth; see [`CsvError`].
    pub fn read(file: &Path, step_m: Option<f64>) -> Result<Self, CsvError> {
        Self::parse(file, &read_bytes(file)?, step_m)
    }

    /// The profile whose bytes are `bytes`; `file` stands in errors.
    ///
    /// # Errors
    /// As [`HeightProfile::read`].
    pub fn parse(file: &Path, bytes: &[u8], step_m: Option<f64>) -> Result<Self, CsvError> {
        let mut table = Table::open(file, bytes)?;
        let x_column = match step_m {
            None => Some(table.quantity("x", "mm")?),
            Some(_) => None,
        };
        let (height_column, height_m) = table.quantity("height", "um")?;
        let (mut heights_m, mut places) = (Vec::new(), Places::default());
        while let Some(row) = table.next_row()? {
            heights_m.push(row.finite(height_column)? * height_m);
            if let Some((column, x_m)) = x_column {
                places.push(&row, row.finite(column)? * x_m / 1e-3);
            }
        }
        if heights_m.len() < Self::FEWEST {
            let (rows, needed) = (heights_m.len(), Self::FEWEST);
            return Err(CsvError::FewRows { file: file.to_owned(), rows, needed });
        }
        let step_m = match step_m {
            Some(step_m) => step_m,
            None => 1e-3 * places.mean_step_mm(file)?,
        };
        Ok(Self { heights_m, step_m })
    }
}

/// The values of `x_mm` with their lines.
#[derive(Default)]
struct Places(Vec<(u64, f64)>);

impl Places {
    fn push(&mut self, row: &Row<'_>, x_mm: f64) {
        self.0.push((row.line, x_mm));
    }

    /// The mean step, where none differs much from their median: a mean would blame every step for a gap.
    #[expect(clippy::cast_precision_loss, reason = "rows of a file are far below 2^53")]
    fn mean_step_mm(&self, file: &Path) -> Result<f64, CsvError> {
        let mut steps: Vec<f64> = self.0.windows(2).map(|pair| pair[1].1 - pair[0].1).collect();
        let middle = steps.len() / 2;
        let (_, &mut usual_mm, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
        for pair in self.0.windows(2) {
            let step_mm = pair[1].1 - pair[0].1;
            let equal = (step_mm / usual_mm - 1.0).abs() <= STEP_TOLERANCE;
            if step_mm <= 0.0 || !equal {
                let (file, line) = (file.to_owned(), pair[1].0);
                return Err(CsvError::UnequalStep { file, line, step_mm, usual_mm });
            }
        }
        Ok(steps.iter().sum::<f64>() / steps.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str, step_m: Option<f64>) -> Result<HeightProfile, String> {
        HeightProfile::parse(Path::new("p.csv"), text.as_bytes(), step_m).map_err(|e| e.to_string())
    }

    #[test]
    fn heights_and_step_are_in_metres() {
        let profile =
            parse("height_um,x_mm,note\n1,0,a\n-2,0.0004,b\n3.5,0.0008,\n", None).unwrap();
        assert_eq!(profile.heights_m, [1e-6, -2e-6, 3.5e-6]);
        assert!((profile.step_m - 4e-7).abs() < 1e-15);
        let given = parse("height_um\n1\n2\n3\n", Some(1e-6)).unwrap();
        assert_eq!((given.heights_m.len(), given.step_m), (3, 1e-6));
        for text in [
            "x_um;height_mm\n0;0,001\n0,4;-0,002\n0,8;0,0035\n",
            "X [mm]\tHeight [nm]\n0\t1000\n0.0004\t-2000\n0.0008\t3500\n",
            "# profilometer\nx,height\nmm,\u{b5}m\n0,1\n0.0004,-2\n0.0008,3.5\n",
        ] {
            let found = parse(text, None).unwrap();
            assert!((found.step_m - 4e-7).abs() < 1e-15, "{text}: {found:?}");
            let off = found.heights_m.iter().zip(&profile.heights_m).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-15, "{text}: {found:?}");
        }
        let rounded =
            parse("x_mm,height_um\n0,1\n0.000356,1\n0.000712,1\n0.001069,1\n", None).unwrap();
        assert!((rounded.step_m - 3.563e-7).abs() < 1e-10, "{rounded:?}");
    }

    #[test]
    fn what_is_wrong_is_reported_with_its_line() {
        for (text, words) in [
            ("x_mm\n0\n", "no column height_um"),
            ("height_um\n0\n", "no column x_mm"),
            (
                "x_mm,height\n0,1\n1,2\n",
                "column height has no unit; name it by its unit, for example height_um",
            ),
            (
                "x_mm,height [px]\n0,1\n1,2\n",
                "column height [px] is in \"px\", which is no known unit of a length",
            ),
            ("x_mm,height_ms\n0,1\n1,2\n", "column height_ms is in \"ms\""),
            ("x_mm,height_um\n0,1\n1,2\n", "2 rows"),
            ("x_mm,height_um\n0,1\n1,2\n1,3\n2,4\n", "line 4"),
            ("x_mm,height_um\n0,1\n1,2\n2,3\n9,4\n", "line 5"),
            ("x_mm,height_um\n3,1\n2,2\n1,3\n", "line 3"),
            ("x_mm,height_um\n0,1\n1,NaN\n2,3\n", "line 3, column height_um"),
            ("x_mm,height_um\n0,1\n1,\n2,3\n", "line 3, column height_um"),
            ("x_mm,height_um\n0,1\nx,2\n2,3\n", "line 3, column x_mm"),
        ] {
            let error = parse(text, None).unwrap_err();
            assert!(error.contains("p.csv") && error.contains(words), "{text:?}: {error}");
        }
    }
}
