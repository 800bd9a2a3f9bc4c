//! `gripctl replay`: a recording through the pipeline.

use super::{
    calibrated_config, csv_options, estimator, replay_plot::Picture, replay_tape, source::Source,
};
use crate::{cli::ReplayArgs, output};
use anyhow::Context as _;
use grip_record::{
    ChannelSet, StylusKind,
    outputs::{OutputError, OutputPath},
    shell,
};
use grip_session::{
    exit::{self, Exit, WrongArgument, escape},
    replay,
    report::EventLog,
    steady::{STEADY, SteadyAlarm},
};
use serde::Serialize;
use slip_core::{Pipeline, PipelineConfig, units::Micros};
use std::path::{Path, PathBuf};

/// Samples between two looks of the bar.
const SAMPLES_A_LOOK: u64 = 1 << 12;

#[derive(Serialize)]
#[serde(tag = "type", rename = "summary")]
struct Summary {
    file: String,
    samples: u64,
    lost: u64,
    slips: u64,
    duration_s: f64,
    unusable: u64,
    /// Wrong readings that leapt out of a quiet stretch and back, and were replaced.
    isolated: u64,
    /// Times a quieter second has lowered the floor: it had been learned in motion.
    floor_lowered: u64,
    /// Alarms with the steady level of a machine.
    steady_alarms: u64,
    /// Whether the noise floor was still being learned at the end: a stylus shows no slip before.
    learning: bool,
}

/// Why no plot is made, and what makes the page that a name asks for.
fn refusal(error: OutputError, args: &ReplayArgs) -> anyhow::Error {
    let is_page = |file: &&PathBuf| file.extension().is_some_and(|ending| ending == "html");
    match args.files.iter().zip(args.plot.as_ref().filter(is_page)).next() {
        Some((recording, file)) => {
            let [recording, file] =
                [recording, file].map(|name| shell(&name.display().to_string()));
            let way = format!("`gripmon {recording} --report {file}` writes a page");
            WrongArgument(format!("{error}; {way}")).into()
        }
        None => error.into(),
    }
}

pub(crate) fn run(args: &ReplayArgs) -> anyhow::Result<Exit> {
    let more = [&args.calibration, &args.config, &args.model].map(Option::as_deref);
    let inputs: Vec<_> = args.files.iter().map(|file| Some(file.as_path())).chain(more).collect();
    let plot = output::optional(args.plot.as_deref(), output::PICTURE, &args.force, &inputs);
    let plot = plot.map_err(|error| refusal(error, args))?;
    let tapes = args.files.iter().filter(|file| is_mcap(file)).count();
    match args.files.as_slice() {
        files if tapes == files.len() => replay_tape::run(args, plot.as_ref()),
        [file] if args.check => Err(WrongArgument(format!(
            "--check: {} has no events to compare with; only .mcap has",
            file.display()
        ))
        .into()),
        [file] => table(args, file, plot.as_ref()),
        files if tapes == 0 && !args.check && plot.is_none() => tables(args, files),
        _ => Err(WrongArgument(
            "several files: only .mcap files of one recording are replayed together, others one after the other without --check and --plot".to_owned(),
        )
        .into()),
    }
}

/// Lists of a labelled folder, which a pattern for its recordings takes along.
const LISTS: [&str; 3] = ["labels.csv", "phases.csv", "alarms.csv"];

/// Recordings one after the other, each under its name. One that cannot be used stops none of the others.
fn tables(args: &ReplayArgs, files: &[PathBuf]) -> anyhow::Result<Exit> {
    let mut exit = Exit::Done;
    let is_list = |file: &&PathBuf| {
        file.file_name().is_some_and(|name| LISTS.iter().any(|list| name == *list))
    };
    for file in files {
        if is_list(&file) {
            output::remark(file.display(), "a list of its folder, not replayed");
            continue;
        }
        if !args.json {
            output::line(&escape(&file.display().to_string()))?;
        }
        match table(args, file, None) {
            Err(error) if Exit::of(error.as_ref()) == Exit::Failed => return Err(error),
            Err(error) => {
                output::note(&format!("gripctl: {}", exit::message(error.as_ref())));
                exit = Exit::WrongArguments;
            }
            Ok(Exit::DataLost) if exit == Exit::Done => exit = Exit::DataLost,
            Ok(_) => {}
        }
    }
    Ok(exit)
}

/// Whether the name states that it is a recording of everything.
pub(super) fn is_mcap(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"))
}

