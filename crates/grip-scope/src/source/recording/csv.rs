//! A CSV recording in; its samples, and what a pipeline makes of them, out, some megabytes at a time.

use super::{Stop, deliver};
use crate::derive::Observer;
use crate::feed::{EventMark, Feed, Level, NoticeLine, ObserverSettings, StylusInfo};
use crate::source::outlet::Outlet;
use crate::source::stream::Stream;

use grip_session::model::default_estimator;
use grip_session::replay::pipeline_config;
use grip_session::report::EventLog;
use grip_session::{HostConfig, report::Event};

use grip_link::message::Unit;
use grip_record::{CsvError, CsvOptions, Recording, StylusKind, files, parse_csv};
use slip_core::{PipelineState, units::Micros};

use slip_core::{Sample, Step};
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// Bytes read at a time.
const PIECE: u64 = 4 << 20;
/// Longest first line of a table (bytes).
const HEADER: u64 = 64 << 10;
/// Longest other line (bytes).
const LINE: u64 = 1 << 20;
/// Rows, or other items, of a block.
const BLOCK: usize = 2048;
/// Device time of a block (us): states and events are placed by the rows around them.
const BLOCK_US: u64 = 500_000;
/// States come at most this often (us), and on change.
const STATE_US: u64 = 10_000;

/// Reads the recording to its end, or to its first fault.
pub(super) fn read(file: &Path, outlet: &mut Outlet) -> Result<(), Stop> {
    let failed = |error: std::io::Error| {
        Stop::Failed(format!(
            "{}: cannot be read ({error}); check the path and its permissions",
            file.display()
        ))
    };
    let input = files::open(file).map_err(failed)?;
    let len = input.metadata().map_err(failed)?.len();
    let mut input = BufReader::with_capacity(1 << 16, input);
    let mut header = Vec::new();
    if !line(&mut input, HEADER, &mut header).map_err(failed)? {
        return Err(Stop::Failed(too_long(file, "first line", HEADER)));
    }
    let mut tape = Tape::default();
    let mut read = header.len() as u64;
    loop {
        let mut piece = header.clone();
        (&mut input).take(PIECE).read_to_end(&mut piece).map_err(failed)?;
        let ends = line(&mut input, LINE, &mut piece).map_err(failed)?;
        let fresh = piece.len() - header.len();
        if fresh == 0 && read > header.len() as u64 {
            break;
        }
        read += fresh as u64;
        if !ends {
            return Err(stop(&too_long(file, "line", LINE), tape.rows == 0, &tape));
        }
        let options = CsvOptions::default();
        match parse_csv(file, &piece, &options) {
            Ok(recording) => tape.play(&recording, outlet, share(read, len))?,
            Err(error) => {
                let first = tape.rows == 0;
                // Where nothing before the bad row can be used either, that row is what is to be reported.
                if let Some(Ok(recording)) =
                    before(&piece, &error).map(|whole| parse_csv(file, whole, &options))
                {
                    tape.play(&recording, outlet, share(read, len))?;
                }
                return Err(stop(&sentence(&error), first, &tape));
            }
        }
        if fresh == 0 {
            break;
        }
    }
    Ok(())
}

/// Reads to the end of a line; `false` where it is longer than a line of a table can be: a file without lines would fill the memory.
fn line(input: &mut impl BufRead, most: u64, out: &mut Vec<u8>) -> std::io::Result<bool> {
    let read = input.take(most).read_until(b'\n', out)?;
    Ok((read as u64) < most || out.last() == Some(&b'\n'))
}

fn too_long(file: &Path, what: &str, most: u64) -> String {
    let most_kb = most >> 10;
    format!("{}: is no table: its {what} is longer than {most_kb} KiB", file.display())
}

/// What is wrong with the file; what the scope has no flag for is said in its own words.
fn sentence(error: &CsvError) -> String {
    match error {
        CsvError::NoTime { file, .. } | CsvError::NoRate { file, .. } => format!(
            "{}: has no times: what the scope shows needs a column t_s in seconds (`gripctl import {} --rate HZ -o run.csv` makes a recording of it)",
            file.display(),
            named(file)
        ),
        CsvError::NoStylus { file, found } if found.iter().any(|name| !is_text(name)) => {
            no_text(file)
        }
        CsvError::NoText { file } => no_text(file),
        CsvError::NoStylus { file, found } => format!(
            "{}: no column stylus, vibration, travel_m or pressure_0; `gripctl import {} --map vibration=NAME -o run.csv` makes a recording of it; the file has: {}",
            file.display(),
            named(file),
            found.join(", ")
        ),
        CsvError::Ambiguous { file, first, second } => format!(
            "{}: has {first} and {second}, only one of them can be used; rename or remove the other (`gripctl replay --map {first}={first}` does without)",
            file.display()
        ),
        other => other.to_string(),
    }
}

fn no_text(file: &Path) -> String {
    format!(
        "{}: is no table: its first line is no text; `gripctl import {} -o run.csv` may read it",
        file.display(),
        named(file)
    )
}

/// A file as an argument of a command that is pasted.
pub(super) fn named(file: &Path) -> String {
    format!("'{}'", file.display().to_string().replace('\'', r"'\''"))
}

/// Whether a name may be one: what is no text could not be read.
fn is_text(name: &str) -> bool {
    !name.contains(char::REPLACEMENT_CHARACTER)
}

/// The lines of the piece before the one that cannot be used; `None` where it is not a line that is wrong.
fn before<'a>(piece: &'a [u8], error: &CsvError) -> Option<&'a [u8]> {
    let (CsvError::FieldCount { line, .. }
    | CsvError::NotANumber { line, .. }
    | CsvError::TimeOutOfRange { line, .. }
    | CsvError::TimeBackwards { line, .. }) = error
    else {
        return None;
    };
    let lines = usize::try_from(*line).ok()?.checked_sub(1)?;
    let ends = piece.iter().enumerate().filter(|(_, byte)| **byte == b'\n');
    let (end, _) = ends.take(lines).last()?;
    piece.get(..=end)
}

