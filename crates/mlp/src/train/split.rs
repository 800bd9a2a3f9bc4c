//! Split of rows into those that train and those held out, by labels, a share or a number of folds and a seed.
//!
//! Rows with the same label (an object, a grasp, a session) always stay on the same side: rows of one slip resemble each
//! other, and a test that holds some of them out while others train shows nothing of new objects. Without labels every
//! row stands for itself. Equal seeds give equal splits.

use std::collections::BTreeMap;

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use super::data::{DataSet, DataSetError};
use super::objective::count;
use super::setting::{self, SettingError};

/// Which rows train and which are held out, each in rising order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Split {
    /// Rows to train on, counted from 0.
    pub train: Vec<usize>,
    /// Rows kept away from the training.
    pub held_out: Vec<usize>,
}

/// Why rows can not be split.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SplitError {
    /// A share outside 0 to 1, or fewer than two folds.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Too few groups to give each part one.
    #[error("{groups} groups of rows can not be split into {parts} parts")]
    TooFewGroups {
        /// Groups there are; rows where there are no labels.
        groups: usize,
        /// Parts asked for.
        parts: usize,
    },
}

impl Split {
    /// Holds out whole groups, in an order the seed gives, as long as that brings their rows nearer to `share` of all; at
    /// least one group is held out and one left.
    ///
    /// # Errors
    /// [`SplitError::Setting`] unless `share` lies between 0 and 1; [`SplitError::TooFewGroups`] below two groups.
    pub fn holdout(data: &DataSet, share: f64, seed: u64) -> Result<Self, SplitError> {
        Self::holdout_of(data.rows(), data.labels(), share, seed)
    }

    /// The same for rows of which only the labels are known.
    ///
    /// # Errors
    /// As [`Split::holdout`].
    pub fn holdout_labels(labels: &[String], share: f64, seed: u64) -> Result<Self, SplitError> {
        Self::holdout_of(labels.len(), labels, share, seed)
    }

    fn holdout_of(
        rows: usize,
        labels: &[String],
        share: f64,
        seed: u64,
    ) -> Result<Self, SplitError> {
        setting::share("share", share)?;
        let groups = shuffled_groups(rows, labels, seed, 2)?;
        let wanted = share * count(rows);
        let (mut held_out, mut left) = (Vec::new(), groups.len());
        for group in &groups {
            let with = count(held_out.len() + group.len());
            let nearer = (with - wanted).abs() <= (wanted - count(held_out.len())).abs();
            if nearer && left > 1 {
                held_out.extend_from_slice(group);
                left -= 1;
            }
        }
        if held_out.is_empty() {
            held_out.extend(groups.iter().min_by_key(|group| group.len()).into_iter().flatten());
        }
        Ok(Self::without(rows, held_out))
    }

    /// `folds` splits; every row is held out in exactly one. The largest groups are dealt out first, each to the fold with
    /// the fewest rows, so rows without labels make folds that differ by one row at most.
    ///
    /// # Errors
    /// [`SplitError::Setting`] below 2; [`SplitError::TooFewGroups`] where there are fewer groups than folds.
    pub fn folds(data: &DataSet, folds: usize, seed: u64) -> Result<Vec<Self>, SplitError> {
        if folds < 2 {
            let (value, range) = (count(folds), "at least 2");
            return Err(SettingError { name: "folds", value, range }.into());
        }
        let mut groups = shuffled_groups(data.rows(), data.labels(), seed, folds)?;
        groups.sort_by_key(|group| core::cmp::Reverse(group.len()));
        let mut parts = vec![Vec::new(); folds];
        for group in groups {
            if let Some(smallest) = parts.iter_mut().min_by_key(|part| part.len()) {
                smallest.extend(group);
            }
        }
        Ok(parts.into_iter().map(|part| Self::without(data.rows(), part)).collect())
    }

    /// The training rows and the held-out rows of `data`.
    ///
    /// # Errors
    /// [`DataSetError::NoRows`] and [`DataSetError::NoSuchRow`] where the split is of other data.
    pub fn of(&self, data: &DataSet) -> Result<(DataSet, DataSet), DataSetError> {
        Ok((data.subset(&self.train)?, data.subset(&self.held_out)?))
    }

    fn without(rows: usize, mut held_out: Vec<usize>) -> Self {
        held_out.sort_unstable();
        let train = (0..rows).filter(|row| held_out.binary_search(row).is_err()).collect();
        Self { train, held_out }
    }
}

/// Rows of each group of equal labels; without labels each row is one.
pub(super) fn groups(rows: usize, labels: &[String]) -> Vec<Vec<usize>> {
    if labels.is_empty() {
        return (0..rows).map(|row| vec![row]).collect();
    }
    let mut named: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (row, label) in labels.iter().enumerate() {
        named.entry(label).or_default().push(row);
    }
    named.into_values().collect()
}

