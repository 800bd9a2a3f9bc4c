//! `gripctl train --model ensemble|svr|gp|mean|linear|poly`: learners beyond one network from rows of data.

use super::{
    clock,
    train::{
        interval::{self, Stated},
        rows::Parts,
        warn, worse_than_mean,
    },
};
use crate::{cli::learn::TrainArgs, output};
use core::time::Duration;
use grip_record::outputs::OutputPath;
use grip_session::exit::{Exit, WrongArgument};
use grip_study::outlook::{
    Ensemble, EnsembleConfig, Gp, OutlookError, Poly, Predict, Sampling, Score, Svr, SvrConfig,
    answers, score,
};
use mlp::train::{
    ColumnSpec, DataSet, FitConfig, ModelFile,
    fit::{no_better_than_the_mean, warnings},
    split::Split,
};
use serde::Serialize;

/// Names shared with the result line of networks mean the same.
#[derive(Serialize)]
#[serde(tag = "type", rename = "result")]
struct Result<'a> {
    model: &'a str,
    algorithm: &'a str,
    epochs: usize,
    train_mse: f64,
    test_mse: Option<f64>,
    stop: String,
    cpu_s: f64,
    train_scaled_mse: f64,
    test_scaled_mse: Option<f64>,
    train_within_10pct: f64,
    test_within_10pct: Option<f64>,
    train_r2: Option<f64>,
    test_r2: Option<f64>,
    worse_than_mean: Option<bool>,
    #[serde(flatten)]
    stated: Stated,
    support_vectors: Option<usize>,
    members: Option<usize>,
}

pub(crate) fn ensemble(
    args: &TrainArgs,
    fit: FitConfig,
    parts: &Parts,
    out: &OutputPath,
) -> anyhow::Result<Exit> {
    let data = &parts.train;
    if args.time_limit.is_some() {
        return Err(WrongArgument("--time-limit goes with --model mlp only".to_owned()).into());
    }
    let before = clock::processor()?;
    let sampling = if args.beyond.bagging { Sampling::Bagging } else { Sampling::Starts };
    let config = EnsembleConfig { members: args.beyond.members, sampling, fit };
    let mut ensemble = Ensemble::fit(data, None, &config).map_err(explain)?;
    let cpu = clock::processor()?.saturating_sub(before);
    let stated = interval::shown(args, data, |train, held_out| {
        let ensemble = Ensemble::fit(train, None, &config).map_err(explain)?;
        Ok(answers(&ensemble, held_out)?)
    })?;
    ensemble.interval.clone_from(&stated.interval);
    let text = ensemble.to_json()?;
    out.write(&text)?;
    let notes = ensemble.members().iter().filter_map(|file| file.training.as_ref());
    let result = Result {
        model: "ensemble",
        epochs: notes.map(|note| note.epochs).sum(),
        members: Some(config.members),
        stop: format!("{} networks trained", config.members),
        ..scored(&ensemble, parts, config.fit.algorithm.name(), cpu, stated)?
    };
    let weights = ensemble.members().first().map_or(0, weights);
    warn(args, warnings(data, weights).into_iter().chain(poor(&result)), Some(&text));
    report(args, &result, &data.targets)
}

fn weights(network: &ModelFile) -> usize {
    network.layers.iter().map(|layer| layer.biases.len() + layer.weights.concat().len()).sum()
}

fn poor(result: &Result<'_>) -> Option<String> {
    match result.test_mse {
        Some(_) => no_better_than_the_mean("test", result.test_r2),
        None => no_better_than_the_mean("training", result.train_r2),
    }
}

pub(crate) fn svr(args: &TrainArgs, parts: &Parts, out: &OutputPath) -> anyhow::Result<Exit> {
    let data = &parts.train;
    let before = clock::processor()?;
    Svr::check_rows(data).map_err(explain)?;
    let config = svr_config(args, data)?;
    let mut svr = Svr::fit(data, &config).map_err(explain)?;
    let cpu = clock::processor()?.saturating_sub(before);
    let stated = of_learner(args, data, |rows| Svr::fit(rows, &config))?;
    svr.columns.interval.clone_from(&stated.interval);
    out.write(svr.to_json()?)?;
    let stop = format!("c {}, gamma {}, epsilon {}", config.c, config.gamma, config.epsilon);
    let support_vectors = Some(svr.support_vectors());
    let result = scored(&svr, parts, "svr", cpu, stated)?;
    finished(args, parts, &Result { model: "svr", support_vectors, stop, ..result })
}

pub(crate) fn gp(args: &TrainArgs, parts: &Parts, out: &OutputPath) -> anyhow::Result<Exit> {
    let before = clock::processor()?;
    let mut gp = Gp::fit(&parts.train).map_err(explain)?;
    let cpu = clock::processor()?.saturating_sub(before);
    let stated = of_learner(args, &parts.train, Gp::fit)?;
    gp.columns.interval.clone_from(&stated.interval);
    out.write(gp.to_json()?)?;
    let stop = format!("{}, ln evidence {:.1}", gp.detail(), gp.ln_evidence());
    let result = scored(&gp, parts, "gp", cpu, stated)?;
    finished(args, parts, &Result { model: "gp", stop, ..result })
}

