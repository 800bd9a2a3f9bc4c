//! `gripctl collect`: rows for `gripctl train`, from recordings of many grippers.

use super::{checked, csv_options, host_config};
use crate::{
    cli::learn::{CollectArgs, CollectSplit},
    output,
};
use anyhow::bail;
use grip_eval::{
    collect::{
        COLUMNS, Collected, Fate, Keep, Request, Row, UNKNOWN, WatchConfig, collect, divide,
    },
    score::Quantiles,
};
use grip_record::outputs::{OutputKind, OutputPath};
use grip_session::exit::{Exit, WrongArgument};
use serde::Serialize;
use slip_core::estimate::Feature;
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

#[derive(Serialize)]
#[serde(tag = "type", rename = "summary")]
struct Summary {
    recordings: u64,
    unusable: u64,
    lossy: u64,
    slips: u64,
    kept: u64,
    /// By their reason.
    left_out: BTreeMap<&'static str, u64>,
    /// Error of the target that the bounds allow.
    target_error: Quantiles,
    train: Side,
    #[serde(skip_serializing_if = "Option::is_none")]
    test: Option<Side>,
    #[serde(skip_serializing_if = "Option::is_none")]
    split: Option<SplitReported>,
}

/// One file of rows.
#[derive(Serialize)]
struct Side {
    file: PathBuf,
    rows: usize,
    objects: BTreeSet<String>,
    grippers: BTreeSet<String>,
}

#[derive(Serialize)]
struct SplitReported {
    by: &'static str,
    share: f64,
    seed: u64,
    on_neither_side: usize,
}

pub(crate) fn run(args: &CollectArgs) -> anyhow::Result<Exit> {
    let (config, csv) = (host_config(args.config.as_deref())?, csv_options(&args.csv)?);
    let (require, watch) = (required(&args.require)?, watch(args)?);
    let test_file = beside(&args.output)?;
    let share = args.test_share.map(share).transpose()?;
    let places = args.places.iter().chain(&args.config);
    let inputs: Vec<_> = places.map(|place| Some(place.as_path())).collect();
    let out = |file: &Path| output::path(file, ROWS, &args.force, &inputs);
    let train_out = out(&args.output)?;
    let test_out = share.map(|_| out(&test_file)).transpose()?;
    let bar = output::progress(0, "recordings");
    let done = |now: usize, of: usize| {
        bar.set_length(of as u64);
        bar.set_position(now as u64);
    };
    let request = Request {
        places: &args.places,
        without: &[args.output.clone(), test_file.clone()],
        object: args.object.as_deref(),
        watch,
        require: &require,
        csv: &csv,
        config: &config,
    };
    let collected = collect(&request, &done)?;
    bar.finish_and_clear();
    for note in &collected.notes {
        output::note(&format!("gripctl: {note}"));
    }
    if collected.rows.is_empty() {
        bail!("nothing to train on: {}", found(&collected));
    }
    let summary = match share {
        None => {
            let all: Vec<usize> = (0..collected.rows.len()).collect();
            summary(&collected, write(&train_out, &collected.rows, &all)?)
        }
        Some(share) => {
            let divided = divide(&collected.rows, keep(args.split), share, args.seed)
                .map_err(|error| WrongArgument(format!("--split {}: {error}", by(args.split))))?;
            let train = write(&train_out, &collected.rows, &divided.train)?;
            let test = test_out.as_ref().map(|out| write(out, &collected.rows, &divided.test));
            let (by, seed, on_neither_side) = (by(args.split), args.seed, divided.left_out);
            let split = Some(SplitReported { by, share, seed, on_neither_side });
            Summary { test: test.transpose()?, split, ..summary(&collected, train) }
        }
    };
    report(args.json, &collected, &summary)?;
    let lossy = collected.lossy > 0 || collected.unusable > 0;
    Ok(if lossy { Exit::DataLost } else { Exit::Done })
}

fn watch(args: &CollectArgs) -> Result<WatchConfig, WrongArgument> {
    checked("--stay", args.stay, false)?;
    if !(args.widest > 1.0 && args.widest.is_finite()) {
        let message = format!("--widest {}: expected a ratio above 1", args.widest);
        return Err(WrongArgument(message));
    }
    #[expect(clippy::cast_possible_truncation, reason = "nobody needs more digits")]
    let watch = WatchConfig { stay_s: args.stay as f32, widest: args.widest as f32 };
    Ok(watch)
}

fn share(share: f64) -> Result<f64, WrongArgument> {
    if share > 0.0 && share < 1.0 {
        return Ok(share);
    }
    Err(WrongArgument(format!("--test-share {share}: expected a number between 0 and 1")))
}

fn required(names: &[String]) -> Result<Vec<Feature>, WrongArgument> {
    let found = names.iter().map(|name| {
        let known = || Feature::ALL.map(Feature::name).join(", ");
        Feature::from_name(name)
            .ok_or_else(|| WrongArgument(format!("--require {name}: expected some of {}", known())))
    });
    found.collect()
}

