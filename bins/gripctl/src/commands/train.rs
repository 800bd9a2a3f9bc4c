//! `gripctl train`: a network from rows of data.

mod auto;
mod folds;
pub(super) mod interval;
pub(super) mod rows;

use super::{
    card, clock,
    columns::{self, Columns},
    hyper, train_beyond,
};
use crate::{cli::learn::TrainArgs, output};
use anyhow::Context as _;
use core::time::Duration;
use grip_record::outputs::OutputPath;
use grip_session::{
    exit::{Exit, WrongArgument},
    model,
};
use indicatif::{ParallelProgressIterator as _, ProgressBar};
use interval::Stated;
use mlp::{
    Activation,
    train::{
        Algorithm, Choice, DataSet, Fit, FitConfig, Method, Precision, RunConfig, fit::Fitting,
    },
};
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use rows::Parts;
use serde::Serialize;

#[derive(Serialize)]
#[serde(tag = "type", rename = "result")]
struct Result {
    algorithm: &'static str,
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
    #[serde(flatten)]
    classes: Classes,
    seed: u64,
    repeats: usize,
    gradient_evaluations: usize,
    repeats_scaled_mse: Vec<f64>,
    #[serde(flatten)]
    evidence: Option<Evidence>,
    #[serde(flatten)]
    rows: Rows,
}

/// What Bayesian regularisation has found out, in scaled units; absent for other rules.
#[derive(Serialize)]
struct Evidence {
    alpha: f64,
    beta: f64,
    effective_parameters: f64,
    ln_evidence: f64,
}

/// How well classes are distinguished; absent where none are.
#[derive(Serialize)]
pub(super) struct Classes {
    #[serde(skip_serializing_if = "Option::is_none")]
    train_accuracy: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    train_cross_entropy: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    test_accuracy: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    test_cross_entropy: Option<f64>,
}

impl Classes {
    pub(super) fn of(fit: &Fit) -> Self {
        let train = fit.train.classes;
        let test = fit.test.as_ref().and_then(|test| test.classes);
        Self {
            train_accuracy: train.map(|classes| classes.accuracy),
            train_cross_entropy: train.map(|classes| classes.cross_entropy),
            test_accuracy: test.map(|classes| classes.accuracy),
            test_cross_entropy: test.map(|classes| classes.cross_entropy),
        }
    }
}

/// Rows of each kind.
#[derive(Serialize)]
struct Rows {
    train_rows: usize,
    validation_rows: Option<usize>,
    test_rows: Option<usize>,
}

pub(crate) fn run(args: &TrainArgs) -> anyhow::Result<Exit> {
    let inputs = [Some(args.data.as_path()), args.test.as_deref()];
    let out = output::path(&args.output, output::MODEL, &args.force, &inputs)?;
    let config = fit_config(args)?;
    refuse_options_of_other_models(args)?;
    let wanted = Columns::new(&args.columns)?;
    if args.auto {
        return run(&auto::chosen(args, &config, wanted)?);
    }
    match args.model.as_str() {
        "mlp" => network(args, &config, wanted, &out),
        "ensemble" => {
            let parts = Parts::read(args, wanted)?;
            train_beyond::ensemble(args, config, &parts, &out)?;
            Ok(columns::exit(&parts.train))
        }
        "svr" => {
            let parts = Parts::read(args, wanted)?;
            train_beyond::svr(args, &parts, &out)?;
            Ok(columns::exit(&parts.train))
        }
        "gp" => {
            let parts = Parts::read(args, wanted)?;
            train_beyond::gp(args, &parts, &out)?;
            Ok(columns::exit(&parts.train))
        }
        "mean" | "linear" | "poly" => {
            let parts = Parts::read(args, wanted)?;
            train_beyond::poly(args, &parts, &out)?;
            Ok(columns::exit(&parts.train))
        }
        other => {
            let message =
                format!("--model {other}: expected mlp, ensemble, svr, gp, poly, linear or mean");
            Err(WrongArgument(message).into())
        }
    }
}

fn refuse_options_of_other_models(args: &TrainArgs) -> anyhow::Result<()> {
    let (beyond, split) = (&args.beyond, &args.split);
    for (option, given, model) in [
        ("--bagging", beyond.bagging, "ensemble"),
        ("--svr-c", beyond.svr_c.is_some(), "svr"),
        ("--svr-gamma", beyond.svr_gamma.is_some(), "svr"),
        ("--validation", split.validation.is_some(), "mlp"),
        ("--folds", split.folds.is_some(), "mlp"),
        ("--card", args.card.is_some(), "mlp"),
        ("--classify", args.columns.classify, "mlp"),
    ] {
        if given && args.model != model {
            return Err(WrongArgument(format!("{option} goes with --model {model} only")).into());
        }
    }
    Ok(())
}

