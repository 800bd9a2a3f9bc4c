//! `gripctl train --auto`: the model chosen by cross-validation, and why.

use super::{interval, rows::Parts};
use crate::{
    cli::learn::TrainArgs,
    commands::{columns::Columns, train_beyond::explain},
    output, table,
};
use grip_study::outlook::auto::{Tried, Way, auto, count};
use mlp::{
    Transform,
    train::{ColumnSpec, FitConfig},
};
use serde::Serialize;

#[derive(Serialize)]
#[serde(tag = "type", rename = "tried")]
struct Line<'a> {
    #[serde(flatten)]
    tried: &'a Tried,
    chosen: bool,
}

#[derive(Serialize)]
#[serde(tag = "type", rename = "auto")]
struct Chosen<'a> {
    model: &'static str,
    algorithm: Option<&'static str>,
    target: &'static str,
    reason: &'a str,
    folds: usize,
    rows: usize,
}

/// The arguments that train what was chosen on all training rows.
pub(super) fn chosen(
    args: &TrainArgs,
    config: &FitConfig,
    wanted: Columns,
) -> anyhow::Result<TrainArgs> {
    let rows = Parts::read(args, wanted)?.train;
    // Refused before all learners have run.
    interval::held(args, &rows)?;
    let bar = output::progress(count(), "learners");
    let found = auto(&rows, config, &|| bar.inc(1)).map_err(explain)?;
    bar.finish_and_clear();
    let Tried { learner, target, .. } = &found.tried[found.chosen];
    let algorithm = match learner {
        Way::Net(algorithm) => Some(algorithm.name()),
        Way::Poly(_) | Way::Gp => None,
    };
    let line = |(at, tried)| Line { tried, chosen: at == found.chosen };
    let lines: Vec<Line<'_>> = found.tried.iter().enumerate().map(line).collect();
    if args.json {
        lines.iter().try_for_each(output::json)?;
        let (model, reason) = (learner.model(), found.reason.as_str());
        let (target, rows) = (target.name(), rows.rows());
        output::json(&Chosen { model, algorithm, target, reason, folds: found.folds, rows })?;
    } else {
        let (rows, folds) = (rows.rows(), found.folds);
        output::line(&format!("{rows} rows, {folds} folds, each answered by what never saw it:"))?;
        let scores = ["mse=held_out.mse", "R2=held_out.r2", "within 10 %=held_out.within_10pct%"];
        let columns = [&["chosen", "learner", "target"][..], &scores, &["refused"]].concat();
        table::print(&lines, &columns)?;
        let form = match target {
            Transform::Identity => "",
            Transform::Ln => " of the logarithm",
            Transform::Reciprocal => " of the reciprocal",
        };
        output::line(&format!("chosen: {learner}{form}: {}", found.reason))?;
    }
    let mut chosen = args.clone();
    chosen.auto = false;
    learner.model().clone_into(&mut chosen.model);
    algorithm.unwrap_or(&args.algorithm).clone_into(&mut chosen.algorithm);
    chosen.repeats = args.repeats.max(if algorithm.is_some() { 2 } else { 1 });
    if let ([name], [spec]) = (&mut chosen.columns.target[..], &rows.targets[..]) {
        *name = ColumnSpec { transform: *target, ..spec.clone() }.to_string();
    }
    Ok(chosen)
}