/// No other command writes these columns.
const ROWS: OutputKind =
    OutputKind { is_ours: |head| head.starts_with(COLUMNS.join(",").as_bytes()), ..output::TABLE };

/// `TRAIN-test.csv` beside `TRAIN.csv`.
fn beside(output: &Path) -> Result<PathBuf, WrongArgument> {
    let is_csv = output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"));
    let stem = output.file_stem().filter(|_| is_csv).ok_or_else(|| {
        WrongArgument(format!("--output {}: expected a name that ends with .csv", output.display()))
    })?;
    Ok(output.with_file_name(format!("{}-test.csv", stem.to_string_lossy())))
}

const fn keep(split: CollectSplit) -> Keep {
    match split {
        CollectSplit::Object => Keep::Object,
        CollectSplit::Gripper => Keep::Gripper,
        CollectSplit::Both => Keep::Both,
    }
}

const fn by(split: CollectSplit) -> &'static str {
    match split {
        CollectSplit::Object => "object",
        CollectSplit::Gripper => "gripper",
        CollectSplit::Both => "both",
    }
}

fn write(out: &OutputPath, rows: &[Row], which: &[usize]) -> anyhow::Result<Side> {
    let mut text = COLUMNS.join(",") + "\n";
    let (mut objects, mut grippers) = (BTreeSet::new(), BTreeSet::new());
    for row in which.iter().filter_map(|at| rows.get(*at)) {
        text += &row.csv();
        text.push('\n');
        objects.insert(row.object.clone());
        grippers.insert(format!("{}/{}", row.site, row.gripper));
    }
    out.write(text)?;
    Ok(Side { file: out.file().to_owned(), rows: which.len(), objects, grippers })
}

fn summary(collected: &Collected, train: Side) -> Summary {
    let error = |row: &Row| f64::from(row.slip.stayed_n / row.slip.slipped_n).sqrt() - 1.0;
    let count = |fate: Fate| collected.fates.get(&fate).copied().unwrap_or(0);
    let left_out = Fate::ALL.into_iter().filter(|fate| *fate != Fate::Kept);
    Summary {
        recordings: collected.recordings,
        unusable: collected.unusable,
        lossy: collected.lossy,
        slips: collected.fates.values().sum(),
        kept: count(Fate::Kept),
        left_out: left_out.map(|fate| (fate.name(), count(fate))).collect(),
        target_error: Quantiles::of(collected.rows.iter().map(error).collect()),
        train,
        test: None,
        split: None,
    }
}

/// What was found, in one sentence.
fn found(collected: &Collected) -> String {
    let slips: u64 = collected.fates.values().sum();
    let mut text = format!("{slips} slips in {} recordings", collected.recordings);
    if collected.unusable > 0 {
        text += &format!(", {} files left out", collected.unusable);
    }
    for (fate, count) in &collected.fates {
        text += &format!(", {count} {}", fate.text());
    }
    text
}

fn report(json: bool, collected: &Collected, summary: &Summary) -> anyhow::Result<()> {
    if let Some(split) = &summary.split {
        unknown(summary, split.by);
    }
    if json {
        return output::json(summary);
    }
    output::line(&found(collected))?;
    let error = &summary.target_error;
    output::line(&format!(
        "the bounds leave the target an error of {} % (median), {} % (95 % of the rows)",
        output::or_dash(error.p50.map(|share| 100.0 * share), 1),
        output::or_dash(error.p95.map(|share| 100.0 * share), 1)
    ))?;
    side(&summary.train)?;
    summary.test.as_ref().map_or(Ok(()), side)?;
    if let Some(split) = &summary.split {
        let text = match split.by {
            "both" => format!(
                "no object and no gripper is in both; {} rows on neither side",
                split.on_neither_side
            ),
            by => format!("no {by} is in both"),
        };
        output::line(&text)?;
    }
    Ok(())
}

/// What has no name is taken for one thing, and may be any of the others.
fn unknown(summary: &Summary, by: &str) {
    let sides: Vec<&Side> =
        [Some(&summary.train), summary.test.as_ref()].into_iter().flatten().collect();
    let has = |of: &dyn Fn(&Side) -> bool| sides.iter().any(|side| of(side));
    let objects = by != "gripper" && has(&|side| side.objects.contains(UNKNOWN));
    let grippers =
        by != "object" && has(&|side| side.grippers.iter().any(|name| name.ends_with(UNKNOWN)));
    for (of, is) in [("object", objects), ("gripper", grippers)] {
        if is {
            eprintln!(
                "gripctl: rows whose {of} is not known stand on one side, and may be of {of}s that stand on the other"
            );
        }
    }
}

fn side(side: &Side) -> anyhow::Result<()> {
    Ok(output::line(&format!(
        "{}: {} rows of {} objects in {} grippers",
        side.file.display(),
        side.rows,
        side.objects.len(),
        side.grippers.len()
    ))?)
}
