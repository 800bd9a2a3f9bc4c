//! Rows, a share and a seed in, rows to train on and rows to test on out, with no object or gripper on both sides.

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
