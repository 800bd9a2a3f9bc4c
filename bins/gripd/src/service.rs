//! The service thread: what the hot thread notes becomes lines, a live status and a recording.

use crate::{
    cli::Cli,
    notes::{Dropped, Inbox, Note, Recorded, Status},
};
use anyhow::Context as _;
use core::time::Duration;
use grip_host::{exit, report::EventLine};
use grip_link::{
    host::HostState,
    message::{Clamped, EventKind, FaultCode},
};
use grip_record::{ChannelSet, CsvWriter, StylusKind};
use std::{
    fs::File,
    io::{self, BufWriter, IsTerminal as _, Write as _},
    path::PathBuf,
    sync::Arc,
    thread,
};

/// Pause between two looks into the rings.
const PAUSE: Duration = Duration::from_millis(20);

/// Prints and records.
#[derive(Debug)]
pub(crate) struct Service {
    inbox: Inbox,
    json: bool,
    live: bool,
    status_shown: bool,
    degraded: u64,
    /// The last event of the gripper, so that a thousand equal ones a second are told once.
    device_event: Option<(EventKind, FaultCode)>,
    recording: Option<Recording>,
    /// The frame that is being written.
    frame: Vec<f32>,
    failure: Option<anyhow::Error>,
}

/// A recording that begins with the first sample: until then, what the file held before is left alone.
#[derive(Debug)]
struct Recording {
    file: PathBuf,
    out: Option<File>,
    writer: Option<CsvWriter<BufWriter<File>>>,
}

impl Service {
    /// Creates the file of the recording, if one is wanted.
    pub(crate) fn new(cli: &Cli, inbox: Inbox) -> anyhow::Result<Self> {
        let recording = cli.record.clone().map(Recording::create).transpose()?;
        let live = !cli.json && io::stderr().is_terminal();
        let (json, failure) = (cli.json, None);
        Ok(Self {
            inbox,
            json,
            live,
            status_shown: false,
            degraded: 0,
            device_event: None,
            recording,
            frame: Vec::new(),
            failure,
        })
    }

    pub(crate) fn dropped(&self) -> Arc<Dropped> {
        Arc::clone(&self.inbox.dropped)
    }

    /// Runs until the hot thread has let go of the rings and they are empty.
    pub(crate) fn run(&mut self) -> anyhow::Result<()> {
        loop {
            let last = self.inbox.notes.is_abandoned();
            self.drain()?;
            if last {
                break;
            }
            pause();
        }
        self.clear_status()?;
        self.recording.take().map_or(Ok(()), Recording::finish)?;
        self.failure.take().map_or(Ok(()), Err)
    }

    fn drain(&mut self) -> anyhow::Result<()> {
        let mut status = None;
        while let Ok(note) = self.inbox.notes.pop() {
            match note {
                Note::Status(latest) => status = Some(latest),
                Note::Event(line) => match self.event(&line) {
                    // Nobody reads any more; the object is held and recorded all the same.
                    Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {}
                    printed => printed?,
                },
                other => self.link(&other)?,
            }
        }
        if let Err(error) = self.record() {
            self.clear_status()?;
            eprintln!("gripd: {}; the object is held without", exit::message(error.as_ref()));
            self.recording = None;
            self.failure = Some(error);
        }
        status.map_or(Ok(()), |status| self.show(&status))
    }

    fn record(&mut self) -> anyhow::Result<()> {
        let Some(samples) = &mut self.inbox.samples else { return Ok(()) };
        while let Some(recorded) = samples.pop(&mut self.frame) {
            if let Some(recording) = &mut self.recording {
                recording.write(&recorded, &self.frame)?;
            }
        }
        Ok(())
    }

    fn event(&mut self, line: &EventLine) -> io::Result<()> {
        self.clear_status()?;
        let mut out = io::stdout().lock();
        if self.json {
            serde_json::to_writer(&mut out, line)?;
            writeln!(out)?;
        } else {
            writeln!(out, "{line}")?;
        }
        out.flush()
    }

