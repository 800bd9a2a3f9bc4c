//! Split of rows by a share and a seed into rows to train on and rows to test on, with no object or gripper on both sides.

use super::row::Row;
use mlp::train::{Split, SplitError};

/// What must not stand on both sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// Objects.
    Object,
    /// Grippers.
    Gripper,
    /// Both: what has one of them on the other side is left out.
    Both,
}

/// Why rows cannot be divided.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DivideError {
    /// Too few names, or no share.
    #[error("{of}s: {source}")]
    Split {
        /// `object` or `gripper`.
        of: &'static str,
        /// What is wrong.
        source: SplitError,
    },
    /// A side is empty.
    #[error(
        "no row is left to {side}: {left_out} rows have their object on one side and their gripper on the other; divide by one of them, or \
         with another seed"
    )]
    Empty {
        /// `train on` or `test on`.
        side: &'static str,
        /// Rows on neither side.
        left_out: usize,
    },
}

/// Rows by their side, each in rising order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Divided {
    /// To train on.
    pub train: Vec<usize>,
    /// To test on.
    pub test: Vec<usize>,
    /// On neither side.
    pub left_out: usize,
}

/// Divides `rows`: about the given share of objects, of grippers, or of each is tested.
///
/// # Errors
/// [`DivideError`]: fewer than two names, a share that is none, or an empty side.
pub fn divide(rows: &[Row], keep: Keep, share: f64, seed: u64) -> Result<Divided, DivideError> {
    let by = |of: &'static str, label: &dyn Fn(&Row) -> String| {
        let labels: Vec<String> = rows.iter().map(label).collect();
        Split::holdout_labels(&labels, share, seed)
            .map_err(|source| DivideError::Split { of, source })
    };
    let object = || by("object", &|row| row.object.clone());
    // Another stream of random numbers is not needed: the names differ.
    let gripper = || by("gripper", &|row| format!("{}/{}", row.site, row.gripper));
    let (train, test) = match keep {
        Keep::Object => object().map(|split| (split.train, split.held_out))?,
        Keep::Gripper => gripper().map(|split| (split.train, split.held_out))?,
        Keep::Both => {
            let (object, gripper) = (object()?, gripper()?);
            let both = |one: &[usize], other: &[usize]| -> Vec<usize> {
                one.iter().copied().filter(|row| other.binary_search(row).is_ok()).collect()
            };
            (both(&object.train, &gripper.train), both(&object.held_out, &gripper.held_out))
        }
    };
    let left_out = rows.len() - train.len() - test.len();
    for (side, is) in [("train on", &train), ("test on", &test)] {
        if is.is_empty() {
            return Err(DivideError::Empty { side, left_out });
        }
    }
    Ok(Divided { train, test, left_out })
}

#[cfg(test)]
mod tests {
    use super::{DivideError, Keep, divide};
    use crate::collect::{MeasuredSlip, Row, row::tests::features};
    use slip_core::units::Micros;
    use std::collections::BTreeSet;

    fn rows(names: impl Iterator<Item = (u32, u32)>) -> Vec<Row> {
        let slip =
            MeasuredSlip { t: Micros(0), features: features(1.0), slipped_n: 1.0, stayed_n: 1.2 };
        names
            .map(|(object, gripper)| Row {
                site: "hall".to_owned(),
                gripper: gripper.to_string(),
                object: object.to_string(),
                recording: String::new(),
                slip: slip.clone(),
            })
            .collect()
    }

    #[test]
    fn nothing_that_is_kept_apart_stands_on_both_sides() {
        let rows = rows((0..120).map(|row| (row % 12, row % 10)));
        for (keep, seed) in [Keep::Object, Keep::Gripper, Keep::Both]
            .into_iter()
            .flat_map(|keep| [(keep, 0), (keep, 7)])
        {
            let divided = divide(&rows, keep, 0.25, seed).unwrap();
            assert_eq!(divide(&rows, keep, 0.25, seed).unwrap(), divided);
            let names = |side: &[usize], of: &dyn Fn(&Row) -> String| -> BTreeSet<String> {
                side.iter().map(|row| of(&rows[*row])).collect()
            };
            let apart = |of: &dyn Fn(&Row) -> String| {
                names(&divided.train, of).is_disjoint(&names(&divided.test, of))
            };
            assert!(keep == Keep::Gripper || apart(&|row| row.object.clone()), "{keep:?}");
            assert!(keep == Keep::Object || apart(&|row| row.gripper.clone()), "{keep:?}");
            let all = divided.train.len() + divided.test.len() + divided.left_out;
            assert_eq!((all, divided.left_out > 0), (120, keep == Keep::Both));
        }
    }

    #[test]
    fn what_cannot_be_kept_apart_is_refused() {
        let one = rows((0..9).map(|row| (3, row)));
        assert!(matches!(
            divide(&one, Keep::Object, 0.25, 0),
            Err(DivideError::Split { of: "object", .. })
        ));
        assert!(matches!(
            divide(&one, Keep::Gripper, 1.0, 0),
            Err(DivideError::Split { of: "gripper", .. })
        ));
        let diagonal = rows((0..2).map(|row| (row, 1 - row)));
        let crossed = (0..20).any(|seed| {
            matches!(
                divide(&diagonal, Keep::Both, 0.5, seed),
                Err(DivideError::Empty { left_out: 2, .. })
            )
        });
        assert!(crossed);
    }
}
