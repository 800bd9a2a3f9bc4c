//! Reader of a table as a source: its samples, and what a pipeline makes of them, as they are read.

use super::{Stop, deliver, loading};
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

use core::cell::{Cell, RefCell};
use slip_core::Sample;
use std::io::{self, Read};
use std::path::Path;

/// States come at most this often (us), and on change.
const STATE_US: u64 = 10_000;

/// Reads the recording to its end, or to its first fault.
pub(super) fn read(file: &Path, outlet: &mut Outlet) -> Result<(), Stop> {
    let failed = |error: CsvError| Stop::Failed(sentence(file, &error));
    let progress = Progress { outlet: RefCell::new(outlet), read: Cell::new(0), all: Cell::new(0) };
    let input = || {
        let input = files::open(file)?;
        progress.all.set(READINGS * input.metadata()?.len());
        Ok(Counted { input, progress: &progress })
    };
    let options = CsvOptions::default();
    // As `gripctl replay` reads it. Of a file with a fault, what comes before the fault is shown.
    let surveyed = CsvSamples::survey_of(file, input, &options).ok();
    progress.read.set(progress.all.get() / READINGS * (READINGS - 1));
    let pace = surveyed.as_ref().and_then(|(_, _, pace)| *pace);
    let mut samples = CsvSamples::of(file, input, &options, pace).map_err(failed)?;
    let about = surveyed.map_or_else(|| samples.about(), |(about, ..)| Ok(about));
    let deliver = |feeds| deliver(&mut progress.outlet.borrow_mut(), feeds, progress.done());
    let mut tape = Tape::default();
    deliver(tape.begin(&about.map_err(failed)?))?;
    loop {
        match samples.next_sample() {
            Ok(Some((sample, taxels))) => {
                tape.push(&sample, taxels);
                deliver(tape.stream.whole())?;
            }
            Ok(None) => break,
            Err(error) => {
                deliver(tape.stream.take())?;
                let (rows, error) = (tape.rows, sentence(file, &error));
                return Err(match rows {
                    0 => Stop::Failed(error),
                    _ => Stop::Short(format!("only the first {rows} rows can be used; {error}")),
                });
            }
        }
    }
    deliver(tape.stream.take())?;
    match samples.losses() {
        _ if tape.rows == 0 => Err(failed(CsvError::NoRows { file: file.to_owned() })),
        [] => Ok(()),
        [first, ..] => Err(Stop::Short(first.to_string())),
    }
}

/// How often bytes are read, at most: twice before the first sample.
const READINGS: u64 = 3;

/// How far reading is.
struct Progress<'a> {
    outlet: RefCell<&'a mut Outlet>,
    /// Bytes of all readings so far, of so many.
    read: Cell<u64>,
    all: Cell<u64>,
}

impl Progress<'_> {
    fn done(&self) -> (u64, u64) {
        (self.read.get(), self.all.get())
    }
}

/// Reports what is read, until the scope lets go.
struct Counted<'p, 'o, R> {
    input: R,
    progress: &'p Progress<'o>,
}

impl<R: Read> Read for Counted<'_, '_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let Progress { outlet, read, .. } = self.progress;
        let mut outlet = outlet.borrow_mut();
        if outlet.stops() {
            return Err(io::Error::other("the scope lets go"));
        }
        let count = self.input.read(buffer)?;
        read.set(read.get() + count as u64);
        loading(&mut outlet, self.progress.done());
        Ok(count)
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
    fn begin(&mut self, recording: &Recording) -> Vec<Feed> {
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
        feeds
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

#[cfg(test)]
mod tests {
    use crate::feed::{Feed, SourceStatus};
    use crate::source::outlet::Outlet;
    use core::sync::atomic::{AtomicBool, Ordering};
    use std::sync::{Arc, mpsc};

    /// What comes of a table of 2 MB that `stop` may end.
    fn feeds(stop: impl Fn(&Feed) -> bool + Send + 'static) -> Vec<Feed> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("run.csv");
        let rows: String =
            (0..120_000).map(|i| format!("{}.{:03},0.0000\n", i / 1000, i % 1000)).collect();
        std::fs::write(&file, format!("t_s,stylus\n{rows}")).unwrap();
        let (sender, feeds) = mpsc::channel();
        let stopped = Arc::new(AtomicBool::new(false));
        let stops = Arc::clone(&stopped);
        let take = move |feed: Feed| {
            stops.fetch_or(stop(&feed), Ordering::Relaxed);
            sender.send(feed).unwrap();
        };
        super::super::run(&file, &mut Outlet::new(take, || {}, stopped));
        feeds.try_iter().collect()
    }

    fn done(feed: &Feed) -> Option<f32> {
        let Feed::Status(SourceStatus::Loading { done }) = feed else { return None };
        Some(*done)
    }

    #[test]
    fn what_is_read_before_the_first_sample_has_its_progress_too() {
        let feeds = feeds(|_| false);
        let first = feeds.iter().position(|feed| matches!(feed, Feed::Rows(_))).unwrap();
        assert!(feeds[..first].iter().filter_map(done).count() > 10, "{:?}", &feeds[..first]);
        let all: Vec<f32> = feeds.iter().filter_map(done).collect();
        assert!(all.is_sorted() && all.last() == Some(&1.0), "{all:?}");
    }

    #[test]
    fn reading_before_the_first_sample_ends_with_the_window() {
        let feeds = feeds(|feed| done(feed) > Some(0.0));
        let all: Vec<f32> = feeds.iter().filter_map(done).collect();
        assert_eq!((all.len(), all[0]), (2, 0.0), "{all:?}");
        assert!(all[1] < 0.1 && !feeds.iter().any(|feed| matches!(feed, Feed::Rows(_))), "{all:?}");
    }
}
