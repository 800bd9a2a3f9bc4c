//! Rows to train on, to stop by and to test on, from the arguments.

use crate::{
    cli::learn::{SplitArgs, TrainArgs},
    commands::columns::Columns,
};
use grip_session::exit::WrongArgument;
use mlp::train::{DataSet, Split, SplitError, file::SplitNote};

/// The rows of the training file without those held out, and the test rows from wherever they come.
pub(in crate::commands) struct Parts {
    pub(in crate::commands) train: DataSet,
    pub(in crate::commands) test: Option<DataSet>,
}

impl Parts {
    /// Reads the files and holds out the test rows.
    pub(super) fn read(args: &TrainArgs, columns: Columns) -> anyhow::Result<Self> {
        let split = &args.split;
        if split.split_by.is_some()
            && [split.holdout, split.validation].iter().all(Option::is_none)
            && split.folds.is_none()
            && args.interval.is_none()
            && !args.auto
        {
            let message =
                "--split-by goes with --holdout, --validation, --folds, --interval or --auto only";
            return Err(WrongArgument(message.to_owned()).into());
        }
        let train = columns.load_grouped(&args.data, split.split_by.as_deref())?;
        if let Some(share) = split.holdout {
            let parts = Split::holdout(&train, share, split.split_seed)
                .map_err(|error| wrong("--holdout", &share, &error))?;
            let (train, test) = parts.of(&train)?;
            return Ok(Self { train, test: Some(test) });
        }
        let columns = columns.with_classes_of(&train);
        let test = args.test.as_deref().map(|file| columns.load(file)).transpose()?;
        Ok(Self { train, test })
    }

    /// The rows to train on, and those to stop by.
    pub(super) fn for_training(
        &self,
        split: &SplitArgs,
    ) -> anyhow::Result<(DataSet, Option<DataSet>)> {
        for_training(&self.train, split)
    }
}

/// Holds out validation rows, where some are asked for.
pub(super) fn for_training(
    rows: &DataSet,
    split: &SplitArgs,
) -> anyhow::Result<(DataSet, Option<DataSet>)> {
    let Some(share) = split.validation else { return Ok((rows.clone(), None)) };
    let parts = Split::holdout(rows, share, split.split_seed)
        .map_err(|error| wrong("--validation", &share, &error))?;
    let (train, validation) = parts.of(rows)?;
    Ok((train, Some(validation)))
}

pub(super) fn wrong(
    flag: &str,
    value: &dyn core::fmt::Display,
    error: &SplitError,
) -> WrongArgument {
    WrongArgument(format!("{flag} {value}: {error}"))
}

/// What the model file states of the split, if there was one.
pub(super) fn note(split: &SplitArgs) -> Option<SplitNote> {
    let SplitArgs { split_by, holdout, validation, split_seed, .. } = split;
    (holdout.is_some() || validation.is_some()).then(|| SplitNote {
        by: split_by.clone(),
        seed: *split_seed,
        holdout: *holdout,
        validation: *validation,
    })
}