/// Rows of each group, the groups in the order the seed gives.
fn shuffled_groups(
    rows: usize,
    labels: &[String],
    seed: u64,
    parts: usize,
) -> Result<Vec<Vec<usize>>, SplitError> {
    let mut groups = groups(rows, labels);
    if groups.len() < parts {
        return Err(SplitError::TooFewGroups { groups: groups.len(), parts });
    }
    // Fisher and Yates. The modulo favours low numbers by less than 2^-40.
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for last in (1..groups.len()).rev() {
        let other = usize::try_from(rng.next_u64() % (last as u64 + 1)).unwrap_or(0);
        groups.swap(last, other);
    }
    Ok(groups)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn data(labels: Option<&[usize]>, rows: usize) -> DataSet {
        let mut csv = String::from("g,x,y\n");
        for row in 0..rows {
            let label = labels.map_or(row, |labels| labels[row]);
            csv.push_str(&format!("grasp {label},{row},{row}\n"));
        }
        let spec = |name: &str| vec![name.parse().unwrap()];
        let group = labels.map(|_| "g");
        DataSet::from_grouped_csv("g.csv", csv.as_bytes(), &spec("x"), &spec("y"), group).unwrap()
    }

    /// Both sides together are all rows, and no label stands on both.
    fn check(data: &DataSet, split: &Split) {
        let mut all: Vec<usize> = split.train.iter().chain(&split.held_out).copied().collect();
        all.sort_unstable();
        assert!(all.iter().copied().eq(0..data.rows()), "{split:?}");
        assert!(!split.train.is_empty() && !split.held_out.is_empty(), "{split:?}");
        let labels = |rows: &[usize]| -> BTreeSet<String> {
            rows.iter().filter_map(|&row| data.labels().get(row).cloned()).collect()
        };
        assert!(labels(&split.train).is_disjoint(&labels(&split.held_out)), "{split:?}");
    }

    proptest::proptest! {
        #[test]
        fn groups_never_leak(
            labels in proptest::collection::vec(0_usize..12, 2..120),
            share in 0.01_f64..0.99,
            folds in 2_usize..6,
            seed: u64,
        ) {
            let data = data(Some(&labels), labels.len());
            let groups = labels.iter().collect::<BTreeSet<_>>().len();
            match Split::holdout(&data, share, seed) {
                Ok(split) => {
                    check(&data, &split);
                    assert_eq!(split, Split::holdout(&data, share, seed).unwrap());
                }
                Err(error) => assert_eq!(error, SplitError::TooFewGroups { groups, parts: 2 }),
            }
            match Split::folds(&data, folds, seed) {
                Ok(splits) => {
                    let mut held: Vec<usize> =
                        splits.iter().flat_map(|split| split.held_out.clone()).collect();
                    held.sort_unstable();
                    assert!(splits.len() == folds && held.into_iter().eq(0..labels.len()));
                    splits.iter().for_each(|split| check(&data, split));
                }
                Err(error) => assert_eq!(error, SplitError::TooFewGroups { groups, parts: folds }),
            }
        }

        #[test]
        fn sizes_are_those_asked_for(
            rows in 10_usize..300, share in 0.1_f64..0.9, folds in 2_usize..10, seed: u64
        ) {
            let data = data(None, rows);
            let split = Split::holdout(&data, share, seed).unwrap();
            let off = count(split.held_out.len()) - share * count(rows);
            assert!(off.abs() <= 0.5, "{} of {rows} for {share}", split.held_out.len());
            let splits = Split::folds(&data, folds, seed).unwrap();
            let sizes = || splits.iter().map(|split| split.held_out.len());
            assert!(sizes().max().unwrap() - sizes().min().unwrap() <= 1);
        }
    }

    #[test]
    fn seeds_decide_and_the_data_sets_follow_the_rows() {
        let labels: Vec<usize> = (0..60).map(|row| row / 3).collect();
        let data = data(Some(&labels), 60);
        let split = Split::holdout(&data, 0.25, 1).unwrap();
        assert_ne!(split, Split::holdout(&data, 0.25, 2).unwrap());
        assert_ne!(Split::folds(&data, 4, 1), Split::folds(&data, 4, 2));
        assert_eq!(split.held_out.len(), 15);
        let (train, test) = split.of(&data).unwrap();
        assert_eq!((train.rows(), test.rows()), (45, 15));
        let first = test.iter().next().unwrap().0[0];
        assert_eq!(first, count(split.held_out[0]));
    }

    #[test]
    fn a_large_group_does_not_swallow_the_training_rows() {
        let mut labels = vec![0; 50];
        labels.extend([1, 2]);
        let data = data(Some(&labels), 52);
        for seed in 0..20 {
            check(&data, &Split::holdout(&data, 0.9, seed).unwrap());
            let split = Split::holdout(&data, 0.02, seed).unwrap();
            check(&data, &split);
            assert_eq!(split.held_out.len(), 1, "{split:?}");
        }
    }

    #[test]
    fn what_can_not_be_split_is_stated() {
        let data = data(Some(&[1, 1, 1]), 3);
        for share in [0.0, 1.0, -0.1, f64::NAN] {
            assert!(matches!(Split::holdout(&data, share, 0), Err(SplitError::Setting(_))));
        }
        assert_eq!(
            Split::holdout(&data, 0.5, 0).unwrap_err().to_string(),
            "1 groups of rows can not be split into 2 parts"
        );
        let one = Split::folds(&data, 1, 0).unwrap_err();
        assert_eq!(one.to_string(), "folds is 1: it must be at least 2");
    }
}
