//! A header and the renamings in, the columns of a vector (`vibration_x`, `vibration_y`, `vibration_z`) out.
//!
//! | columns | the vector |
//! |---|---|
//! | `vibration` | one axis |
//! | `vibration_x`, `vibration_y`, `vibration_z`, or any of them | these axes |
//! | `vibration`, `vibration_2`, `vibration_left` | all of them: any suffix without another `_` is an axis |
//! | `vibration` beside all of x, y and z | x, y and z: the first is taken for their norm, or one of them |
//!
//! The same for `reference`. A renaming of the plain name (`--map vibration=NAME`) chooses that column alone.

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
pub(crate) fn columns(
    file: &Path,
    header: &[String],
    map: &[(String, String)],
    vector: &str,
) -> Result<Axes, CsvError> {
    let position = |wanted: &str| header.iter().position(|column| column == wanted);
    if let Some((ours, theirs)) = map.iter().find(|(ours, _)| ours == vector) {
        return Ok(position(theirs).map(|column| (ours.clone(), column)).into_iter().collect());
    }
    let known = |(column, name): (usize, &String)| {
        let ours = match map.iter().find(|(_, theirs)| theirs == name) {
            Some((ours, _)) => ours,
            None if map.iter().any(|(ours, _)| ours == name) => return None,
            None => name,
        };
        let ours = (ours == vector || suffix(ours, vector).is_some()).then_some(ours)?;
        Some((ours.clone(), column))
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

    fn names(header: &[&str], map: &[(&str, &str)]) -> Result<Vec<String>, CsvError> {
        let header: Vec<String> = header.iter().map(|&name| name.to_owned()).collect();
        let map: Vec<_> = map.iter().map(|&(a, b)| (a.to_owned(), b.to_owned())).collect();
        let axes = columns(Path::new("f.csv"), &header, &map, "vibration")?;
        Ok(axes.into_iter().map(|(name, at)| format!("{name}={}", header[at])).collect())
    }

    #[test]
    fn axes_are_found_by_their_suffix() {
        type Case = (
            &'static [&'static str],
            &'static [(&'static str, &'static str)],
            &'static [&'static str],
        );
        let cases: [Case; 7] = [
            (&["vibration"], &[], &["vibration=vibration"]),
            (
                &["vibration", "vibration_x", "vibration_y", "vibration_z", "vibration_gyro_x"],
                &[],
                &["vibration_x=vibration_x", "vibration_y=vibration_y", "vibration_z=vibration_z"],
            ),
            (
                &["vibration", "vibration_2"],
                &[],
                &["vibration=vibration", "vibration_2=vibration_2"],
            ),
            (&["vibration_x"], &[], &["vibration_x=vibration_x"]),
            (
                &["vibration_x", "vibration_y", "a"],
                &[("vibration_y", "a")],
                &["vibration_x=vibration_x", "vibration_y=a"],
            ),
            (
                &["vibration_x", "vibration_y"],
                &[("vibration", "vibration_y")],
                &["vibration=vibration_y"],
            ),
            (&["reference_x", "vibrations_x", "vibration_"], &[], &[]),
        ];
        for (header, map, expected) in cases {
            assert_eq!(names(header, map).unwrap(), expected, "{header:?}");
        }
    }

    #[test]
    fn a_vector_has_three() {
        let four = ["vibration_1", "vibration_2", "vibration_3", "vibration_4"];
        let text = names(&four, &[]).unwrap_err().to_string();
        assert!(text.contains("vibration_4") && text.contains("--map vibration="), "{text}");
    }
}