fn network(
    args: &TrainArgs,
    config: &FitConfig,
    wanted: Columns,
    out: &OutputPath,
) -> anyhow::Result<Exit> {
    let inputs = [Some(args.data.as_path()), args.test.as_deref()];
    let card =
        card::output(args.card.as_deref(), &args.output, &args.force, &inputs, &[&args.output])?;
    let parts = Parts::read(args, wanted)?;
    let folds_r2 = match args.split.folds {
        Some(folds) => folds::run(args, config, &parts.train, folds)?,
        None => None,
    };
    let (train, validation) = parts.for_training(&args.split)?;
    let cpu_before = clock::processor()?;
    let mut fit = fit(&train, validation.as_ref(), parts.test.as_ref(), config)?;
    let cpu = clock::processor()?.saturating_sub(cpu_before);
    let stated = interval::of_network(args, config, &parts.train)?;
    fit.file.interval.clone_from(&stated.interval);
    if let Some(note) = &mut fit.file.training {
        note.split = rows::note(&args.split);
    }
    let text = fit.file.to_json()?;
    warn(args, fit.warnings.iter().cloned(), (!args.columns.classify).then_some(&text));
    out.write(&text)?;
    let name = args.output.display().to_string();
    let trained = card::trained(&name, &text, &fit, config, &train, parts.test.as_ref());
    card.write(trained.to_json()?)?;
    let rows = Rows {
        train_rows: train.rows(),
        validation_rows: validation.map(|rows| rows.rows()),
        test_rows: parts.test.map(|rows| rows.rows()),
    };
    report(args, &fit, rows, cpu, stated, folds_r2)?;
    Ok(columns::exit(&train))
}

/// What speaks against the rows or the model, and against the model `text` of a number for gripd.
pub(super) fn warn(
    args: &TrainArgs,
    warnings: impl IntoIterator<Item = String>,
    text: Option<&String>,
) {
    for warning in warnings {
        output::remark(args.data.display(), warning);
    }
    let name = args.output.display().to_string();
    if let Some(Err(error)) = text.map(|text| model::parse_estimator(&name, text)) {
        output::remark("no model for gripd", error);
    }
}

fn fit_config(args: &TrainArgs) -> anyhow::Result<FitConfig> {
    let algorithm = algorithm(args)?;
    Ok(FitConfig {
        hidden: args.hidden.clone(),
        activation: activation(&args.activation)?,
        algorithm,
        run: RunConfig {
            epochs: args.epochs,
            goal: args.goal,
            min_gradient: algorithm.min_gradient(),
            time_limit: time_limit(args)?,
            max_fail: args.split.patience,
        },
        seed: args.seed,
        repeats: args.repeats,
        choice: choice(&args.choice)?,
        precision: precision(&args.precision)?,
        decay: args.decay,
        scaler: scaler(&args.scaler)?,
    })
}

/// Trains from every start, in parallel.
fn fit(
    train: &DataSet,
    validation: Option<&DataSet>,
    test: Option<&DataSet>,
    config: &FitConfig,
) -> anyhow::Result<Fit> {
    let fitting = Fitting::new(train, validation, config)
        .map_err(|error| WrongArgument(error.to_string()))?;
    let start = clock::monotonic();
    let [trainings, epochs] = bars(config);
    let elapsed = || {
        epochs.inc(1);
        clock::monotonic().saturating_sub(start)
    };
    let runs = (0..config.repeats)
        .into_par_iter()
        .progress_with(trainings)
        .map(|repeat| fitting.run_timed(repeat, &elapsed))
        .collect();
    epochs.finish_and_clear();
    Ok(fitting.finish(runs, test)?.learned()?)
}

/// The bar of several trainings, and that of the epochs of a single one; on a terminal only.
fn bars(config: &FitConfig) -> [ProgressBar; 2] {
    if config.repeats > 1 {
        return [output::progress(config.repeats, "trainings"), ProgressBar::hidden()];
    }
    [ProgressBar::hidden(), output::progress(config.run.epochs, "epochs")]
}

fn algorithm(args: &TrainArgs) -> anyhow::Result<Algorithm> {
    let algorithm: Algorithm = args
        .algorithm
        .parse()
        .map_err(|error| WrongArgument(format!("--algorithm {}: {error}", args.algorithm)))?;
    hyper::refuse_others(&args.hyper, algorithm)?;
    Ok(hyper::of(&args.hyper)?.of(algorithm))
}

