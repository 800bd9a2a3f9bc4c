//! Arrays of NumPy in: one signal a column, a field, or an array of an archive.

use crate::{arrays::Array, error::ImportError};
use grip_record::{CsvError, NpzArrays, NpzError, NumberTable, npy_table};
use std::path::Path;

/// A single array.
pub(crate) fn read(file: &Path) -> Result<Array, ImportError> {
    let table = npy_table(file)
        .map_err(|fault| ImportError::nothing(file, &format!("the array {fault}")))?;
    Ok(Array { format: "NPY", table, unit: None, rate: None })
}

/// The longest of the arrays of an archive, and those that are as long.
pub(crate) fn read_npz(file: &Path) -> Result<Array, ImportError> {
    let mut npz = NpzArrays::open(file).map_err(CsvError::from)?;
    let mut table = NumberTable::new(file);
    let mut found = Vec::new();
    for (at, name) in npz.names().to_vec().into_iter().enumerate() {
        match npz.table(at) {
            Ok(array) => found.push((name, array)),
            Err(NpzError::Array { array, fault, .. }) => {
                table.notes.push(format!("not used: {array}, which {fault}"));
            }
            Err(fault) => return Err(CsvError::from(fault).into()),
        }
    }
    let longest = found.iter().map(|(_, array)| array.rows).max().unwrap_or(0);
    for (name, array) in found {
        if array.rows == longest {
            table.append(array);
        } else {
            table.notes.push(format!("not used: {name}, of {} values", array.rows));
        }
    }
    Ok(Array { format: "NPZ", table, unit: None, rate: None })
}
