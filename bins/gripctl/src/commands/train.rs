//! `gripctl train`: a network from rows of data.

use super::{clock, columns::Columns, train_beyond};
use crate::{cli::TrainArgs, output};
use anyhow::Context as _;
use core::time::Duration;
use grip_host::exit::{Exit, WrongArgument};
use indicatif::{ParallelProgressIterator as _, ProgressBar, ProgressStyle};
use mlp::{
    Activation,
    train::{
        Algorithm, DataSet, Fit, FitConfig, Precision, RunConfig, fit::Fitting,
        trainer::MomentumForm,
    },
};
use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
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
    seed: u64,
    repeats: usize,
    gradient_evaluations: usize,
    repeats_scaled_mse: Vec<f64>,
}

pub(crate) fn run(args: &TrainArgs) -> anyhow::Result<Exit> {
    let config = config(args)?;
    let beyond = &args.beyond;
    for (option, given, model) in [
        ("--bagging", beyond.bagging, "ensemble"),
        ("--svr-c", beyond.svr_c.is_some(), "svr"),
        ("--svr-gamma", beyond.svr_gamma.is_some(), "svr"),
    ] {
        if given && args.model != model {
            let message = format!("{option} goes with --model {model} only");
            return Err(WrongArgument(message).into());
        }
    }
    let columns = Columns::new(&args.columns)?;
    let data = columns.load(&args.data)?;
    let test = args.test.as_deref().map(|file| columns.load(file)).transpose()?;
    match args.model.as_str() {
        "mlp" => network(args, &config, &data, test.as_ref()),
        "ensemble" => train_beyond::ensemble(args, config, &data, test.as_ref()),
        "svr" => train_beyond::svr(args, &data, test.as_ref()),
        other => {
            let message = format!("--model {other}: expected mlp, ensemble or svr");
            Err(WrongArgument(message).into())
        }
    }
}

fn config(args: &TrainArgs) -> anyhow::Result<FitConfig> {
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
            ..RunConfig::default()
        },
        seed: args.seed,
        repeats: args.repeats,
        precision: precision(&args.precision)?,
        decay: args.decay,
        ..FitConfig::default()
    })
}

fn network(
    args: &TrainArgs,
    config: &FitConfig,
    data: &DataSet,
    test: Option<&DataSet>,
) -> anyhow::Result<Exit> {
    let fitting =
        Fitting::new(data, None, config).map_err(|error| WrongArgument(error.to_string()))?;
    let cpu_before = clock::processor()?;
    let start = clock::monotonic();
    let runs = (0..args.repeats)
        .into_par_iter()
        .progress_with(progress(args.repeats))
        .map(|repeat| fitting.run_timed(repeat, &|| clock::monotonic().saturating_sub(start)))
        .collect();
    let cpu = clock::processor()?.saturating_sub(cpu_before);
    let fit = fitting.finish(runs, test)?;
    std::fs::write(&args.output, fit.file.to_json()?)
        .with_context(|| format!("cannot write {}", args.output.display()))?;
    report(args, &config.algorithm, &fit, cpu)?;
    Ok(Exit::Done)
}

/// A bar on a terminal, nothing elsewhere and nothing for a single run.
fn progress(repeats: usize) -> ProgressBar {
    if repeats < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} trainings").ok();
    let bar = ProgressBar::new(repeats as u64);
    match style {
        Some(style) => bar.with_style(style),
        None => bar,
    }
}

fn algorithm(args: &TrainArgs) -> anyhow::Result<Algorithm> {
    let mut algorithm: Algorithm = args
        .algorithm
        .parse()
        .map_err(|error| WrongArgument(format!("--algorithm {}: {error}", args.algorithm)))?;
    match (&mut algorithm, &args.rprop) {
        (Algorithm::Rprop(config), Some(name)) => {
            config.variant =
                name.parse().map_err(|error| WrongArgument(format!("--rprop: {error}")))?;
        }
        (_, Some(_)) => return Err(only("--rprop", "rprop")),
        (_, None) => {}
    }
    match (&mut algorithm, args.momentum.as_deref()) {
        (_, None) => {}
        (Algorithm::Gdm(config), Some("averaged")) => config.form = MomentumForm::Averaged,
        (Algorithm::Gdm(config), Some("heavy-ball")) => config.form = MomentumForm::HeavyBall,
        (Algorithm::Gdm(_), Some(other)) => {
            let message = format!("--momentum {other}: expected averaged or heavy-ball");
            return Err(WrongArgument(message).into());
        }
        (_, Some(_)) => return Err(only("--momentum", "gdm")),
    }
    Ok(algorithm)
}

fn only(option: &str, algorithm: &str) -> anyhow::Error {
    WrongArgument(format!("{option} goes with --algorithm {algorithm} only")).into()
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

fn report(args: &TrainArgs, algorithm: &Algorithm, fit: &Fit, cpu: Duration) -> anyhow::Result<()> {
    let run = fit.runs.get(fit.chosen).context("no run was chosen")?;
    let result = Result {
        algorithm: algorithm.name(),
        epochs: run.epochs,
        train_mse: fit.train.mse,
        test_mse: fit.test.as_ref().map(|test| test.mse),
        stop: run.stop.to_string(),
        cpu_s: cpu.as_secs_f64(),
        train_scaled_mse: fit.train.scaled_mse,
        test_scaled_mse: fit.test.as_ref().map(|test| test.scaled_mse),
        train_within_10pct: fit.train.within_fraction(0.1),
        test_within_10pct: fit.test.as_ref().map(|test| test.within_fraction(0.1)),
        seed: fit.file.training.as_ref().map_or(args.seed, |note| note.seed),
        repeats: args.repeats,
        gradient_evaluations: run.gradient_evaluations,
        repeats_scaled_mse: fit.runs.iter().map(|run| run.mse).collect(),
    };
    if args.json {
        return output::json(&result);
    }
    output::line(&format!(
        "{}: {} epochs ({}), seed {}, best of {}; {:.2} s of processor time",
        result.algorithm, result.epochs, result.stop, result.seed, result.repeats, result.cpu_s
    ))?;
    output::line(&format!(
        "train: mse {:.6} (target unit squared), {:.6} (scaled), within 10 %: {:.1} %",
        result.train_mse,
        result.train_scaled_mse,
        100.0 * result.train_within_10pct
    ))?;
    if let (Some(mse), Some(scaled), Some(within)) =
        (result.test_mse, result.test_scaled_mse, result.test_within_10pct)
    {
        output::line(&format!(
            "test:  mse {mse:.6} (target unit squared), {scaled:.6} (scaled), within 10 %: {:.1} %",
            100.0 * within
        ))?;
    }
    Ok(output::line(&format!("model written to {}", args.output.display()))?)
}
