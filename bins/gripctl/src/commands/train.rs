//! `gripctl train`: a network from rows of data.

use super::read;
use crate::{cli::TrainArgs, output};
use anyhow::Context as _;
use core::time::Duration;
use grip_host::exit::{Exit, WrongArgument};
use indicatif::{ParallelProgressIterator as _, ProgressBar, ProgressStyle};
use mlp::train::{
    Algorithm, ColumnSpec, DataSet, Fit, FitConfig, Precision, RunConfig, fit::Fitting,
    trainer::MomentumForm,
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
    let algorithm = algorithm(args)?;
    let (inputs, targets) = (specs(&args.inputs)?, specs(&args.target)?);
    let load = |file: &std::path::Path| -> anyhow::Result<DataSet> {
        Ok(DataSet::from_csv(&file.display().to_string(), &read(file)?, &inputs, &targets)?)
    };
    let data = load(&args.data)?;
    let test = args.test.as_deref().map(load).transpose()?;
    let config = FitConfig {
        hidden: args.hidden.clone(),
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
    };
    let fitting =
        Fitting::new(&data, None, &config).map_err(|error| WrongArgument(error.to_string()))?;
    let cpu_before = cpu_time()?;
    let start = monotonic();
    let runs = (0..args.repeats)
        .into_par_iter()
        .progress_with(progress(args.repeats))
        .map(|repeat| fitting.run_timed(repeat, &|| monotonic().saturating_sub(start)))
        .collect();
    let cpu = cpu_time()?.saturating_sub(cpu_before);
    let fit = fitting.finish(runs, test.as_ref())?;
    std::fs::write(&args.output, fit.file.to_json()?)
        .with_context(|| format!("cannot write {}", args.output.display()))?;
    report(args, &algorithm, &fit, cpu)?;
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

fn monotonic() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    // Since the machine started: neither part is negative.
    Duration::new(time.tv_sec.unsigned_abs(), u32::try_from(time.tv_nsec).unwrap_or(0))
}

fn specs(names: &[String]) -> anyhow::Result<Vec<ColumnSpec>> {
    names
        .iter()
        .map(|name| name.parse().map_err(|error| WrongArgument(format!("{error}")).into()))
        .collect()
}

/// Processor time of this process, all threads.
pub(super) fn cpu_time() -> anyhow::Result<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Ok(Duration::new(u64::try_from(time.tv_sec)?, u32::try_from(time.tv_nsec)?))
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