/// Lines are counted from the start of a piece: beyond the first one they show nothing.
fn stop(error: &str, first: bool, tape: &Tape) -> Stop {
    let rows = tape.rows;
    match (rows, first) {
        (0, _) => Stop::Failed(error.to_owned()),
        (_, true) => Stop::Short(format!("only the first {rows} rows can be used; {error}")),
        (_, false) => Stop::Short(format!(
            "only the first {rows} rows can be used; `gripctl replay` says what is wrong with the rest"
        )),
    }
}

/// What was read so far.
#[derive(Default)]
struct Tape {
    stream: Stream,
    /// States and events of the rows that wait.
    updates: Vec<Feed>,
    /// Rows that wait, on both sides of gaps.
    waiting: usize,
    /// Time of the first of them (us).
    first_us: Option<u64>,
    log: EventLog,
    rows: u64,
    /// The median step of the first piece (us), by which gaps are reported.
    step_us: u64,
    last_us: Option<u64>,
    reported: Option<PipelineState>,
    rate_hz: u32,
}

impl Tape {
    fn play(&mut self, recording: &Recording, outlet: &mut Outlet, done: f64) -> Result<(), Stop> {
        if self.rows == 0 {
            self.begin(recording, outlet)?;
        }
        for (row, sample) in recording.samples.iter().enumerate() {
            let taxels = recording.taxels.as_ref().map_or(&[] as &[f32], |t| t.frame(row));
            if self.is_due(sample) {
                deliver(outlet, self.take(), done)?;
            }
            self.push(sample, taxels);
            self.rows += 1;
        }
        deliver(outlet, self.take(), done)
    }

    /// Whether what waits makes a block without this sample: across a long gap nothing is placed any more.
    fn is_due(&self, sample: &Sample) -> bool {
        let since_us = self.first_us.map_or(0, |first_us| sample.t.0.saturating_sub(first_us));
        self.waiting >= BLOCK || since_us >= BLOCK_US || self.updates.len() >= BLOCK
    }

    /// What waits. Rows first: states and events are placed by the rows around them.
    fn take(&mut self) -> Vec<Feed> {
        (self.waiting, self.first_us) = (0, None);
        let mut feeds = self.stream.take();
        feeds.append(&mut self.updates);
        feeds
    }

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
        deliver(outlet, vec![Feed::Stylus(StylusInfo { unit, axes })], 0.0)?;
        let config = pipeline_config(recording, &HostConfig::default(), true);
        let observer = default_estimator()
            .map_err(|error| error.to_string())
            .and_then(|model| Observer::new(config, model).map_err(|error| error.to_string()));
        match observer {
            Ok(observer) => {
                self.stream.observe(Some(observer));
                deliver(outlet, vec![Feed::Observes(ObserverSettings::Shipped)], 0.0)?;
            }
            Err(error) => {
                let rate_hz = recording.rate_hz;
                self.stream.observe(Some(Observer::spectra_only(rate_hz)));
                let text = format!(
                    "at {rate_hz:.0} Hz only spectra are derived from the samples: {error}"
                );
                let note = NoticeLine { level: Level::Warning, text };
                deliver(outlet, vec![Feed::Notice(note)], 0.0)?;
            }
        }
        let notes = &recording.notes;
        if !notes.ignored_columns.is_empty() {
            let text = format!("columns that are not shown: {}", notes.ignored_columns.join(", "));
            let note = NoticeLine { level: Level::Info, text };
            deliver(outlet, vec![Feed::Notice(note)], 0.0)?;
        }
        Ok(())
    }

    fn push(&mut self, sample: &Sample, taxels: &[f32]) {
        let since_us = self.last_us.map(|last_us| sample.t.0.saturating_sub(last_us));
        if let Some(since_us) = since_us.filter(|since| 2 * since > 5 * self.step_us) {
            let lost = u32::try_from(since_us / self.step_us).unwrap_or(u32::MAX);
            self.stream.broken(lost.saturating_sub(1));
        }
        self.last_us = Some(sample.t.0);
        self.first_us.get_or_insert(sample.t.0);
        self.waiting += 1;
        let Some(step) = self.stream.push(sample, taxels) else { return };
        let lines = self.log.events(&step);
        let marks: Vec<EventMark> = lines
            .iter()
            .flatten()
            .filter_map(|line| match line {
                Event::Slip(slip) => Some(EventMark::slip(slip)),
                Event::Grip { .. } | Event::Health { .. } => None,
            })
            .collect();
        let state = self.state(sample, &step);
        let updates_of_it = self.reported.is_none_or(|reported| {
            let changed = (reported.scene, reported.sensors) != (state.scene, state.sensors);
            changed || state.t >= reported.t.plus(Micros(STATE_US))
        });
        if updates_of_it {
            self.reported = Some(state);
            self.updates.push(Feed::State(state));
        }
        self.updates.extend(marks.into_iter().map(Feed::Event));
    }

    fn state(&self, sample: &Sample, step: &Step) -> PipelineState {
        let (features, estimate) = self.log.evidence();
        let esc = features.and_then(|features| features.esc_chosen);
        let state = step.state(None, esc, estimate);
        PipelineState { applied_n: sample.normal_force_n, rate_hz: self.rate_hz, ..state }
    }
}

#[expect(clippy::cast_precision_loss, reason = "a share of a file")]
fn share(read: u64, len: u64) -> f64 {
    (read as f64 / len.max(1) as f64).min(1.0)
}