/// A polynomial: `mean`, `linear`, or `poly`, a cubic.
pub(crate) fn poly(args: &TrainArgs, parts: &Parts, out: &OutputPath) -> anyhow::Result<Exit> {
    let degree = match args.model.as_str() {
        "mean" => 0,
        "linear" => 1,
        _ => 3,
    };
    let before = clock::processor()?;
    let mut poly = Poly::fit(&parts.train, degree).map_err(explain)?;
    let cpu = clock::processor()?.saturating_sub(before);
    let stated = of_learner(args, &parts.train, |rows| Poly::fit(rows, degree))?;
    poly.columns.interval.clone_from(&stated.interval);
    out.write(poly.to_json()?)?;
    let (model, stop) = (poly.name(), format!("degree {degree}, {} coefficients", poly.size()));
    let result = scored(&poly, parts, model, cpu, stated)?;
    finished(args, parts, &Result { model, stop, ..result })
}

/// The interval of what `fit` makes of all rows.
fn of_learner<L: Predict>(
    args: &TrainArgs,
    data: &DataSet,
    fit: impl Fn(&DataSet) -> core::result::Result<L, OutlookError> + Sync,
) -> anyhow::Result<Stated> {
    interval::shown(args, data, |train, held_out| {
        Ok(answers(&fit(train).map_err(explain)?, held_out)?)
    })
}

/// Warns of what speaks against a learner that is no network, and prints its result.
fn finished(args: &TrainArgs, parts: &Parts, result: &Result<'_>) -> anyhow::Result<Exit> {
    // That the mean is no better than the mean needs no warning.
    let poor = poor(result).filter(|_| result.model != "mean");
    warn(args, warnings(&parts.train, 1).into_iter().chain(poor), None);
    report(args, result, &parts.train.targets)
}

/// What is not given is chosen on a fifth of the rows, and then all rows are fitted.
fn svr_config(args: &TrainArgs, data: &DataSet) -> anyhow::Result<SvrConfig> {
    let beyond = &args.beyond;
    let given = SvrConfig { epsilon: beyond.svr_epsilon, ..SvrConfig::default() };
    if let (Some(c), Some(gamma)) = (beyond.svr_c, beyond.svr_gamma) {
        return Ok(SvrConfig { c, gamma, ..given });
    }
    let mut grid: Vec<SvrConfig> = Vec::new();
    for tried in SvrConfig::grid() {
        let c = beyond.svr_c.unwrap_or(tried.c);
        let config = SvrConfig { c, gamma: beyond.svr_gamma.unwrap_or(tried.gamma), ..given };
        if !grid.contains(&config) {
            grid.push(config);
        }
    }
    let (train, held_out) = Split::holdout(data, 0.2, args.seed)?.of(data)?;
    Ok(Svr::choose(&train, &held_out, &grid).map_err(explain)?.config)
}

/// Settings out of range are wrong arguments.
pub(super) fn explain(error: OutlookError) -> anyhow::Error {
    match error {
        OutlookError::Setting(error) => WrongArgument(error.to_string()).into(),
        OutlookError::Fit(error) => WrongArgument(error.to_string()).into(),
        error @ OutlookError::Count { .. } => WrongArgument(error.to_string()).into(),
        other => other.into(),
    }
}

fn scored<'a>(
    learner: &dyn Predict,
    parts: &Parts,
    algorithm: &'a str,
    cpu: Duration,
    stated: Stated,
) -> anyhow::Result<Result<'a>> {
    let (data, test) = (&parts.train, parts.test.as_ref());
    let limits = data.target_scalings();
    let train = score(learner, data, &limits)?;
    let test: Option<Score> = test.map(|test| score(learner, test, &limits)).transpose()?;
    Ok(Result {
        model: "",
        algorithm,
        epochs: 0,
        train_mse: train.mse,
        test_mse: test.map(|test| test.mse),
        stop: String::new(),
        cpu_s: cpu.as_secs_f64(),
        train_scaled_mse: train.scaled_mse,
        test_scaled_mse: test.map(|test| test.scaled_mse),
        train_within_10pct: train.within_10pct,
        test_within_10pct: test.map(|test| test.within_10pct),
        train_r2: train.r2,
        test_r2: test.and_then(|test| test.r2),
        worse_than_mean: worse_than_mean(
            [test.and_then(|test| test.r2), stated.held_out_r2, None],
            train.r2,
        ),
        stated,
        support_vectors: None,
        members: None,
    })
}

fn report(args: &TrainArgs, result: &Result<'_>, targets: &[ColumnSpec]) -> anyhow::Result<Exit> {
    if args.json {
        output::json(result)?;
        return Ok(Exit::Done);
    }
    let vectors =
        result.support_vectors.map_or(String::new(), |n| format!(", {n} support vectors"));
    output::line(&format!(
        "{}: {}{vectors}; {:.2} s of processor time",
        result.model, result.stop, result.cpu_s
    ))?;
    let train = [result.train_mse, result.train_scaled_mse];
    output::errors("train:", train, result.train_within_10pct, result.train_r2)?;
    if let (Some(mse), Some(scaled), Some(within)) =
        (result.test_mse, result.test_scaled_mse, result.test_within_10pct)
    {
        output::errors("test: ", [mse, scaled], within, result.test_r2)?;
    }
    result.stated.report(targets)?;
    output::line(&format!("model written to {}", args.output.display()))?;
    Ok(Exit::Done)
}
