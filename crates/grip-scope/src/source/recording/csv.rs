//! Reader of a table as a source: its samples, and what a pipeline makes of them, as they are read.

use super::{Stop, deliver};
use crate::feed::{EventMark, Feed, ObserverSettings, StylusInfo};
use crate::source::outlet::Outlet;
use crate::source::stream::Stream;

use grip_session::model::default_estimator;
use grip_session::replay::pipeline_config;
use grip_session::report::EventLog;
use grip_session::{HostConfig, report::Event};

use grip_link::message::Unit;
use grip_record::{CsvError, CsvOptions, CsvSamples, Recording, StylusKind, files, shell};
use slip_core::PipelineState;

use core::cell::Cell;
use slip_core::Sample;
use std::{io::Read, path::Path, rc::Rc};

/// States come at most this often (us), and on change.
const STATE_US: u64 = 10_000;

/// Reads the recording to its end, or to its first fault.
pub(super) fn read(file: &Path, outlet: &mut Outlet) -> Result<(), Stop> {
    let failed = |error: CsvError| Stop::Failed(sentence(file, &error));
    let (read, len) = (Rc::new(Cell::new(0)), Cell::new(0));
    let input = || {
        let input = files::open(file)?;
        len.set(input.metadata()?.len());
        read.set(0);
        Ok(Counted { input, read: Rc::clone(&read) })
    };
    let options = CsvOptions::default();
    // As `gripctl replay` reads it. Of a file with a fault, what comes before the fault is shown.
    let surveyed = CsvSamples::surveyed(file, &options).ok();
    let pace = surveyed.as_ref().and_then(|(_, _, pace)| *pace);
    let mut samples = CsvSamples::of(file, input, &options, pace).map_err(failed)?;
    let about = surveyed.map_or_else(|| samples.about(), |(about, ..)| Ok(about));
    let mut tape = Tape::default();
    tape.begin(&about.map_err(failed)?, outlet)?;
    loop {
        match samples.next_sample() {
            Ok(Some((sample, taxels))) => {
                tape.push(&sample, taxels);
                deliver(outlet, tape.stream.whole(), (read.get(), len.get()))?;
            }
            Ok(None) => break,
            Err(error) => {
                deliver(outlet, tape.stream.take(), (1, 1))?;
                let (rows, error) = (tape.rows, sentence(file, &error));
                return Err(match rows {
                    0 => Stop::Failed(error),
                    _ => Stop::Short(format!("only the first {rows} rows can be used; {error}")),
                });
            }
        }
    }
    deliver(outlet, tape.stream.take(), (1, 1))?;
    match samples.losses() {
        _ if tape.rows == 0 => Err(failed(CsvError::NoRows { file: file.to_owned() })),
        [] => Ok(()),
        [first, ..] => Err(Stop::Short(first.to_string())),
    }
}

/// Counts what is read.
struct Counted<R> {
    input: R,
    read: Rc<Cell<u64>>,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.input.read(buffer)?;
        self.read.set(self.read.get() + read as u64);
        Ok(read)
    }
}

/// What is wrong with the file; gripmon itself has none of the flags that would help.
fn sentence(file: &Path, error: &CsvError) -> String {
    let text = error.to_string();
    if text.contains("--") {
        return format!(
            "{text}; with that, `gripctl import {} -o run.csv` makes a file that is shown",
            shell(&file.display().to_string())
        );
    }
    text
}

/// What was read so far.
#[derive(Default)]
struct Tape {
    stream: Stream,
    log: EventLog,
    rows: u64,
    /// The usual step (us), by which gaps are reported.
    step_us: u64,
    last_us: Option<u64>,
    rate_hz: u32,
}

impl Tape {
    /// The pipeline of the shipped settings, and what is odd about the file.
    fn begin(&mut self, recording: &Recording, outlet: &mut Outlet) -> Result<(), Stop> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let (rate_hz, step_us) = (recording.rate_hz as u32, (1e6 / recording.rate_hz) as u64);
        (self.rate_hz, self.step_us) = (rate_hz, step_us.max(1));
        let unit = match recording.channels.stylus {
            StylusKind::Displacement => Unit::Metre,
            StylusKind::Vibration | StylusKind::Absent => Unit::None,
        };
        let axes = recording.channels.axes.clone();
        let config = pipeline_config(recording, &HostConfig::default(), true);
        let none = self.stream.observe(config, default_estimator());
        let settings = none.unwrap_or(Feed::Observes(ObserverSettings::Shipped));
        let mut feeds = vec![Feed::Stylus(StylusInfo { unit, axes }), settings];
        let notes = &recording.notes;
        let ignored = (!notes.ignored_columns.is_empty())
            .then(|| format!("columns that are not shown: {}", notes.ignored_columns.join(", ")));
        let remarks = ignored.into_iter().chain(notes.remarks.iter().cloned());
        feeds.extend(remarks.map(Feed::Notice));
        deliver(outlet, feeds, (0, 1))
    }

    fn push(&mut self, sample: &Sample, taxels: &[f32]) {
        self.rows += 1;
        let since_us = self.last_us.map(|last_us| sample.t.0.saturating_sub(last_us));
        if let Some(since_us) = since_us.filter(|since| 2 * since > 5 * self.step_us) {
            let lost = u32::try_from(since_us / self.step_us).unwrap_or(u32::MAX);
            self.stream.broken(lost.saturating_sub(1));
        }
        self.last_us = Some(sample.t.0);
        let Some(step) = self.stream.push(sample, taxels) else { return };
        let events = self.log.events(&step);
        let (features, estimate) = self.log.evidence();
        let esc = features.and_then(|features| features.esc_chosen);
        let state = step.state(None, esc, estimate);
        let (applied_n, rate_hz) = (sample.normal_force_n, self.rate_hz);
        self.stream.state(PipelineState { applied_n, rate_hz, ..state }, None, STATE_US);
        for event in events.iter().flatten() {
            if let Event::Slip(slip) = event {
                self.stream.mark(EventMark::slip(slip));
            }
        }
    }
}
