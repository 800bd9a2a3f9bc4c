//! Height profile at equal steps, from a CSV file with `x_mm` and `height_um`.

use core::ops::Range;
use std::path::Path;

use crate::csv_read::read_bytes;
use crate::error::CsvError;
use grip_table::{Loss, Table};

/// A height profile at equal steps.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightProfile {
    /// Heights (m), finite, at least [`HeightProfile::FEWEST`].
    pub heights_m: Vec<f64>,
    /// Distance between two heights along the surface (m), positive.
    pub step_m: f64,
    /// Places in `heights_m` at which nothing was measured, in order: the heights there lie on a line between their neighbours.
    pub filled: Vec<Range<usize>>,
    /// What of the file was no row and is left out.
    pub left_out: Vec<Loss>,
}

/// Names of places and of heights: their own ones, and those of instruments.
const PLACES: [&str; 4] = ["x", "position", "distance", "length"];
const HEIGHTS: [&str; 5] = ["height", "z", "profile", "h\u{f6}he", "y"];
/// How far a step may lie from the median of all (part of it), or from a multiple of it.
const STEP_TOLERANCE: f64 = 0.1;
/// Places of a profile over its rows, at most.
const MOST_ABSENT: usize = 4;
/// Fewest steps of which rounding is believed.
const FEWEST_ROUNDED: usize = 20;
/// Steps over which the usual one is averaged where places are rounded.
const BASELINE: usize = 64;

impl HeightProfile {
    /// Fewest heights of a profile.
    pub const FEWEST: usize = 3;

    /// Heights (m) that were all measured, `step_m` (m) apart.
    #[must_use]
    pub fn new(heights_m: Vec<f64>, step_m: f64) -> Self {
        Self { heights_m, step_m, filled: Vec::new(), left_out: Vec::new() }
    }

    /// Reads the profile in `file`: columns `x_mm`, rising or falling by equal steps, and `height_um`, or the only ones with a name of
    /// instruments (`Position`, `Z`, ..) and a unit of length; others are passed over. A falling profile is turned round. Heights that are absent (an empty cell, NaN, a row left out) are
    /// [`filled`](HeightProfile::filled) within and dropped at the ends. Steps count as equal where `x_mm` is rounded to fewer digits than they
    /// have. With `step_m` (m, positive) given, the steps are that long and `x_mm` is not looked at.
    ///
    /// # Errors
    /// Where the file cannot be read, a column is absent, a cell is no number, there are fewer than three
    /// heights, or a step of `x_mm` is no multiple of their median within a tenth; see [`CsvError`].
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
            None => Some(table.quantity(&PLACES, "mm")?),
            Some(_) => None,
        };
        let (height_column, unit_m) = table.quantity(&HEIGHTS, "um")?;
        let mut points = Vec::new();
        while let Some(row) = table.next_row()? {
            let absent = |column| row.cell(column).is_empty();
            let height_m = match absent(height_column) {
                true => f64::NAN,
                false => unit_m * row.number(height_column)?,
            };
            let x_mm = match x_column {
                Some((column, _)) if height_m.is_nan() && absent(column) => continue,
                Some((column, unit_m)) => row.finite(column)? * unit_m / 1e-3,
                None => 0.0,
            };
            points.push(Point { line: row.line, x_mm, height_m });
        }
        if points.first().zip(points.last()).is_some_and(|(first, last)| last.x_mm < first.x_mm) {
            points.reverse();
        }
        let fewer = |rows| CsvError::FewRows { file: file.to_owned(), rows, needed: Self::FEWEST };
        let measured = points.iter().filter(|point| point.height_m.is_finite()).count();
        if measured < Self::FEWEST {
            return Err(fewer(measured));
        }
        let (step_m, places) = match step_m {
            Some(step_m) => (step_m, (0..points.len()).collect()),
            None => {
                let Steps { step_mm, places } =
                    Steps::of(&points).map_err(|unequal| unequal.in_file(file, &points))?;
                (1e-3 * step_mm, places)
            }
        };
        let profile = Self::laid_out(&points, &places, step_m).ok_or_else(|| fewer(measured))?;
        Ok(Self { left_out: table.losses().to_vec(), ..profile })
    }

    /// Each height at its place, what is absent between two of them on a line; `None` for fewer than three heights.
    fn laid_out(points: &[Point], places: &[usize], step_m: f64) -> Option<Self> {
        let mut measured =
            points.iter().zip(places).filter(|(point, _)| point.height_m.is_finite()).peekable();
        let start = *measured.peek()?.1;
        let mut profile = Self::new(Vec::new(), step_m);
        for (point, place) in measured {
            let (from, to) = (profile.heights_m.len(), place - start);
            if let Some(&before) = profile.heights_m.last().filter(|_| to > from) {
                let rise = (point.height_m - before) / count(to - from + 1);
                profile.heights_m.extend((1..=to - from).map(|k| before + rise * count(k)));
                profile.filled.push(from..to);
            }
            profile.heights_m.push(point.height_m);
        }
        (profile.heights_m.len() >= Self::FEWEST).then_some(profile)
    }
}

