//! Reader of recordings: the rows of all of them, with a count of what was left out and why.

use super::{
    files::{CollectError, Recorded, find},
    origin::{Origin, UNKNOWN},
    row::Row,
    watch::{Fate, MeasuredSlip, SlipWatch, WatchConfig},
};
use grip_record::{CsvOptions, Label, StylusKind, mcap::McapError, read_labels, read_recording};
use grip_session::{
    config::HostConfig,
    exit::message,
    model::default_estimator,
    recording::UNRECORDED,
    replay::{self, Replay},
    tape::{Played, Tape, TapeError, TapeOptions},
};
use slip_core::estimate::Feature;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// What to collect.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// Files and folders.
    pub places: &'a [PathBuf],
    /// Files that are none of them, such as the one to be written.
    pub without: &'a [PathBuf],
    /// What was held in all of them, whatever they report.
    pub object: Option<&'a str>,
    /// Which slips.
    pub watch: WatchConfig,
    /// Features that each row must have.
    pub require: &'a [Feature],
    /// How the columns of CSV recordings are read.
    pub csv: &'a CsvOptions,
    /// Settings for CSV recordings, which have none inside.
    pub config: &'a HostConfig,
}

/// What was found.
#[derive(Clone, Debug, Default)]
pub struct Collected {
    /// The rows, in the order of the recordings and of time.
    pub rows: Vec<Row>,
    /// Slips by what became of them.
    pub fates: BTreeMap<Fate, u64>,
    /// Recordings that were read.
    pub recordings: u64,
    /// Files that were found and cannot be read as recordings.
    pub unusable: u64,
    /// Recordings of which a part is missing.
    pub lossy: u64,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// Reads everything. `done` gets, before each recording, how many are read, and of how many.
///
/// # Errors
/// [`CollectError`], where a file that was named is no recording. One that was only found is noted and counted.
pub fn collect(
    request: &Request<'_>,
    done: &dyn Fn(usize, usize),
) -> Result<Collected, CollectError> {
    let mut collected = Collected::default();
    let all = find(request.places, request.without)?;
    for (at, recorded) in all.iter().enumerate() {
        done(at, all.len());
        let read = if recorded.is_mcap() {
            tape(request, recorded, &mut collected)
        } else {
            table(request, recorded, &mut collected)
        };
        match read {
            Ok(()) => collected.recordings += 1,
            Err(error) if recorded.named => return Err(error),
            Err(error) => {
                collected.unusable += 1;
                collected.notes.push(format!("left out: {}", message(&error)));
            }
        }
    }
    Ok(collected)
}

/// One recording on its way.
struct Reading<'a> {
    request: &'a Request<'a>,
    collected: &'a mut Collected,
    origin: Origin,
    file: String,
    watch: SlipWatch,
}

impl<'a> Reading<'a> {
    fn new(
        request: &'a Request<'a>,
        collected: &'a mut Collected,
        file: &Path,
    ) -> Result<Self, CollectError> {
        let mut origin = Origin::of_path(file);
        origin.label(file, &labels(file)?);
        let (file, watch) = (file.display().to_string(), SlipWatch::new(request.watch));
        Ok(Self { request, collected, origin, file, watch })
    }

    fn reported(&mut self, reported: Result<MeasuredSlip, Fate>) {
        let complete = reported.and_then(|slip| {
            let shows = |feature: &Feature| feature.value(&slip.features).is_some();
            if self.request.require.iter().all(shows) { Ok(slip) } else { Err(Fate::Incomplete) }
        });
        let fate = complete.as_ref().err().copied().unwrap_or(Fate::Kept);
        *self.collected.fates.entry(fate).or_default() += 1;
        if let Ok(slip) = complete {
            let known = |name: &Option<String>| name.as_deref().unwrap_or(UNKNOWN).to_owned();
            let (site, gripper) = (known(&self.origin.site), known(&self.origin.gripper));
            let object = self.request.object.or(self.origin.object.as_deref()).unwrap_or(UNKNOWN);
            let (object, recording) = (object.to_owned(), self.file.clone());
            self.collected.rows.push(Row { site, gripper, object, recording, slip });
        }
    }

