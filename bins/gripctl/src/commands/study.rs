//! `gripctl study`: the study of the four nets on simulated grasps, as a report.

use super::hyper;
use crate::{cli::learn::StudyArgs, output};
use anyhow::Context as _;
use grip_record::{
    outputs::{OutputError, OutputKind, OutputPath},
    write_columns,
};
use grip_session::exit::{Exit, WrongArgument};
use grip_study::{
    Condition, Report, Sets, StudyConfig,
    chapter::{Beyond, CONDITIONS, beyond},
    outlook::{LearnersConfig, learners},
    study::{
        self, ConditionResult, Study,
        claims::{Judged, judge},
    },
};
use ndarray::{Axis, concatenate};
use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// What came out, in one line.
#[derive(Serialize)]
#[serde(tag = "type", rename = "study")]
struct Summary {
    report: String,
    numbers: String,
    figures: usize,
    conditions: usize,
    trainings: usize,
    seed: u64,
    /// Mean difference from the published figures under the paper-like condition, percentage points.
    paper_difference_points: Option<f64>,
    /// Shares of unseen answers within 10 %, by condition and trainer.
    unseen_within_10pct: Map<String, Value>,
    cpu_s: f64,
}

pub(crate) fn run(args: &StudyArgs) -> anyhow::Result<Exit> {
    // Before the work, so that a folder that cannot be written is reported at once.
    for folder in ["figures", "rows"].map(|name| args.out.join(name)) {
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    }
    let out = Folder::new(args)?;
    let config = config(args)?;
    if args.claims {
        return claims(args, &config, out);
    }
    let sentences = config.claims_beside();
    let bar = output::progress(config.trainings() + sentences.claim_trainings(), "trainings");
    let study = study::run(&config, &|| bar.inc(1))?;
    let claims = judge(&sentences, &|| bar.inc(1))?;
    bar.finish_and_clear();
    let report = study.report(Some(&claims), &others(args)?);
    write(out, &report)?;
    for condition in &config.conditions {
        rows(out, condition, args.seed)?;
    }
    print(args, &study, &report)?;
    Ok(Exit::Done)
}

fn config(args: &StudyArgs) -> anyhow::Result<StudyConfig> {
    let base = match (args.claims, args.quick) {
        (true, _) => StudyConfig::claims(args.seed),
        (_, true) => StudyConfig::quick(args.seed),
        _ => StudyConfig::full(args.seed),
    };
    let config = StudyConfig {
        draws: args.draws.map_or(base.draws, usize::from),
        repeats: args.repeats.unwrap_or(base.repeats),
        epochs: args.epochs.unwrap_or(base.epochs),
        goal: args.goal.unwrap_or(base.goal),
        hidden: args.hidden.unwrap_or(base.hidden),
        hyper: hyper::of(&args.hyper)?,
        ..base
    };
    config.check().map_err(|error| WrongArgument(error.to_string()))?;
    Ok(config)
}

/// One claim, with the draws that decide it.
#[derive(Serialize)]
#[serde(tag = "type", rename = "claim")]
struct Claim<'a> {
    #[serde(flatten)]
    judged: &'a Judged,
}

/// What the source study states, held against many draws of rows.
fn claims(args: &StudyArgs, config: &StudyConfig, out: Folder<'_>) -> anyhow::Result<Exit> {
    let bar = output::progress(config.claim_trainings(), "trainings");
    let claims = judge(config, &|| bar.inc(1))?;
    bar.finish_and_clear();
    let report = claims.report();
    write(out, &report)?;
    if args.json {
        claims.judged.iter().try_for_each(|judged| output::json(&Claim { judged }))?;
        return Ok(Exit::Done);
    }
    for table in report.tables() {
        output::line(&format!("{}\n", table.markdown()))?;
    }
    output::line(&format!(
        "{} trainings, {:.1} s of processor time; report {}",
        config.claim_trainings(),
        super::clock::processor()?.as_secs_f64(),
        args.out.join("report.html").display()
    ))?;
    Ok(Exit::Done)
}

/// Learners beyond the four nets on the same rows.
fn others(args: &StudyArgs) -> anyhow::Result<Vec<Beyond>> {
    let names = if args.quick { &CONDITIONS[..1] } else { &CONDITIONS[..] };
    let mut config = if args.quick { LearnersConfig::quick() } else { LearnersConfig::default() };
    config.fit.seed = args.seed;
    config.search.seed = args.seed;
    let bar = output::progress(names.len() * learners::count(), "learners");
    let found = (names.iter().filter_map(|name| Condition::named(name)))
        .map(|condition| beyond(condition, args.seed, &config, &|_| bar.inc(1)))
        .collect::<Result<_, _>>()?;
    bar.finish_and_clear();
    Ok(found)
}