fn choice(name: &str) -> anyhow::Result<Choice> {
    match name {
        "best" => Ok(Choice::Best),
        "nearest-average" => Ok(Choice::NearestAverage),
        other => {
            let message = format!("--choice {other}: expected best or nearest-average");
            Err(WrongArgument(message).into())
        }
    }
}

fn scaler(name: &str) -> anyhow::Result<Method> {
    Ok(name.parse().map_err(|error| WrongArgument(format!("--scaler {name}: {error}")))?)
}

fn precision(name: &str) -> anyhow::Result<Precision> {
    match name {
        "f32" => Ok(Precision::Single),
        "f64" => Ok(Precision::Double),
        other => Err(WrongArgument(format!("--precision {other}: expected f32 or f64")).into()),
    }
}

fn time_limit(args: &TrainArgs) -> anyhow::Result<Option<Duration>> {
    let limit = args.time_limit.map(Duration::try_from_secs_f64).transpose();
    Ok(limit.map_err(|error| WrongArgument(format!("--time-limit: {error}")))?)
}

/// Hidden neurons that are linear would be no network.
fn activation(name: &str) -> anyhow::Result<Activation> {
    let known = name.parse().ok().filter(|activation| *activation != Activation::Linear);
    known.ok_or_else(|| {
        WrongArgument(format!("--activation {name}: expected tanh, logistic or relu")).into()
    })
}

/// Whether answering the mean would have been as good, on the first rows that judge. None where none do: rows that a model has learned
/// speak against it only.
pub(super) fn worse_than_mean(judges: [Option<f64>; 3], learned: Option<f64>) -> Option<bool> {
    let judge = judges.into_iter().flatten().next().or(learned.filter(|r2| *r2 <= 0.0));
    judge.map(|r2| r2 <= 0.0)
}

fn report(
    args: &TrainArgs,
    fit: &Fit,
    rows: Rows,
    cpu: Duration,
    stated: Stated,
    folds_r2: Option<f64>,
) -> anyhow::Result<()> {
    let run = fit.runs.get(fit.chosen).context("no run was chosen")?;
    let (train_r2, test_r2) = (fit.train.r2, fit.test.as_ref().and_then(|test| test.r2));
    let result = Result {
        algorithm: algorithm(args)?.name(),
        epochs: run.epochs,
        train_mse: fit.train.mse,
        test_mse: fit.test.as_ref().map(|test| test.mse),
        stop: run.stop.to_string(),
        cpu_s: cpu.as_secs_f64(),
        train_scaled_mse: fit.train.scaled_mse,
        test_scaled_mse: fit.test.as_ref().map(|test| test.scaled_mse),
        train_within_10pct: fit.train.within_fraction(0.1),
        test_within_10pct: fit.test.as_ref().map(|test| test.within_fraction(0.1)),
        train_r2,
        test_r2,
        worse_than_mean: worse_than_mean([test_r2, stated.held_out_r2, folds_r2], train_r2),
        stated,
        classes: Classes::of(fit),
        seed: fit.file.training.as_ref().map_or(args.seed, |note| note.seed),
        repeats: args.repeats,
        gradient_evaluations: run.gradient_evaluations,
        repeats_scaled_mse: fit.runs.iter().map(|run| run.mse).collect(),
        evidence: run.evidence.map(|found| Evidence {
            alpha: found.alpha,
            beta: found.beta,
            effective_parameters: found.effective,
            ln_evidence: found.ln_evidence,
        }),
        rows,
    };
    if args.json {
        return output::json(&result);
    }
    output::line(&format!(
        "{}: {} epochs ({}), seed {}, {} of {}; {:.2} s of processor time",
        result.algorithm,
        result.epochs,
        result.stop,
        result.seed,
        args.choice,
        result.repeats,
        result.cpu_s
    ))?;
    if let Some(found) = run.evidence {
        let weights = run.weights.len();
        output::line(&format!(
            "evidence: {:.1} of {weights} parameters in use, alpha {:.3e}, beta {:.3e} (noise {:.2e} rms, scaled), ln {:.1}",
            found.effective,
            found.alpha,
            found.beta,
            (0.5 / found.beta).sqrt(),
            found.ln_evidence
        ))?;
    }
    let of = format!("train: {} rows,", result.rows.train_rows);
    output::evaluation(&of, &fit.train)?;
    if let Some(test) = &fit.test {
        output::evaluation(&format!("test:  {} rows,", test.rows), test)?;
    }
    result.stated.report(&fit.file.specs().1)?;
    let card_path = args.card.clone().unwrap_or_else(|| card::path_beside(&args.output));
    let (model, card) = (args.output.display(), card_path.display());
    Ok(output::line(&format!("model written to {model}, its card to {card}"))?)
}