    fn step(&mut self, sample: &slip_core::Sample, step: &slip_core::Step) {
        let mut reported = Vec::new();
        self.watch.take(sample, step, &mut |slip| reported.push(slip));
        reported.into_iter().for_each(|slip| self.reported(slip));
    }

    fn end(&mut self) {
        let mut reported = Vec::new();
        self.watch.finish(&mut |slip| reported.push(slip));
        reported.into_iter().for_each(|slip| self.reported(slip));
        self.watch = SlipWatch::new(self.request.watch);
    }
}

/// The labels of the folder, where it has any.
fn labels(file: &Path) -> Result<Vec<Label>, CollectError> {
    let folder = file.parent().unwrap_or_else(|| Path::new(""));
    if !folder.join("labels.csv").is_file() {
        return Ok(Vec::new());
    }
    Ok(read_labels(&folder.join("labels.csv"))?)
}

/// The files of one run, through the pipeline that was recorded.
fn tape(
    request: &Request<'_>,
    recorded: &Recorded,
    collected: &mut Collected,
) -> Result<(), CollectError> {
    let Some(first) = recorded.files.first() else { return Ok(()) };
    let mut reading = Reading::new(request, collected, first)?;
    let mut tape = Tape::new(TapeOptions::default());
    let mut cut = false;
    for file in &recorded.files {
        reading.file = file.display().to_string();
        let played = tape.play(file, &mut |played| match played {
            Played::Began => reading.end(),
            Played::Step { sample, step, .. } => reading.step(sample, step),
            Played::Metadata { name, values } => reading.origin.metadata(name, values),
            Played::Attached { name, data } => reading.origin.attachment(name, data),
            Played::Line(_) | Played::Recorded(_) | Played::Note(_) => {}
        });
        match played {
            Err(TapeError::Mcap(
                error @ (McapError::Truncated { .. } | McapError::Damaged { .. }),
            )) if tape.summary().samples > 0 => {
                cut = true;
                reading.collected.notes.push(error.to_string());
            }
            other => other?,
        }
        if cut {
            break;
        }
    }
    reading.end();
    let summary = tape.summary();
    if cut || summary.lost > 0 || summary.unrecorded > 0 {
        collected.lossy += 1;
    }
    if summary.lost > 0 || summary.unrecorded > 0 {
        collected.notes.push(format!(
            "{}: {} rows lost, {} items not recorded ({UNRECORDED})",
            first.display(),
            summary.lost,
            summary.unrecorded
        ));
    }
    Ok(())
}

/// A CSV file or an `.npz`, through the pipeline of the configuration.
fn table(
    request: &Request<'_>,
    recorded: &Recorded,
    collected: &mut Collected,
) -> Result<(), CollectError> {
    let Some(file) = recorded.files.first() else { return Ok(()) };
    let recording = read_recording(file, request.csv)?;
    let config = replay::pipeline_config(&recording, request.config, false);
    let refused = |source| CollectError::Settings { file: file.clone(), source };
    let model = |source| TapeError::Model { file: file.clone(), source };
    let estimator = default_estimator().map_err(model)?;
    let replay = Replay::new(&recording, config, Some(estimator)).map_err(refused)?;
    let mut reading = Reading::new(request, collected, file)?;
    for (sample, step) in recording.samples.iter().zip(replay) {
        reading.step(sample, &step);
    }
    reading.end();
    let remarks = recording.notes.remarks.iter();
    collected.notes.extend(remarks.map(|remark| format!("{}: {remark}", file.display())));
    if recording.notes.gaps > 0 || recording.notes.cut {
        collected.lossy += 1;
    }
    if recording.notes.gaps > 0 {
        let gaps = recording.notes.gaps;
        collected.notes.push(format!("{}: {gaps} gaps", file.display()));
    }
    if recording.channels.stylus == StylusKind::Vibration {
        let text = "a vibration signal: slips are found, but hardly a feature of them";
        collected.notes.push(format!("{}: {text}", file.display()));
    }
    Ok(())
}
