//! Reader of a list of irregularities, from a CSV file with `delta_m` and `s_m`.

use std::path::Path;

use crate::csv_read::read_bytes;
use crate::error::CsvError;
use grip_table::Table;

/// Height and spacing of one irregularity as a file has them: any number, also zero, negative, infinite or NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lengths {
    /// Height delta (m).
    pub delta_m: f64,
    /// Spacing s (m).
    pub spacing_m: f64,
}

/// Reads the irregularities in `file`: columns `delta_m` and `s_m`; others are passed over. At least one.
///
/// # Errors
/// Where the file cannot be read, a column is absent, a cell is not a number or there are no rows; see [`CsvError`].
pub fn read_irregularities(file: &Path) -> Result<Vec<Lengths>, CsvError> {
    parse_irregularities(file, &read_bytes(file)?)
}

/// The irregularities whose bytes are `bytes`; `file` stands in errors.
///
/// # Errors
/// As [`read_irregularities`].
pub fn parse_irregularities(file: &Path, bytes: &[u8]) -> Result<Vec<Lengths>, CsvError> {
    let mut table = Table::by_hand(file, bytes)?;
    let ((delta, delta_m), (spacing, s_m)) =
        (table.quantity(&["delta"], "m")?, table.quantity(&["s"], "m")?);
    let mut list = Vec::new();
    while let Some(row) = table.next_row()? {
        list.push(Lengths {
            delta_m: delta_m * row.number(delta)?,
            spacing_m: s_m * row.number(spacing)?,
        });
    }
    if list.is_empty() {
        return Err(CsvError::NoRows { file: file.to_owned() });
    }
    Ok(list)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Vec<Lengths>, String> {
        parse_irregularities(Path::new("i.csv"), text.as_bytes()).map_err(|e| e.to_string())
    }

    #[test]
    fn numbers_pass_as_they_are() {
        let list = parse("s_m,delta_m\n2e-4,5e-6\n1,0\n-1,inf\n").unwrap();
        assert_eq!(list[0], Lengths { delta_m: 5e-6, spacing_m: 2e-4 });
        assert_eq!(list[2], Lengths { delta_m: f64::INFINITY, spacing_m: -1.0 });
        assert!(parse("s_m,delta_m\n1,NaN\n").unwrap()[0].delta_m.is_nan());
    }

    #[test]
    fn what_is_wrong_is_reported_with_its_line() {
        for (text, words) in [
            ("delta_m\n1\n", "no column s_m"),
            ("delta_m,s_m\n", "no rows"),
            ("delta_m,s_m\n1,2\n1,abc\n", "line 3, column s_m"),
            ("delta_m,s_m\n1,2\n,2\n", "line 3, column delta_m"),
            ("delta_m,s_m\n1,2\n1\n", "line 3"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains("i.csv") && error.contains(words), "{text:?}: {error}");
        }
    }
}