/// A recording that is no MCAP.
fn table(args: &ReplayArgs, file: &Path, plot: Option<&OutputPath>) -> anyhow::Result<Exit> {
    let mut config = calibrated_config(args.config.as_deref(), args.calibration.as_deref())?;
    config.observation.esc = args.esc.unwrap_or(config.observation.esc);
    let estimator = estimator(args.model.as_deref(), &config)?;
    let source = Source::open(file, &csv_options(&args.csv)?)?;
    let recording = &source.recording;
    let notes = recording.notes.to_string();
    if !notes.is_empty() {
        output::note(&format!("{}: {notes}", escape(&file.to_string_lossy())));
    }
    if let Some(limits) = replay::limits(recording.channels.stylus, recording.channels.taxels) {
        output::remark(file.display(), limits);
    }
    let pipeline = replay::pipeline_config(recording, &config, args.observe);
    let vibration = recording.channels.stylus == StylusKind::Vibration;
    config.check_signal(pipeline.sample_rate, vibration)?;
    if let Some(made) = config.stylus_calibration().filter(|made| made.certificate.is_none()) {
        eprintln!(
            "gripctl: the calibration has no certified false-alarm interval, so no slip is certified; it stands on {:.0} s of stillness and {:.0} s of motion: record 120 s or more without slip, then type `gripctl calibrate LONGER.csv -o cal.toml`, which prints why where it makes none",
            made.evidence.rest_s, made.evidence.motion_s
        );
    }
    let pipeline = PipelineConfig { no_skip: args.no_skip, ..pipeline };
    let (mut log, mut steady, mut steady_alarms) = (EventLog::default(), SteadyAlarm::default(), 0);
    let mut replay =
        Pipeline::new(pipeline, Some(estimator)).with_context(|| file.display().to_string())?;
    let mut span: Option<[Micros; 2]> = None;
    let mut picture = args.plot.as_ref().map(|_| Picture::default());
    let bar = output::progress(source.count, "samples");
    source.each(|sample, taxels| {
        span = Some([span.map_or(sample.t, |[first, _]| first), sample.t]);
        let step = replay.handle_with(sample, taxels);
        if let Some(picture) = &mut picture {
            picture.take(sample, &step);
        }
        if steady.step(&step, replay.detector()) {
            steady_alarms += 1;
            let note = format!("{:.4} s: {STEADY}", step.t.as_seconds());
            bar.suspend(|| output::remark(file.display(), note));
        }
        let taken = replay.stage_counters().samples;
        if taken % SAMPLES_A_LOOK == 0 {
            bar.set_position(taken);
        }
        for line in log.events(&step).into_iter().flatten() {
            bar.suspend(|| match args.json {
                true => output::json(&line),
                false => Ok(output::line(&line.to_string())?),
            })?;
        }
        Ok(())
    })?;
    bar.finish_and_clear();
    if let Some((picture, plot)) = picture.zip(plot) {
        let signal = signal(&recording.channels);
        output::draw(&picture.chart(&recording.name, signal.as_deref()), plot)?;
    }
    let health = replay.health_counters();
    let duration_s = span.map_or(0.0, |[first, last]| last.as_seconds() - first.as_seconds());
    let summary = Summary {
        file: file.display().to_string(),
        samples: replay.stage_counters().samples,
        lost: u64::try_from(recording.notes.gaps)?,
        slips: log.slips(),
        duration_s,
        unusable: health.unusable(),
        isolated: health.isolated,
        floor_lowered: replay.stage_counters().floor_lowered,
        steady_alarms,
        learning: replay.is_learning(),
    };
    if summary.learning {
        output::remark(file.display(), replay::LEARNING);
    }
    if let Some(forces) = replay::forces(&health) {
        output::remark(file.display(), forces);
    }
    report(&summary, recording.rate_hz, args.json)?;
    Ok(if summary.lost > 0 || recording.notes.cut { Exit::DataLost } else { Exit::Done })
}

/// What the picture shows of the sensor, with its unit.
fn signal(channels: &ChannelSet) -> Option<String> {
    match (channels.stylus, channels.axes.as_slice()) {
        (StylusKind::Displacement, _) => Some("stylus (m)".to_owned()),
        (StylusKind::Vibration, [first, rest @ ..]) if !rest.is_empty() => {
            Some(format!("{first} of {} axes (own unit)", rest.len() + 1))
        }
        (StylusKind::Vibration, _) => Some("vibration (own unit)".to_owned()),
        (StylusKind::Absent, _) => None,
    }
}

/// The last line.
fn report(summary: &Summary, rate_hz: f32, json: bool) -> anyhow::Result<()> {
    if json {
        output::json(summary)?;
    } else {
        output::line(&format!(
            "{} samples in {:.3} s at {:.1} Hz, {} gaps, {} unusable readings, {} isolated, {} slips, floor lowered {} times",
            summary.samples,
            summary.duration_s,
            rate_hz,
            summary.lost,
            summary.unusable,
            summary.isolated,
            summary.slips,
            summary.floor_lowered
        ))?;
    }
    Ok(())
}
