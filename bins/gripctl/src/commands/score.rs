//! `gripctl score`: labelled recordings against the detector.

use super::{calibrated_config, csv_options, score_curve};
use crate::{
    cli::{FloorOrigin, ScoreArgs},
    output,
    output::{any_unit, or_dash},
    table,
};
use grip_eval::{
    score::interval::Interval,
    score::{
        CauseScore, Chance, Clock, DETECTORS, Detector, FloorFrom, Floors, RecordingScore, Rules,
        Score, ScoreError, Total, UNKNOWN, Watch, compare,
    },
};
use grip_session::exit::{Exit, WrongArgument};
use serde::Serialize;
use std::{collections::BTreeSet, path::PathBuf};

/// Recordings that a note names.
const NAMED: usize = 20;

/// Less rest than this makes a floor that the next recording may contradict (s).
const SHORT_REST_S: f64 = 0.05;

pub(crate) fn run(args: &ScoreArgs) -> anyhow::Result<Exit> {
    if !(args.guard_ms >= 0.0 && args.guard_ms.is_finite()) {
        let message = format!("--guard-ms {}: expected 0 or more", args.guard_ms);
        return Err(WrongArgument(message).into());
    }
    let inputs = [Some(&args.directory), args.calibration.as_ref(), args.config.as_ref()];
    let inputs = inputs.map(|input| input.map(|path| path.as_path()));
    let curve = |file: &PathBuf| output::path(file, score_curve::CURVE, &args.force, &inputs);
    let curves = args.curve.iter().map(curve).collect::<Result<Vec<_>, _>>()?;
    let config = calibrated_config(args.config.as_deref(), args.calibration.as_deref())?;
    let detectors = detectors(&args.detectors)?;
    let options = csv_options(&args.csv)?;
    let floors = match args.floor {
        FloorOrigin::Folds => Floors::Folds,
        FloorOrigin::Live => Floors::Live,
    };
    let rules = Rules { guard_ms: args.guard_ms, floors };
    #[expect(clippy::disallowed_methods, reason = "a program may read a clock")]
    let start = std::time::Instant::now();
    let elapsed = || start.elapsed();
    let clock = args.time.then_some(&elapsed as Clock<'_>);
    let bar = output::progress(0, "scores");
    let done = |now: usize, of: usize| {
        bar.set_length(of as u64);
        bar.set_position(now as u64);
    };
    let watch = Watch { clock, done: Some(&done) };
    let scores = compare(&args.directory, &options, &config, rules, &detectors, watch)?;
    bar.finish_and_clear();
    let scored = || scores.iter().flatten();
    if let Some(score) = scored().next() {
        report_floor(score, args);
    }
    report_learning(scored());
    if let Some((rms, range)) = scored().find_map(|s| s.taxel_rms.zip(Some(s.taxel_range))) {
        let range = range.map_or_else(String::new, |range| format!(", range {}", any_unit(range)));
        eprintln!(
            "taxel noise of the labelled rest, for each material of the others': {} over all (rms){range}",
            any_unit(rms)
        );
    }
    // Of the first detector: the files of all are the same.
    let recordings = scored().next().map_or(&[] as &[_], |score| score.recordings.as_slice());
    for one in recordings {
        one.file.remarks.iter().for_each(|remark| output::remark(&one.recording, remark));
    }
    let cut = recordings.iter().any(|one| one.file.cut);
    for (score, detector) in scores.iter().zip(&detectors) {
        match score {
            Ok(score) => show(score, args)?,
            Err(why) => refused(detector.name, why, args.json)?,
        }
    }
    if scores.len() > 1 && !args.json {
        beside(scored(), args.guard_ms)?;
    }
    for out in &curves {
        score_curve::write(out, scored(), args.guard_ms)?;
    }
    Ok(if cut { Exit::DataLost } else { Exit::Done })
}

fn detectors(names: &[String]) -> anyhow::Result<Vec<Detector>> {
    let found = names.iter().map(|name| {
        let known = || DETECTORS.map(|detector| detector.name).join(", ");
        Detector::named(name).ok_or_else(|| {
            WrongArgument(format!("--detectors {name}: expected one of {}", known())).into()
        })
    });
    found.collect()
}

fn report_floor(score: &Score, args: &ScoreArgs) {
    let own = score.recordings.iter().filter(|one| one.floor_from == FloorFrom::Own).count();
    if own > 0 {
        let why = match args.floor {
            FloorOrigin::Live => "",
            FloorOrigin::Folds => ": no labelled rest of another material is there",
        };
        eprintln!(
            "{own} of {} recordings learn their noise floor from their own first samples, as live{why}",
            score.recordings.len()
        );
    }
    if args.floor == FloorOrigin::Folds && args.calibration.is_none() {
        eprintln!(
            "in a paper cite --floor live: each recording learns its floor from its own beginning, as on a gripper; folds, used here, take it from labelled stillness of the other materials, for recordings too short to learn it"
        );
    }
    let Some([shear, vibration, ..]) = score.floor.filter(|_| own < score.recordings.len()) else {
        return;
    };
    let (origin, pooled) = match &args.calibration {
        Some(file) => (format!("taken from {}, measured on", file.display()), "rest"),
        None => {
            ("measured on".to_owned(), "labelled rest, for each material on that of the others")
        }
    };
    eprintln!(
        "noise floor {origin} {:.3} s of {pooled}: shear {}, vibration {} (rms)",
        score.floor_s,
        any_unit(shear.sqrt()),
        any_unit(vibration.sqrt())
    );
    if score.floor_s < SHORT_REST_S {
        eprintln!(
            "warning: that is less than {SHORT_REST_S} s of stillness; the floor, and with it every figure below, may be far off"
        );
    }
}

/// Recordings in which the signal shows nothing.
fn report_learning<'a>(scores: impl Iterator<Item = &'a Score>) {
    let learning = scores.flat_map(|score| &score.recordings).filter(|one| one.learning);
    let names: BTreeSet<&str> = learning.map(|one| one.recording.as_str()).collect();
    let more = match names.len() {
        0 => return,
        count if count > NAMED => format!(" and {} more (--json: learning)", count - NAMED),
        _ => String::new(),
    };
    let named = Vec::from_iter(names.into_iter().take(NAMED)).join(", ");
    eprintln!(
        "the noise floor is never learned, so that the signal shows no slip, in {named}{more}; longer stillness at the beginning is needed, or --floor folds"
    );
}