/// The folder of the report.
#[derive(Clone, Copy)]
struct Folder<'a> {
    path: &'a Path,
    /// Whether what is there is replaced: by --force, or because it is the report of an earlier study.
    force: bool,
}

impl<'a> Folder<'a> {
    /// Looks whether all may be written, before the work.
    fn new(args: &'a StudyArgs) -> anyhow::Result<Self> {
        let folder = Self { path: &args.out, force: args.force.force };
        let force = folder.force
            || folder.file("report.html", is_study).is_ok_and(|page| page.file().is_file());
        let mut files: Vec<PathBuf> =
            ["report.html", "study.json"].map(|name| args.out.join(name)).into();
        for name in ["figures", "rows"] {
            for file in fs::read_dir(args.out.join(name))? {
                files.push(file?.path());
            }
        }
        if let Some(file) = files.into_iter().find(|file| file.is_file() && !force) {
            return Err(OutputError::Exists { file, has_force: true }.into());
        }
        Ok(Self { force, ..folder })
    }

    fn file(self, name: &str, is_ours: fn(&[u8]) -> bool) -> Result<OutputPath, OutputError> {
        let kind = OutputKind { is_ours, ..OutputKind::ANY };
        OutputPath::new(&self.path.join(name), kind, [], Some(self.force))
    }
}

/// Whether a page is the report of a study.
fn is_study(head: &[u8]) -> bool {
    [
        "<title>The source study, claim by claim<",
        "<title>The study of the four nets, repeated and explained<",
    ]
    .iter()
    .any(|title| output::has(head, title))
}

fn write(folder: Folder<'_>, report: &Report) -> anyhow::Result<()> {
    let file = |name: &str, bytes: &[u8]| folder.file(name, |_| false)?.write(bytes);
    file("report.html", report.html()?.as_bytes())?;
    file("study.json", format!("{}\n", report.json()).as_bytes())?;
    let figures = report.figures();
    let bar = output::progress(figures.len(), "figures");
    figures.par_iter().try_for_each(|figure| {
        file(&format!("figures/{}.png", figure.id), &figure.chart.png()?)?;
        bar.inc(1);
        anyhow::Ok(())
    })?;
    bar.finish_and_clear();
    Ok(())
}

/// The rows of the first draw, which the figures show, with an array for each column.
fn rows(folder: Folder<'_>, condition: &Condition, seed: u64) -> anyhow::Result<()> {
    let Sets { train, test, unseen } = condition.sets(seed, 0)?;
    for (part, rows) in [("train", train), ("test", test), ("unseen", unseen)] {
        let names: Vec<&str> =
            rows.inputs.iter().chain(&rows.targets).map(|spec| spec.name.as_str()).collect();
        let values = concatenate(Axis(1), &[rows.input_values(), rows.target_values()])?;
        let mut out =
            folder.file(&format!("rows/{}-{part}.npz", condition.name), |_| false)?.create()?;
        write_columns(&mut out, &names, &values)?;
        out.finish()?;
    }
    Ok(())
}

fn print(args: &StudyArgs, study: &Study, report: &Report) -> anyhow::Result<()> {
    let distances = study::distances(study);
    let paper = distances
        .iter()
        .find(|distance| distance.condition == "paper" && distance.tolerance == "within_10pct");
    let summary = Summary {
        report: args.out.join("report.html").display().to_string(),
        numbers: args.out.join("study.json").display().to_string(),
        figures: report.figures().len(),
        conditions: study.results.len(),
        trainings: study.config.trainings(),
        seed: args.seed,
        paper_difference_points: paper.map(|distance| distance.points),
        unseen_within_10pct: study.results.iter().map(shares).collect(),
        cpu_s: super::clock::processor()?.as_secs_f64(),
    };
    if args.json {
        return output::json(&summary);
    }
    for id in ["table-2", "claims", "questions", "all-unseen"] {
        if let Some(table) = report.tables().into_iter().find(|table| table.id == id) {
            output::line(&format!("{}\n", table.markdown()))?;
        }
    }
    Ok(output::line(&format!(
        "{} trainings under {} conditions, {:.1} s of processor time; report {}, numbers {}, {} figures beside them",
        summary.trainings,
        summary.conditions,
        summary.cpu_s,
        summary.report,
        summary.numbers,
        summary.figures
    ))?)
}

fn shares(result: &ConditionResult) -> (String, Value) {
    let name = |title: &str| title.rsplit(' ').next().map(str::to_lowercase).unwrap_or_default();
    let mut shares: Map<String, Value> =
        result.unseen().into_iter().map(|(title, share)| (name(&title), json!(share))).collect();
    shares.insert("best_possible".to_owned(), json!(result.ceiling.within_10pct));
    (result.condition.name.to_owned(), Value::Object(shares))
}
