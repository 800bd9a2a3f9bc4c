//! `gripctl train --auto`: the model chosen by cross-validation, and why.

use super::{interval, rows::Parts};
use crate::{
    cli::learn::TrainArgs,
    commands::{columns::Columns, train_beyond::explain},
    output,
};
use grip_study::outlook::{
    Auto,
    auto::{Tried, Way, auto, count},
};
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
    if args.json {
        for (at, tried) in found.tried.iter().enumerate() {
            output::json(&Line { tried, chosen: at == found.chosen })?;
        }
        let (model, reason) = (learner.model(), found.reason.as_str());
        let (target, rows) = (target.name(), rows.rows());
        output::json(&Chosen { model, algorithm, target, reason, folds: found.folds, rows })?;
    } else {
        table(&found, rows.rows())?;
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

fn table(found: &Auto, rows: usize) -> anyhow::Result<()> {
    output::line(&format!(
        "{rows} rows, {} folds, each answered by what never saw it:",
        found.folds
    ))?;
    output::line("   learner           target      mse            R2  within 10 %")?;
    for (at, tried) in found.tried.iter().enumerate() {
        let mark = if at == found.chosen { "->" } else { "  " };
        let Tried { learner, target, held_out, refused } = tried;
        let numbers = match held_out {
            Some(score) => format!(
                "{:<10.4e}  {:>7}  {:>8.1} %",
                score.mse,
                match score.r2 {
                    Some(r2) if r2 < -99.0 => "< -99".to_owned(),
                    r2 => output::or_dash(r2, 3),
                },
                100.0 * score.within_10pct
            ),
            None => refused.clone().unwrap_or_default(),
        };
        output::line(&format!(
            "{mark} {:<16}  {:<10}  {numbers}",
            learner.to_string(),
            target.name()
        ))?;
    }
    let Tried { learner, target, .. } = &found.tried[found.chosen];
    let form = match target {
        Transform::Identity => "",
        Transform::Ln => " of the logarithm",
        Transform::Reciprocal => " of the reciprocal",
    };
    Ok(output::line(&format!("chosen: {learner}{form}: {}", found.reason))?)
}