/// A detector that cannot run on these recordings.
#[derive(Serialize)]
#[serde(tag = "type", rename = "refused")]
struct Refused<'a> {
    detector: &'a str,
    why: &'a str,
}

fn refused(detector: &str, why: &ScoreError, json: bool) -> anyhow::Result<()> {
    let why = why.to_string();
    if json {
        return output::json(&Refused { detector, why: &why });
    }
    Ok(output::line(&format!("\ndetector: {detector}\nnot scored: {why}"))?)
}

fn show(score: &Score, args: &ScoreArgs) -> anyhow::Result<()> {
    let total = score.total(args.guard_ms);
    let materials = if args.materials { score.materials() } else { Vec::new() };
    if args.json {
        for recording in &score.recordings {
            output::json(recording)?;
        }
        for material in &materials {
            output::json(material)?;
        }
        for cause in &score.causes() {
            output::json(cause)?;
        }
        return output::json(&total);
    }
    if args.detectors.len() > 1 {
        output::line(&format!("\ndetector: {}", total.detector))?;
    } else {
        recording_table(&score.recordings)?;
    }
    if !materials.is_empty() {
        output::line("")?;
        let steady = ["latency_ms", "steady", "steady_missed", "steady_ms"];
        let onsets = ["material", "onsets", "missed", "inside", "early"];
        table::print(&materials, &[&onsets[..], &steady].concat())?;
    }
    summary(&total)?;
    cause_table(&score.causes())
}

/// Time in which nothing slipped (s), of it in alarm (s), and the alarms in it, over all causes.
pub(super) fn without_slip(score: &Score) -> [f64; 3] {
    score.causes().iter().fold([0.0; 3], |[seconds, in_alarm_s, alarms], cause| {
        [seconds + cause.seconds, in_alarm_s + cause.in_alarm_s, alarms + f64::from(cause.alarms)]
    })
}

/// A detector beside the others.
#[derive(Serialize)]
struct Beside {
    #[serde(flatten)]
    total: Total,
    /// In time in which nothing slipped.
    alarms: f64,
    per_minute: Option<f64>,
    without_slip: [f64; 2],
}

/// A row for each detector.
fn beside<'a>(scores: impl Iterator<Item = &'a Score>, guard_ms: f64) -> anyhow::Result<()> {
    let row = |score: &Score| {
        let [seconds, in_alarm_s, alarms] = without_slip(score);
        let per_minute = (seconds > 0.0).then(|| 60.0 * alarms / seconds);
        let total = score.total(guard_ms);
        Beside { total, alarms, per_minute, without_slip: [seconds, in_alarm_s] }
    };
    output::line("\nlatency: median / 95 %; without slip: seconds / of these in alarm")?;
    let columns = ["detector", "onsets", "missed", "inside", "early", "latency ms=latency_ms"];
    let without_slip = ["without_slip", "alarms", "per_minute"];
    table::print(&scores.map(row).collect::<Vec<_>>(), &[&columns[..], &without_slip].concat())
}

