//! `gripctl search`: the network that a genetic algorithm finds for rows of data.

use super::{
    clock,
    columns::{self, Columns},
    train_beyond::explain,
};
use crate::{cli::learn::SearchArgs, output, table};
use anyhow::Context as _;
use grip_session::exit::{Exit, WrongArgument};
use grip_study::outlook::{
    Candidate, Comparison, LearnersConfig, Search, SearchConfig, Sets, compare, learners::count,
    search::Generation,
};
use mlp::train::{DataSet, Fit, split::Split};
use serde::Serialize;

/// Candidates that are reported.
const SHOWN: usize = 10;

#[derive(Serialize)]
#[serde(tag = "type", rename = "candidate")]
struct Line<'a> {
    rank: usize,
    hidden: &'a [usize],
    activation: &'static str,
    algorithm: &'static str,
    decay: f64,
    weights: usize,
    validation_scaled_mse: f64,
    best_scaled_mse: f64,
    cost: f64,
}

/// Names shared with the result line of `train` mean the same; `epochs` is the one whose weights were kept.
#[derive(Serialize)]
#[serde(tag = "type", rename = "result")]
struct Result<'a> {
    algorithm: &'static str,
    epochs: usize,
    train_mse: f64,
    test_mse: Option<f64>,
    stop: String,
    cpu_s: f64,
    train_scaled_mse: f64,
    validation_scaled_mse: f64,
    test_scaled_mse: Option<f64>,
    train_within_10pct: f64,
    test_within_10pct: Option<f64>,
    #[serde(flatten)]
    classes: super::train::Classes,
    seed: u64,
    hidden: &'a [usize],
    activation: &'static str,
    decay: f64,
    weights: usize,
    tried: usize,
    failed: usize,
    rows: [usize; 2],
}

#[derive(Serialize)]
#[serde(tag = "type", rename = "comparison")]
struct Compared<'a> {
    #[serde(flatten)]
    learner: &'a Comparison,
}

pub(crate) fn run(args: &SearchArgs) -> anyhow::Result<Exit> {
    let inputs = [Some(args.data.as_path()), args.test.as_deref()];
    let out = output::path(&args.output, output::MODEL, &args.force, &inputs)?;
    let wanted = Columns::new(&args.columns)?;
    let data = wanted.load_grouped(&args.data, args.group.as_deref())?;
    if args.compare && args.columns.classify {
        let message = "--compare: the other learners estimate numbers and tell no classes apart";
        return Err(WrongArgument(message.to_owned()).into());
    }
    let wanted = wanted.with_classes_of(&data);
    let test = args.test.as_deref().map(|file| wanted.load(file)).transpose()?;
    let split = Split::holdout(&data, args.holdout, args.seed)
        .map_err(|error| WrongArgument(format!("--holdout: {error}")))?;
    let (train, validation) = split.of(&data)?;
    let config = config(args);
    let before = clock::processor()?;
    let bar = output::progress(args.generations, "generations");
    let reported = |generation: Generation| {
        bar.set_position(generation.done as u64);
        bar.set_message(format!(
            "{} networks, least cost {:.3e}  ",
            generation.tried, generation.cost
        ));
    };
    let found =
        grip_study::outlook::search(&train, &validation, &config, &reported).map_err(explain)?;
    bar.finish_and_clear();
    let fit = found.train_best(&train, &validation, test.as_ref(), &config)?;
    let cpu_s = clock::processor()?.saturating_sub(before).as_secs_f64();
    out.write(fit.file.to_json()?)?;
    report(args, &found, &fit, &train, &validation, cpu_s)?;
    if let (true, Some(test)) = (args.compare, &test) {
        let sets = Sets { train: &train, validation: &validation, test };
        others(args, sets, config)?;
    }
    if !args.json {
        output::line(&format!("model written to {}", args.output.display()))?;
    }
    Ok(columns::exit(&data))
}

fn config(args: &SearchArgs) -> SearchConfig {
    let mut config = SearchConfig {
        generations: args.generations,
        population: args.population,
        seed: args.seed,
        size_cost: args.size_cost,
        ..SearchConfig::default()
    };
    config.fit.seed = args.seed;
    config.fit.repeats = args.repeats;
    config.fit.run.epochs = args.epochs;
    config
}