    /// What a person at the keyboard should know of the link, on standard error.
    fn link(&mut self, note: &Note) -> anyhow::Result<()> {
        let text = match note {
            Note::Identified { rebooted: false } => "gripper found".to_owned(),
            Note::Identified { rebooted: true } | Note::Rebooted => {
                "the gripper has restarted; the noise floor is learned again".to_owned()
            }
            Note::Configured(clamped) => match clamped_names(*clamped) {
                names if names.is_empty() => return Ok(()),
                names => format!(
                    "the gripper does not allow what the configuration asks for: it limits {names}"
                ),
            },
            Note::State(HostState::Degraded) => {
                self.degraded += 1;
                if self.degraded > 1 {
                    return Ok(());
                }
                "samples were late or missing, so the force was not raised meanwhile; further times are only counted"
                    .to_owned()
            }
            Note::Device(event) => {
                let event_now = (event.kind, event.fault);
                if self.device_event.replace(event_now) == Some(event_now) {
                    return Ok(());
                }
                format!("the gripper reports {:?} (fault {:04X})", event.kind, event.fault.0)
            }
            Note::Refused(nack) => format!("the gripper refused a request: {:?}", nack.reason),
            _ => return Ok(()),
        };
        self.clear_status()?;
        eprintln!("gripd: {text}");
        Ok(())
    }

    /// One line that is written over by the next.
    fn show(&mut self, status: &Status) -> anyhow::Result<()> {
        if !self.live {
            return Ok(());
        }
        let esc = status.esc.map_or_else(
            || "-".to_owned(),
            |esc| format!("{:.3}{}", esc.value, if esc.informative() { "" } else { "?" }),
        );
        let estimate =
            status.estimate.map_or_else(|| "-".to_owned(), |e| format!("{:.2}", e.force_n));
        let command = status.command.map_or_else(|| "-".to_owned(), |c| format!("{:.2}", c.0));
        let mut err = io::stderr().lock();
        write!(
            err,
            "\r\x1b[K{:8} {:6.2} s  {} Hz  slip {:7.2}  E_sc {esc} W  estimate {estimate} N  command {command} N  stylus {}  lost {}",
            status.scene.name(),
            status.t.as_seconds(),
            status.rate_hz,
            status.statistic,
            status.health.name(),
            status.lost,
        )?;
        self.status_shown = true;
        Ok(err.flush()?)
    }

    fn clear_status(&mut self) -> io::Result<()> {
        if self.status_shown {
            self.status_shown = false;
            let mut err = io::stderr().lock();
            write!(err, "\r\x1b[K")?;
            err.flush()?;
        }
        Ok(())
    }
}

/// The limits a gripper changed, the mask of channels left out: all there are is what was asked for.
fn clamped_names(clamped: Clamped) -> String {
    const NAMES: [&str; 8] = [
        "sample rate",
        "batch",
        "",
        "largest force",
        "slew rate",
        "ttl",
        "hold cap",
        "time to the loss action",
    ];
    let named = NAMES
        .iter()
        .enumerate()
        .filter(|(bit, name)| clamped.0 >> bit & 1 == 1 && !name.is_empty());
    named.map(|(_, name)| *name).collect::<Vec<_>>().join(", ")
}

#[expect(clippy::disallowed_methods, reason = "the driver may wait; only the service thread does")]
fn pause() {
    thread::sleep(PAUSE);
}

impl Recording {
    fn create(file: PathBuf) -> anyhow::Result<Self> {
        let out = File::options()
            .write(true)
            .create(true)
            .truncate(false)
            .open(&file)
            .with_context(|| format!("cannot write the recording {}", file.display()))?;
        Ok(Self { file, out: Some(out), writer: None })
    }

    /// Every channel and every taxel has a column, used or not: a sensor may be silent at the first sample, and a replay knows
    /// by the column of the normal force that a controller ran.
    fn write(&mut self, recorded: &Recorded, frame: &[f32]) -> anyhow::Result<()> {
        let name = || format!("cannot write the recording {}", self.file.display());
        if let Some(out) = self.out.take() {
            if out.metadata().with_context(name)?.is_file() {
                out.set_len(0).with_context(name)?;
            }
            let channels = ChannelSet::all(StylusKind::Displacement).with_taxels(recorded.columns);
            self.writer = Some(CsvWriter::new(BufWriter::new(out), &channels).with_context(name)?);
        }
        match &mut self.writer {
            Some(writer) => writer.write_with(&recorded.sample, frame).with_context(name),
            None => Ok(()),
        }
    }

    fn finish(self) -> anyhow::Result<()> {
        let Some(writer) = self.writer else { return Ok(()) };
        let name = || format!("cannot write the recording {}", self.file.display());
        let mut out = writer.finish().with_context(name)?;
        out.flush().with_context(name)
    }
}
