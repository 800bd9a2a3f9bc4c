//! Replay of MCAP recordings: the events that the pipeline makes of them, beside those that were recorded.

use crate::{
    model::{HostEstimator, ModelError, default_estimator, parse_estimator},
    recording::{ABOUT, MODEL_NAME, PART, RUN, UNRECORDED, beginning},
    report::{ClockHealth, Condition, Event, EventLog},
    session::Beginning,
    steady::{STEADY, SteadyAlarm},
};
use grip_record::mcap::{Entry, EventRecord, McapError, McapReader, PipelineRecord, Record};
use serde::Deserialize;
use slip_core::{
    ClientCommand, ConfigError, Pipeline, Sample, Step, esc::Reading, grip::GripState,
    units::Micros,
};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

/// How a replay differs from the run that was recorded.
#[derive(Clone, Debug, Default)]
pub struct TapeOptions {
    /// Another model than the recorded one.
    pub estimator: Option<HostEstimator>,
    /// Runs every stage in every scene.
    pub no_skip: bool,
    /// Without the force controller.
    pub observe: bool,
    /// Another reading of E_sc beside the literal one.
    pub esc: Option<Reading>,
}

/// What a replay comes across.
#[derive(Debug)]
pub enum Played<'a> {
    /// The pipeline reports it now.
    Line(&'a Event),
    /// The recording reports it: the line as JSON.
    Recorded(&'a str),
    /// Something a person should know of the recording.
    Note(String),
    /// A pipeline begins; the one before it has ended.
    Began,
    /// A sample, and what it led to.
    Step {
        /// The sample.
        sample: &'a Sample,
        /// What the pipeline made of it.
        step: &'a Step,
        /// What the force controller does after it; `None` where there is none.
        grip: Option<GripState>,
    },
    /// Names and values under a title.
    Metadata {
        /// The title.
        name: &'a str,
        /// The values.
        values: &'a BTreeMap<String, String>,
    },
    /// A file inside the recording.
    Attached {
        /// Its name.
        name: &'a str,
        /// Its bytes.
        data: &'a [u8],
    },
}

/// Why a recording cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum TapeError {
    /// The file cannot be read, or not to its end.
    #[error(transparent)]
    Mcap(#[from] McapError),
    /// The settings in it are no settings of this version.
    #[error("{}: the settings of its pipeline are not those of this version: {source}", file.display())]
    Settings {
        /// The file.
        file: PathBuf,
        /// What does not fit.
        source: serde_json::Error,
    },
    /// The settings in it are refused.
    #[error("{}: the settings of its pipeline: {source}", file.display())]
    Pipeline {
        /// The file.
        file: PathBuf,
        /// What is refused.
        source: ConfigError,
    },
    /// The model in it cannot be used.
    #[error("{}: the model inside: {source}", file.display())]
    Model {
        /// The file.
        file: PathBuf,
        /// Why.
        source: ModelError,
    },
    /// There is something in it that cannot be used here.
    #[error("{}: {what}", file.display())]
    Unusable {
        /// The file.
        file: PathBuf,
        /// What it is.
        what: &'static str,
    },
    /// Files that do not follow each other.
    #[error(
        "{}: does not go on where {} ends; give the files of one recording in their order",
        file.display(), before.display()
    )]
    Order {
        /// The file.
        file: PathBuf,
        /// The one before it.
        before: PathBuf,
    },
}

/// What a replay has seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TapeSummary {
    /// Samples handled.
    pub samples: u64,
    /// Rows that are missing between the samples, by their numbers.
    pub lost: u64,
    /// Slips noticed.
    pub slips: u64,
    /// Device time between the first and the last sample of each pipeline, added up (s).
    pub duration_s: f64,
    /// Unusable readings.
    pub unusable: u64,
    /// Isolated wrong readings that were replaced.
    pub isolated: u64,
    /// Times a quieter second has lowered the floor.
    pub floor_lowered: u64,
    /// Alarms with the steady level of a machine.
    pub steady_alarms: u64,
    /// Pipelines that began.
    pub pipelines: u64,
    /// Whether the first file starts in the middle of a run, so that the first events may differ.
    pub mid_run: bool,
    /// Items that the recorder did not get, or could not write.
    pub unrecorded: u64,
    /// Whether no pipeline has learned its noise floor: a stylus shows no slip before.
    pub learning: bool,
}