/// One row.
struct Point {
    line: u64,
    x_mm: f64,
    height_m: f64,
}

/// The step of a profile and the place of each row, in steps.
struct Steps {
    step_mm: f64,
    places: Vec<usize>,
}

/// A step that does not fit the others: the number of the row before it, and the usual step.
struct Unequal {
    row: usize,
    usual_mm: f64,
}

impl Unequal {
    fn in_file(&self, file: &Path, points: &[Point]) -> CsvError {
        let (before, after) = (&points[self.row], &points[self.row + 1]);
        CsvError::UnequalStep {
            file: file.to_owned(),
            line: after.line.max(before.line),
            step_mm: after.x_mm - before.x_mm,
            usual_mm: self.usual_mm,
        }
    }
}

impl Steps {
    fn of(points: &[Point]) -> Result<Self, Unequal> {
        let steps: Vec<f64> = points.windows(2).map(|pair| pair[1].x_mm - pair[0].x_mm).collect();
        let usual_mm = median(steps.clone());
        let whole = |step: &f64| {
            let (times, nearest) = (step / usual_mm, (step / usual_mm).round());
            let within = (STEP_TOLERANCE * nearest).min(0.3);
            let fits = nearest >= 1.0 && nearest <= count(points.len()) && usual_mm > 0.0;
            (fits && (times - nearest).abs() <= within).then_some(nearest)
        };
        let found = match steps.iter().position(|step| whole(step).is_none()) {
            None => Self::over(points, steps.iter().filter_map(whole)),
            Some(row) => Self::rounded(points, &steps).ok_or(Unequal { row, usual_mm })?,
        };
        let widest = steps.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        match found.places.last().zip(widest) {
            Some((&last, (row, _))) if last > MOST_ABSENT * points.len() => {
                Err(Unequal { row, usual_mm })
            }
            _ => Ok(found),
        }
    }

    /// Where each `x_mm` is rounded to a digit that the steps are not wide against. Places that could be repeated must be
    /// repeated often: a single one is a row too many.
    fn rounded(points: &[Point], steps: &[f64]) -> Option<Self> {
        let digit = (0..=7).map(|digits| 10_f64.powi(-digits)).find(|digit| {
            points
                .iter()
                .all(|point| (point.x_mm / digit - (point.x_mm / digit).round()).abs() < 1e-4)
        })?;
        let baseline = BASELINE.min(steps.len());
        let far = points.iter().zip(points.get(baseline..)?);
        let usual = median(far.map(|(a, b)| (b.x_mm - a.x_mm) / count(baseline)).collect());
        let common = median(steps.to_vec());
        let odd = steps.iter().filter(|step| (*step - common).abs() > 0.1 * digit);
        let may_repeat = digit >= 0.5 * usual;
        if steps.len() < FEWEST_ROUNDED {
            return None;
        }
        if usual <= 0.0 || digit > 8.0 * usual || (may_repeat && 20 * odd.count() < steps.len()) {
            return None;
        }
        let times = |step: &f64| {
            if *step <= usual + 1.05 * digit { 1.0 } else { (step / usual).round() }
        };
        let widest = steps.iter().map(times).fold(0.0, f64::max);
        if widest > count(points.len()) || steps.iter().any(|step| *step < -0.1 * digit) {
            return None;
        }
        let found = Self::over(points, steps.iter().map(times));
        let first = points.first()?.x_mm;
        let off = |(point, place): (&Point, &usize)| {
            (point.x_mm - first - count(*place) * found.step_mm).abs()
        };
        let fits = points.iter().zip(&found.places).map(off).all(|off| off <= 1.05 * digit);
        fits.then_some(found)
    }

    /// Rows whose distances are `times` the step.
    fn over(points: &[Point], times: impl Iterator<Item = f64>) -> Self {
        let mut places = vec![0];
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "1 to the rows"
        )]
        places.extend(times.scan(0, |place, times| {
            *place += times as usize;
            Some(*place)
        }));
        let length = points.last().map_or(0.0, |last| last.x_mm - points[0].x_mm);
        Self { step_mm: length / count(places.last().copied().unwrap_or(1).max(1)), places }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

