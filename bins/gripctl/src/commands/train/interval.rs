//! `--interval`: how far the truth may be from an answer, by rows that were held out.

use crate::{cli::learn::TrainArgs, output};
use grip_session::exit::WrongArgument;
use indicatif::ParallelProgressIterator as _;
use mlp::train::{
    ColumnSpec, DataSet, FitConfig,
    fit::no_better_than_the_mean,
    interval::{HeldOut, Interval, Shown},
};
use ndarray::Array2;
use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};
use serde::Serialize;

/// What the result lines state of it; absent where none was asked for.
#[derive(Default, Serialize)]
pub(in crate::commands) struct Stated {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::commands) interval: Option<Interval>,
    /// Of the rows that were held out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::commands) held_out_r2: Option<f64>,
}

/// The interval of a network of all rows in `data`.
pub(super) fn of_network(
    args: &TrainArgs,
    config: &FitConfig,
    data: &DataSet,
) -> anyhow::Result<Stated> {
    shown(args, data, |train, held_out| {
        let (train, validation) = super::rows::for_training(train, &args.split)?;
        let fit = mlp::train::fit(&train, validation.as_ref(), None, config)?;
        Ok(mlp::train::predict(&*fit.model, &held_out.input_values())?.0)
    })
}

/// The parts that are left out in turn, where an interval is asked for.
pub(super) fn held<'a>(args: &TrainArgs, data: &'a DataSet) -> anyhow::Result<Option<HeldOut<'a>>> {
    let refused = |level, error| WrongArgument(format!("--interval {level}: {error}"));
    let held = |level| {
        HeldOut::new(data, level, args.split.split_seed).map_err(|error| refused(level, error))
    };
    Ok(args.interval.map(held).transpose()?)
}

/// That of any learner: `answer` trains on some rows and answers for others.
pub(in crate::commands) fn shown(
    args: &TrainArgs,
    data: &DataSet,
    answer: impl Fn(&DataSet, &DataSet) -> anyhow::Result<Array2<f64>> + Sync,
) -> anyhow::Result<Stated> {
    let Some(held) = held(args, data)? else { return Ok(Stated::default()) };
    let bar = output::progress(held.splits().len(), "parts");
    let parts = held.splits().par_iter().progress_with(bar);
    let answers = parts
        .map(|split| {
            let (train, held_out) = split.of(data)?;
            answer(&train, &held_out)
        })
        .collect::<anyhow::Result<Vec<_>>>()?;
    let Shown { interval, r2 } = held.shown(&answers)?;
    if let Some(warning) = no_better_than_the_mean("held-out", r2) {
        output::remark(&data.file, warning);
    }
    Ok(Stated { interval: Some(interval), held_out_r2: r2 })
}

impl Stated {
    /// A line for people, where there is an interval.
    pub(in crate::commands) fn report(&self, targets: &[ColumnSpec]) -> anyhow::Result<()> {
        let Some(interval) = &self.interval else { return Ok(()) };
        let limits =
            targets.iter().zip(&interval.widths).map(|(ColumnSpec { name, transform }, width)| {
                match transform.is_relative() {
                    true => format!("{name} / {width:.3} to * {width:.3}"),
                    false => format!("{name} +- {width:.3}"),
                }
            });
        let (limits, percent) = (limits.collect::<Vec<_>>().join(", "), 100.0 * interval.level);
        let r2 = self.held_out_r2.map_or(String::new(), |r2| format!("; R2 of those {r2:.4}"));
        Ok(output::line(&format!("{percent} % interval: {limits} ({}{r2})", interval.from))?)
    }
}