/// The false alarms of each cause, where there is more than one.
fn cause_table(causes: &[CauseScore]) -> anyhow::Result<()> {
    if causes.is_empty() {
        return Ok(());
    }
    output::line("\nwithout slip")?;
    table::print(
        causes,
        &["cause", "seconds", "in alarm s=in_alarm_s", "alarms", "per hour (95 %)=per_hour_ci"],
    )?;
    if causes.iter().any(|c| c.cause == UNKNOWN) {
        output::line(
            "motion not known: the arm may have moved in it; a column `motion` (0 or 1) or a reference tells",
        )?;
    }
    Ok(())
}

/// What chance would find, where that can be compared.
fn by_chance(chance: Option<Chance>) -> anyhow::Result<()> {
    let Some(Chance { found, p }) = chance else { return Ok(()) };
    let below = if p > Chance::LEAST_P { "" } else { "below " };
    Ok(output::line(&format!(
        "  as many alarms at random would find {found:.1} (so many as were found, or more: p {below}{p:.2e})"
    ))?)
}

/// `low to high`, or a dash.
fn span(interval: Interval, scale: f64, digits: usize) -> String {
    interval.map_or_else(
        || "-".to_owned(),
        |[low, high]| format!("{:.digits$} to {:.digits$}", scale * low, scale * high),
    )
}

fn recording_table(recordings: &[RecordingScore]) -> anyhow::Result<()> {
    let times = ["onset_s", "alarm_s", "latency_ms", "travel_mm", "missed", "early", "inside"];
    table::print(recordings, &[&["recording", "slip", "kind", "material"][..], &times].concat())
}

/// Recordings of several rates or units, whose rest is not that of the others.
fn kins(total: &Total) -> Option<String> {
    let digits = |rate: f32| if rate < 100.0 { 1 } else { 0 };
    let written = |rate: &f32| format!("{rate:.*}", digits(*rate));
    let rates: Vec<String> = total.rates_hz.iter().map(written).collect();
    let own = match total.own_floors {
        0 => String::new(),
        1 => "; 1 recording has none alike of another material, and learns it by itself".to_owned(),
        n => format!(
            "; {n} recordings have none alike of another material, and learn it by themselves"
        ),
    };
    (rates.len() > 1).then(|| {
        let (count, rates) = (rates.len(), rates.join(", "));
        format!("{count} rates or units ({rates} Hz), each with floors of its own{own}")
    })
}

fn summary(total: &Total) -> anyhow::Result<()> {
    output::line("")?;
    if let Some(kins) = kins(total) {
        output::line(&kins)?;
    }
    if total.onsets > 0 {
        output::line(&format!(
            "onsets: {}, {} missed, {} inside a running alarm, {} early (before onset - {} ms); latency median {} ms, 95 % {} ms; travel at the alarm median {} mm, 95 % {} mm",
            total.onsets,
            total.missed,
            total.inside,
            total.early,
            total.guard_ms,
            or_dash(total.latency_ms.p50, 1),
            or_dash(total.latency_ms.p95, 1),
            or_dash(total.travel_mm.p50, 3),
            or_dash(total.travel_mm.p95, 3),
        ))?;
        output::line(&format!(
            "  95 % intervals: missed {} %, early {} %; latency median {} ms, 95 % {} ms",
            span(total.missed_ci, 100.0, 1),
            span(total.early_ci, 100.0, 1),
            span(total.latency_ms_ci.p50, 1.0, 1),
            span(total.latency_ms_ci.p95, 1.0, 1),
        ))?;
        by_chance(total.onsets_chance)?;
    }
    if total.steady > 0 {
        output::line(&format!(
            "steady: {} recordings, {} without alarm; first alarm after median {} ms, 95 % {} ms",
            total.steady,
            total.steady_missed,
            or_dash(total.steady_ms.p50, 1),
            or_dash(total.steady_ms.p95, 1),
        ))?;
        output::line(&format!(
            "  a slip, or that no rest was seen, is reported for at least {} % of the time of each",
            or_dash(total.steady_share.map(|share| 100.0 * share), 0)
        ))?;
        by_chance(total.steady_chance)?;
    }
    if let Some(share) = total.in_alarm_share {
        output::line(&format!(
            "in alarm: {:.1} s, {:.0} % of all time",
            total.in_alarm_s,
            100.0 * share
        ))?;
    }
    if let Some(ns) = total.ns_per_sample {
        output::line(&format!(
            "run time: {ns:.0} ns a sample, in the recording where it is shortest"
        ))?;
    }
    if total.rest_s > 0.0 {
        output::line(&format!(
            "rest: {:.1} s, {} false alarms ({} per hour), {:.1} s of it in alarm",
            total.rest_s,
            total.rest_alarms,
            span(total.rest_alarms_per_hour_ci, 1.0, 2),
            total.rest_in_alarm_s,
        ))?;
    }
    Ok(())
}