fn count(n: usize) -> f64 {
    n as f64
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
            "X [mm];Z [nm]\n0;1000\n0,0004;-2000\n0,0008;3500\n",
            "Position;H\u{f6}he\n(\u{b5}m);(nm)\n0,0;1000\n0,4;-2000\n0,8;3500\n",
            "distance (um),y,profile (um)\n0,1,1\n0.4,1,-2\n0.8,1,3.5\n",
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
            ("x_mm,height_foo\n0,1\n1,2\n", "column height_foo is in \"foo\""),
            ("x_mm,z\n0,1\n1,2\n", "for example z_um"),
            ("x_mm,z (m),y (m)\n0,1,1\n1,2,2\n", "named height, z, profile"),
            ("x_mm,height_um\n0,1\n1,2\n", "2 heights"),
            ("x_mm,height_um\n0,1\n1,2\n1,3\n2,4\n", "line 4, column x_mm: the same place"),
            (
                "x_mm,height_um\n0,1\n1,2\n2.5,3\n3.5,4\n",
                "line 4, column x_mm: a step of 1.5 mm where 1 mm",
            ),
            (
                "x_mm,height_um\n9,1\n8,2\n8.3,3\n7,4\n",
                "line 5, column x_mm: a step of 1.3 mm where 1 mm",
            ),
            ("x_mm,height_um\n0,1\n1,2\n2,3\n9e9,4\n", "line 5"),
            ("x_mm,height_um\n0,1\n1,NaN\n2,\n3,NaN\n", "1 heights"),
            ("x_mm,height_um\n0,1\n1,w\n2,3\n", "line 3, column height_um"),
            ("x_mm,height_um\n0,1\n1,\n,2\n", "line 4, column x_mm"),
            ("x_mm,height_um\n0,1\nx,2\n2,3\n", "line 3, column x_mm"),
        ] {
            let error = parse(text, None).unwrap_err();
            assert!(error.contains("p.csv") && error.contains(words), "{text:?}: {error}");
        }
    }

    /// Rows of a sine whose places are written with `digits` decimals; `kept` states which.
    fn written(step_mm: f64, digits: usize, kept: impl Fn(u32) -> bool) -> String {
        let row = |i: u32| {
            let height = 3.0 * (f64::from(i) / 40.0).sin();
            format!("{:.digits$},{height:.6}\n", 1.0 + step_mm * f64::from(i))
        };
        let rows = (0..4000).filter(|i| kept(*i)).map(row);
        format!("x_mm,height_um\n{}", rows.collect::<String>())
    }

    #[test]
    fn rounded_places_are_equal_steps() {
        for (step_mm, digits) in [(2.5e-4, 4), (2.5e-4, 3), (3.56e-4, 4), (5.005e-4, 4), (1e-3, 3)]
        {
            let profile = parse(&written(step_mm, digits, |_| true), None).unwrap();
            assert_eq!((profile.heights_m.len(), profile.filled.len()), (4000, 0), "{step_mm}");
            let off = profile.step_m / (1e-3 * step_mm) - 1.0;
            assert!(off.abs() < 1e-3, "{step_mm} {digits}: {off}");
        }
        let growing = (0..400)
            .map(|i| format!("{:.4},1\n", 2.5e-4 * f64::from(i) * (1.0 + f64::from(i) / 400.0)));
        let growing = format!("x_mm,height_um\n{}", growing.collect::<String>());
        assert!(parse(&growing, None).unwrap_err().contains("needs equal steps"));
    }

    #[test]
    fn what_was_not_measured_is_filled_within_and_dropped_at_the_ends() {
        let gap = |i: u32| !(1000..1020).contains(&i) && i != 2000;
        for (step_mm, digits) in [(1e-3, 4), (2.5e-4, 4)] {
            let profile = parse(&written(step_mm, digits, gap), None).unwrap();
            assert_eq!(profile.filled, [1000..1020, 2000..2001]);
            assert_eq!(profile.heights_m.len(), 4000);
            let off = |i: usize| profile.heights_m[i] - 3e-6 * (i as f64 / 40.0).sin();
            assert!((1000..1020).all(|i| off(i).abs() < 1e-7) && off(2000).abs() < 1e-8);
        }
        let text = "x_mm,height_um\n0,nan\n1,1\n2,NaN\n3,\n,\n4,4\n5,5\n6,inf\n";
        let profile = parse(text, None).unwrap();
        assert_eq!(profile.filled.first(), Some(&(1..3)));
        assert!(
            profile
                .heights_m
                .iter()
                .zip([1e-6, 2e-6, 3e-6, 4e-6])
                .all(|(a, b)| (a - b).abs() < 1e-15)
        );
        assert_eq!(
            parse("height_um\n1\n\n2\nnan\n4\n", Some(1.0)).unwrap().filled.first(),
            Some(&(2..3))
        );
        let falling = parse("x_mm,height_um\n3,1\n2,2\n1,3\n", None).unwrap();
        assert_eq!((falling.heights_m, falling.step_m), (vec![3e-6, 2e-6, 1e-6], 1e-3));
    }
}