fn report<'a>(
    args: &SearchArgs,
    found: &'a Search,
    fit: &Fit,
    train: &DataSet,
    validation: &DataSet,
    cpu_s: f64,
) -> anyhow::Result<()> {
    if !args.json {
        output::line(&format!(
            "{} networks tried on {} rows, judged on {} others; {cpu_s:.1} s of processor time",
            found.candidates.len() + found.failed,
            train.rows(),
            validation.rows()
        ))?;
    }
    let line = |(at, candidate): (usize, &'a Candidate)| {
        let Candidate { genome, weights, validation_mse, best_mse, cost, .. } = candidate;
        Line {
            rank: at + 1,
            hidden: &genome.hidden,
            activation: genome.activation.name(),
            algorithm: genome.algorithm.name(),
            decay: genome.decay,
            weights: *weights,
            validation_scaled_mse: *validation_mse,
            best_scaled_mse: *best_mse,
            cost: *cost,
        }
    };
    let lines: Vec<Line<'_>> = found.candidates.iter().take(SHOWN).enumerate().map(line).collect();
    if args.json {
        lines.iter().try_for_each(output::json)?;
    } else {
        let net = ["rank", "hidden", "activation", "algorithm", "decay", "weights"];
        table::print(&lines, &[&net[..], &["validation_scaled_mse", "cost"]].concat())?;
    }
    result(args, found, fit, [train.rows(), validation.rows()], cpu_s)
}

fn result(
    args: &SearchArgs,
    found: &Search,
    fit: &Fit,
    rows: [usize; 2],
    cpu_s: f64,
) -> anyhow::Result<()> {
    let best = found.best()?;
    let run = fit.runs.first().context("no run was chosen")?;
    let test = fit.test.as_ref();
    let result = Result {
        algorithm: best.genome.algorithm.name(),
        epochs: run.best_epoch,
        train_mse: fit.train.mse,
        test_mse: test.map(|test| test.mse),
        stop: run.stop.to_string(),
        cpu_s,
        train_scaled_mse: fit.train.scaled_mse,
        validation_scaled_mse: best.best_mse,
        test_scaled_mse: test.map(|test| test.scaled_mse),
        train_within_10pct: fit.train.within_fraction(0.1),
        test_within_10pct: test.map(|test| test.within_fraction(0.1)),
        classes: super::train::Classes::of(fit),
        seed: best.best_seed,
        hidden: &best.genome.hidden,
        activation: best.genome.activation.name(),
        decay: best.genome.decay,
        weights: best.weights,
        tried: found.candidates.len() + found.failed,
        failed: found.failed,
        rows,
    };
    if args.json {
        return output::json(&result);
    }
    output::line(&format!(
        "best: {}, epoch {} ({}), seed {}",
        best.genome, result.epochs, result.stop, result.seed
    ))?;
    output::evaluation("train:", &fit.train)?;
    if let Some(test) = test {
        output::evaluation("test: ", test)?;
    }
    Ok(())
}

/// Every learner on the same rows.
fn others(args: &SearchArgs, sets: Sets<'_>, search: SearchConfig) -> anyhow::Result<()> {
    let mut config = LearnersConfig { search, ..LearnersConfig::default() };
    config.fit.seed = args.seed;
    let bar = output::progress(count(), "learners");
    let done = |name: &str| {
        bar.inc(1);
        bar.set_message(format!("{name:28} "));
    };
    let rows = compare(sets, &config, &clock::monotonic, &done).map_err(explain)?;
    bar.finish_and_clear();
    if args.json {
        return rows.iter().try_for_each(|learner| output::json(&Compared { learner }));
    }
    output::line("")?;
    let errors = ["train mse=train.mse", "test mse=test.mse", "within 10 %=test.within_10pct%"];
    let spread = ["spread=uncertainty.spread", "within two of it %=uncertainty.within_two%"];
    table::print(&rows, &[&["name", "size"][..], &errors, &spread, &["detail"]].concat())
}