/// A recording of one or more files on its way through the pipeline.
#[derive(Debug, Default)]
pub struct Tape {
    options: TapeOptions,
    model: Option<HostEstimator>,
    pipeline: Option<Run>,
    log: EventLog,
    steady: SteadyAlarm,
    summary: TapeSummary,
    /// Whether a pipeline that has ended knew its noise floor.
    learned: bool,
    before: Option<(PathBuf, About)>,
}

/// One pipeline and its samples.
#[derive(Debug)]
struct Run {
    /// As it was recorded.
    begun: Beginning,
    pipeline: Pipeline<Arc<[f32]>>,
    first: Option<Micros>,
    last: Micros,
    index: u32,
}

/// What a file states of itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct About {
    run: String,
    part: u64,
}

#[derive(Deserialize)]
struct Unrecorded {
    items: u64,
}

impl Tape {
    /// A replay that has seen nothing yet.
    #[must_use]
    pub fn new(options: TapeOptions) -> Self {
        Self { options, ..Self::default() }
    }

    /// Plays `file`, which goes on where the one before it ended, and reports what happens.
    ///
    /// # Errors
    /// Where it cannot be read (to its end), is no recording of gripd, or does not follow the one before. What came before the
    /// fault has been reported, and [`Tape::summary`] counts it.
    pub fn play(
        &mut self,
        file: &Path,
        report: &mut dyn FnMut(Played<'_>),
    ) -> Result<(), TapeError> {
        let mut reader = McapReader::open(file)?.read_ahead()?;
        let mut place = Place { file, report };
        while let Some(entry) = reader.next_entry()? {
            match entry {
                Entry::Message { record, .. } => self.record(&mut place, &record)?,
                Entry::Attachment { name, data, .. } => {
                    if name == MODEL_NAME {
                        self.model = Some(model(file, &data)?);
                    }
                    (place.report)(Played::Attached { name: &name, data: &data });
                }
                Entry::Metadata { name, values } => {
                    if name == ABOUT {
                        self.follow(file, &values)?;
                    }
                    (place.report)(Played::Metadata { name: &name, values: &values });
                }
            }
        }
        Ok(())
    }

    /// What was seen so far.
    #[must_use]
    pub fn summary(&self) -> TapeSummary {
        let mut summary = self.summary;
        if let Some(run) = &self.pipeline {
            run.count(&mut summary);
        }
        let learns = self.pipeline.as_ref().is_some_and(|run| run.pipeline.is_learning());
        TapeSummary { slips: self.log.slips(), learning: learns && !self.learned, ..summary }
    }

    /// Checks that a file goes on where the one before it ended.
    fn follow(&mut self, file: &Path, values: &BTreeMap<String, String>) -> Result<(), TapeError> {
        let text = |name: &str| values.get(name).cloned().unwrap_or_default();
        let about = About { run: text(RUN), part: text(PART).parse().unwrap_or(0) };
        if let Some((before, last)) = &self.before
            && (last.run != about.run || last.part + 1 != about.part)
        {
            return Err(TapeError::Order { file: file.to_owned(), before: before.clone() });
        }
        self.before = Some((file.to_owned(), about));
        Ok(())
    }

    fn record(&mut self, place: &mut Place<'_>, record: &Record<'_>) -> Result<(), TapeError> {
        match record {
            Record::Pipeline(beginning) => self.begin(place, beginning)?,
            Record::Sample(sample) => {
                let (index, taxels) = (sample.index, sample.taxels);
                self.sample(index, &sample.sample, taxels, place.report);
            }
            Record::Client(command) => self.client(*command),
            Record::Event(event) => {
                // The clock of the device is judged by the link: its lines come from the recording.
                if let Some(line) = clock_line(event) {
                    (place.report)(Played::Line(&line));
                }
                (place.report)(Played::Recorded(event.json));
            }
            Record::Link(link) if link.kind == UNRECORDED => {
                let items = serde_json::from_str::<Unrecorded>(link.detail).map_or(1, |u| u.items);
                self.summary.unrecorded += items;
                let text = format!("{items} items were not recorded here");
                (place.report)(Played::Note(text));
            }
            Record::State(_) | Record::Command(_) | Record::Link(_) | Record::Wire(_) => {}
        }
        Ok(())
    }

    /// A pipeline begins, or goes on in the next file. One that began while nothing was recorded begins in the middle too.
    fn begin(
        &mut self,
        place: &mut Place<'_>,
        record: &PipelineRecord<'_>,
    ) -> Result<(), TapeError> {
        let file = place.file;
        let begun = beginning(record)
            .map_err(|source| TapeError::Settings { file: file.to_owned(), source })?;
        if record.continued && self.pipeline.as_ref().is_some_and(|run| run.begun == begun) {
            return Ok(());
        }
        if record.continued {
            self.summary.mid_run = true;
            (place.report)(Played::Note(
                "starts in the middle of a run: without the files before it the first events may differ".to_owned(),
            ));
        }
        let mut changed = begun;
        let config = &mut changed.config;
        config.no_skip |= self.options.no_skip;
        config.grip = config.grip.filter(|_| !self.options.observe);
        config.observation.esc = self.options.esc.unwrap_or(config.observation.esc);
        let estimator = match (&self.options.estimator, &self.model) {
            (Some(chosen), _) => chosen.clone(),
            (None, Some(recorded)) => recorded.clone(),
            (None, None) => default_estimator()
                .map_err(|source| TapeError::Model { file: file.to_owned(), source })?,
        };
        let pipeline = changed
            .pipeline(estimator)
            .map_err(|source| TapeError::Pipeline { file: file.to_owned(), source })?;
        let run = Run { begun, pipeline, first: None, last: Micros(0), index: 0 };
        if let Some(ended) = self.pipeline.replace(run) {
            ended.count(&mut self.summary);
            self.learned |= !ended.pipeline.is_learning();
        }
        self.summary.pipelines += 1;
        (place.report)(Played::Began);
        Ok(())
    }

    fn sample(
        &mut self,
        index: u32,
        sample: &Sample,
        taxels: &[f32],
        report: &mut dyn FnMut(Played<'_>),
    ) {
        let Some(run) = &mut self.pipeline else { return };
        self.summary.samples += 1;
        let step = index.wrapping_sub(run.index);
        if run.first.is_some() && (2..1 << 31).contains(&step) {
            self.summary.lost += u64::from(step - 1);
        }
        run.first = run.first.or(Some(sample.t));
        (run.last, run.index) = (sample.t, index);
        let step = run.pipeline.handle_with(sample, taxels);
        if self.log.follows(&step) {
            for line in self.log.events(&step).into_iter().flatten() {
                report(Played::Line(&line));
            }
        }
        if self.steady.step(&step, run.pipeline.detector()) {
            self.summary.steady_alarms += 1;
            report(Played::Note(format!("{:.4} s: {STEADY}", step.t.as_seconds())));
        }
        let grip = run.pipeline.grip_state();
        report(Played::Step { sample, step: &step, grip });
    }

    /// A client's command acts on the pipeline here, between the same samples as it did live. What went to the gripper itself shows
    /// in its samples.
    fn client(&mut self, command: ClientCommand) {
        if let Some(run) = &mut self.pipeline {
            run.pipeline.obey(command);
        }
    }
}

struct Place<'a> {
    file: &'a Path,
    report: &'a mut dyn FnMut(Played<'_>),
}

impl Run {
    fn count(&self, summary: &mut TapeSummary) {
        let health = self.pipeline.health_counters();
        summary.unusable += health.unusable();
        summary.isolated += health.isolated;
        summary.floor_lowered += self.pipeline.stage_counters().floor_lowered;
        summary.duration_s += self.first.map_or(0.0, |first| self.last.since(first).as_seconds());
    }
}

fn model(file: &Path, data: &[u8]) -> Result<HostEstimator, TapeError> {
    parse_estimator(MODEL_NAME, &String::from_utf8_lossy(data))
        .map_err(|source| TapeError::Model { file: file.to_owned(), source })
}
/// The line on the device's clock that `event` is, if it is one.
fn clock_line(event: &EventRecord<'_>) -> Option<Event> {
    let health = ClockHealth::ALL.into_iter().find(|health| health.name() == event.health)?;
    let t = Micros::from_seconds(event.t_s);
    let line = Event::Health { t, condition: Condition::Clock(health) };
    (event.kind == "health" && event.channel == "clock").then_some(line)
}
