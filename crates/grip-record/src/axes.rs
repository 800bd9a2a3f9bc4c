//! Columns of a vector (`vibration_x`, `vibration_y`, `vibration_z`) in a header.
//!
//! | columns | the vector |
//! |---|---|
//! | `vibration` | one axis |
//! | `vibration_x`, `vibration_y`, `vibration_z`, or any of them | these axes |
//! | `vibration`, `vibration_2`, `vibration_left` | all of them: any suffix without another `_` is an axis |
//! | `vibration` beside all of x, y and z | x, y and z: the first is taken for their norm, or one of them |
//!
//! The same for `reference`.

use std::path::Path;

use slip_core::sample::FURTHER_AXES;

use crate::error::CsvError;

/// Columns of a vector: their names as the reader knows them, and their places.
pub(crate) type Axes = Vec<(String, usize)>;

/// Names that may have several axes.
const VECTORS: [&str; 2] = ["vibration", "reference"];

/// Whether `name` is that of an axis, such as `vibration_x`.
#[must_use]
pub fn is_axis(name: &str) -> bool {
    VECTORS.into_iter().any(|vector| suffix(name, vector).is_some())
}

fn suffix<'a>(name: &'a str, vector: &str) -> Option<&'a str> {
    let suffix = name.strip_prefix(vector)?.strip_prefix('_')?;
    (!suffix.is_empty() && suffix.chars().all(char::is_alphanumeric)).then_some(suffix)
}

/// The columns of `vector`, in the order of the file; empty where there is none.
///
/// # Errors
/// Where there are more than a vector has.
pub(crate) fn columns(file: &Path, header: &[String], vector: &str) -> Result<Axes, CsvError> {
    let known = |(column, name): (usize, &String)| {
        let is_axis = name == vector || suffix(name, vector).is_some();
        is_axis.then(|| (name.clone(), column))
    };
    let mut axes: Axes = header.iter().enumerate().filter_map(known).collect();
    let has = |axis: &str| axes.iter().any(|(name, _)| suffix(name, vector) == Some(axis));
    if ["x", "y", "z"].into_iter().all(has) {
        axes.retain(|(name, _)| name != vector);
    }
    if axes.len() > 1 + FURTHER_AXES {
        let found = axes.into_iter().map(|(name, _)| name).collect();
        return Err(CsvError::TooManyAxes {
            file: file.to_owned(),
            vector: vector.to_owned(),
            found,
        });
    }
    Ok(axes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(header: &[&str]) -> Result<Vec<String>, CsvError> {
        let header: Vec<String> = header.iter().map(|&name| name.to_owned()).collect();
        let axes = columns(Path::new("f.csv"), &header, "vibration")?;
        Ok(axes.into_iter().map(|(name, _)| name).collect())
    }

    #[test]
    fn axes_are_found_by_their_suffix() {
        let cases: [(&[&str], &[&str]); 5] = [
            (&["vibration"], &["vibration"]),
            (
                &["vibration", "vibration_x", "vibration_y", "vibration_z", "vibration_gyro_x"],
                &["vibration_x", "vibration_y", "vibration_z"],
            ),
            (&["vibration", "vibration_2"], &["vibration", "vibration_2"]),
            (&["vibration_x"], &["vibration_x"]),
            (&["reference_x", "vibrations_x", "vibration_"], &[]),
        ];
        for (header, expected) in cases {
            assert_eq!(names(header).unwrap(), expected, "{header:?}");
        }
    }

    #[test]
    fn a_vector_has_three() {
        let four = ["vibration_1", "vibration_2", "vibration_3", "vibration_4"];
        let text = names(&four).unwrap_err().to_string();
        assert!(text.contains("vibration_4") && text.contains("--map vibration="), "{text}");
    }
}
