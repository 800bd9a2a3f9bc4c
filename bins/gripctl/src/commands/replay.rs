//! `gripctl replay`: a recording through the pipeline.

use super::{
    calibrated_config, csv_options, estimator, import, profile_plot::check_file,
    replay_plot::Picture, replay_tape,
};
use crate::{cli::ReplayArgs, output};
use anyhow::Context as _;
use grip_record::{
    ChannelSet, CsvOptions, CsvSamples, Recording, StylusKind, is_npz, read_recording,
};
use grip_session::{
    exit::{Exit, WrongArgument},
    replay,
    report::EventLog,
};
use serde::Serialize;
use slip_core::{Pipeline, PipelineConfig, Sample, units::Micros};
use std::{fs::File, path::Path};

/// Samples between two looks of the bar.
const SAMPLES_A_LOOK: u64 = 1 << 12;

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
    if let Some(plot) = &args.plot {
        check_file(plot)?;
    }
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

/// Whether the name states that it is a recording of everything.
pub(super) fn is_mcap(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"))
}

/// What a recording of such signals cannot show.
const fn limits_of(channels: &ChannelSet) -> Option<&'static str> {
    match channels.stylus {
        StylusKind::Displacement => None,
        StylusKind::Vibration => Some(
            "a vibration signal (signed or rectified): slips are found, heights and E_sc are not known",
        ),
        StylusKind::Absent if matches!(channels.taxels, 1 | 2) => Some(
            "no stylus, and fewer than 3 taxels, whose distribution shows nothing: slips are found by a travel alone",
        ),
        StylusKind::Absent => {
            Some("no stylus: slips are found by taxels and travel, heights and E_sc are not known")
        }
    }
}

/// Where samples come from.
enum Source {
    /// All of them, of a recording that had to be read whole.
    Held,
    /// A CSV with so many samples, read a second time.
    Read(Box<CsvSamples<File>>, usize),
}

impl Source {
    /// What is known of a recording before its first sample, and its samples. A CSV is read twice, so that one of any
    /// length can be replayed: for its rate and its faults, and then for its samples.
    fn open(file: &Path, csv: &CsvOptions) -> anyhow::Result<(Recording, Self)> {
        if grip_import::is_foreign(file) {
            return Ok((import::shown(file, csv)?, Self::Held));
        }
        if is_npz(file) {
            return Ok((read_recording(file, csv)?, Self::Held));
        }
        let (mut first, mut count) = (CsvSamples::open(file, csv)?, 0);
        while first.next_sample()?.is_some() {
            count += 1;
        }
        let (mut recording, pace) = first.survey()?;
        import::show_uses(file, &recording.notes.uses);
        let mut samples = CsvSamples::open_paced(file, csv, pace)?;
        if pace.is_some() {
            (recording, _) = samples.survey()?;
            samples = CsvSamples::open_paced(file, csv, pace)?;
        }
        Ok((recording, Self::Read(Box::new(samples), count)))
    }

    fn count(&self, recording: &Recording) -> usize {
        match self {
            Self::Held => recording.samples.len(),
            Self::Read(_, count) => *count,
        }
    }

    /// Gives each sample, and the frame of taxels that came with it, to `each`.
    fn run(
        self,
        recording: &Recording,
        mut each: impl FnMut(&Sample, &[f32]) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        match self {
            Self::Held => {
                for (at, sample) in recording.samples.iter().enumerate() {
                    let taxels = recording.taxels.as_ref();
                    each(sample, taxels.map_or(&[] as &[f32], |taxels| taxels.frame(at)))?;
                }
            }
            Self::Read(mut samples, _) => {
                while let Some((sample, frame)) = samples.next_sample()? {
                    each(&sample, frame)?;
                }
            }
        }
        Ok(())
    }
}

/// A recording that is no MCAP.
fn table(args: &ReplayArgs, file: &Path) -> anyhow::Result<Exit> {
    let mut config = calibrated_config(args.config.as_deref(), args.calibration.as_deref())?;
    config.observation.esc = args.esc.unwrap_or(config.observation.esc);
    let estimator = estimator(args.model.as_deref(), &config)?;
    let (recording, source) = Source::open(file, &csv_options(&args.csv)?)?;
    let notes = recording.notes.to_string();
    if !notes.is_empty() {
        eprintln!("{}: {notes}", file.display());
    }
    if let Some(limits) = limits_of(&recording.channels) {
        eprintln!("{}: {limits}", file.display());
    }
    let pipeline = replay::pipeline_config(&recording, &config, args.observe);
    let vibration = recording.channels.stylus == StylusKind::Vibration;
    config.check_signal(pipeline.sample_rate, vibration)?;
    if let Some(made) = config.stylus_calibration().filter(|made| made.certificate.is_none()) {
        eprintln!(
            "gripctl: the calibration has no certified false-alarm interval, so no slip is certified; it stands on {:.0} s of rest and {:.0} s of motion: record 120 s or more without slip, then type `gripctl calibrate LONGER.csv -o cal.toml`, which prints why where it makes none",
            made.evidence.rest_s, made.evidence.motion_s
        );
    }
    let pipeline = PipelineConfig { no_skip: args.no_skip, ..pipeline };
    let mut log = EventLog::default();
    let mut replay =
        Pipeline::new(pipeline, Some(estimator)).with_context(|| file.display().to_string())?;
    let mut span: Option<[Micros; 2]> = None;
    let mut picture = args.plot.as_ref().map(|_| Picture::new());
    let bar = output::progress(source.count(&recording), "samples");
    source.run(&recording, |sample, taxels| {
        span = Some([span.map_or(sample.t, |[first, _]| first), sample.t]);
        let step = replay.handle_with(sample, taxels);
        if let Some(picture) = &mut picture {
            picture.take(&step);
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
    if let Some((picture, plot)) = picture.zip(args.plot.as_ref()) {
        picture.write(&recording.name, plot)?;
    }
    let health = replay.health_counters();
    let duration_s = span.map_or(0.0, |[first, last]| last.as_seconds() - first.as_seconds());
    let summary = Summary {
        samples: replay.stage_counters().samples,
        lost: u64::try_from(recording.notes.gaps)?,
        slips: log.slips(),
        duration_s,
        unusable: health.unusable(),
        floor_lowered: replay.stage_counters().floor_lowered,
    };
    report(&summary, recording.rate_hz, args.json)?;
    let lossy = summary.lost > 0 || recording.notes.cut;
    Ok(if lossy { Exit::DataLost } else { Exit::Done })
}

/// The last line.
fn report(summary: &Summary, rate_hz: f32, json: bool) -> anyhow::Result<()> {
    if json {
        output::json(summary)?;
    } else {
        output::line(&format!(
            "{} samples in {:.3} s at {:.1} Hz, {} gaps, {} unusable readings, {} slips, floor lowered {} times",
            summary.samples,
            summary.duration_s,
            rate_hz,
            summary.lost,
            summary.unusable,
            summary.slips,
            summary.floor_lowered
        ))?;
    }
    Ok(())
}
