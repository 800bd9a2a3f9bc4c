//! `gripctl replay`: a recording through the pipeline.

use super::{calibrated_config, csv_options, estimator, replay_tape};
use crate::{cli::ReplayArgs, output};
use anyhow::Context as _;
use grip_host::{
    exit::{Exit, WrongArgument},
    replay,
    report::EventLog,
};
use grip_record::{StylusKind, read_recording};
use serde::Serialize;
use slip_core::PipelineConfig;
use std::path::Path;

#[derive(Serialize)]
#[serde(tag = "type", rename = "summary")]
struct Summary {
    samples: u64,
    lost: u64,
    slips: u64,
    duration_s: f64,
    unusable: u64,
    /// Times a quieter second has lowered the floor: it had been learned in motion.
    floor_lowered: u64,
}

pub(crate) fn run(args: &ReplayArgs) -> anyhow::Result<Exit> {
    let tapes = args.files.iter().filter(|file| is_mcap(file)).count();
    match args.files.as_slice() {
        files if tapes == files.len() => replay_tape::run(args),
        [file] if args.check => Err(WrongArgument(format!(
            "--check: {} has no events to compare with; only .mcap has",
            file.display()
        ))
        .into()),
        [file] => table(args, file),
        _ => Err(WrongArgument(
            "several files: only .mcap files of one recording can be replayed together".to_owned(),
        )
        .into()),
    }
}

/// Whether the name says that it is a recording of everything.
pub(super) fn is_mcap(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"))
}

/// What a recording of such signals cannot tell.
const fn limits_of(stylus: StylusKind) -> Option<&'static str> {
    match stylus {
        StylusKind::Displacement => None,
        StylusKind::Vibration => Some(
            "a vibration signal (signed or rectified): slips are found, heights and E_sc are not known",
        ),
        StylusKind::Absent => {
            Some("no stylus: slips are found by taxels and travel, heights and E_sc are not known")
        }
    }
}

/// A CSV or `.npz` recording.
fn table(args: &ReplayArgs, file: &Path) -> anyhow::Result<Exit> {
    let mut config = calibrated_config(args.config.as_deref(), args.calibration.as_deref())?;
    config.observation.esc = args.esc.unwrap_or(config.observation.esc);
    let estimator = estimator(args.model.as_deref(), &config)?;
    let recording = read_recording(file, &csv_options(&args.csv)?)?;
    let notes = recording.notes.to_string();
    if !notes.is_empty() {
        eprintln!("{}: {notes}", file.display());
    }
    if let Some(limits) = limits_of(recording.channels.stylus) {
        eprintln!("{}: {limits}", file.display());
    }
    let pipeline = replay::pipeline_config(&recording, &config, args.observe);
    let vibration = recording.channels.stylus == StylusKind::Vibration;
    config.check_signal(pipeline.sample_rate, vibration)?;
    if config.calibrated.is_some_and(|calibration| calibration.certificate.is_none()) {
        eprintln!(
            "gripctl: the calibration has no certified false-alarm interval, so no slip is certified; `gripctl calibrate` of this version makes one"
        );
    }
    let pipeline = PipelineConfig { no_skip: args.no_skip, ..pipeline };
    let mut log = EventLog::default();
    let mut replay = replay::Replay::new(&recording, pipeline, Some(estimator))
        .with_context(|| file.display().to_string())?;
    for step in &mut replay {
        for line in log.lines(&step).into_iter().flatten() {
            if args.json {
                output::json(&line)?;
            } else {
                output::line(&line.to_string())?;
            }
        }
    }
    let health = replay.health_counters();
    let first = recording.samples.first().map_or(0.0, |s| s.t.as_seconds());
    let last = recording.samples.last().map_or(0.0, |s| s.t.as_seconds());
    let summary = Summary {
        samples: replay.stage_counters().samples,
        lost: u64::try_from(recording.notes.gaps)?,
        slips: log.slips(),
        duration_s: last - first,
        unusable: health.unusable(),
        floor_lowered: replay.stage_counters().floor_lowered,
    };
    if args.json {
        output::json(&summary)?;
    } else {
        output::line(&format!(
            "{} samples in {:.3} s at {:.1} Hz, {} gaps, {} unusable readings, {} slips, floor lowered {} times",
            summary.samples,
            summary.duration_s,
            recording.rate_hz,
            summary.lost,
            summary.unusable,
            summary.slips,
            summary.floor_lowered
        ))?;
    }
    Ok(if summary.lost > 0 { Exit::DataLost } else { Exit::Done })
}
