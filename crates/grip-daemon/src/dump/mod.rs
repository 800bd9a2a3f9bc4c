//! Dump on a fault, for a person: a text file with the last frames of both directions and the state of the daemon, from items.
//!
//! The memory is taken once and filled on the service thread. Files are rare by design: one in 10 s, 50 in a run.

mod frames;

use crate::{
    board::Board,
    log::Clocks,
    rings::{Item, LinkNote},
    status::Status,
};
use core::fmt::Write as _;
use frames::{FrameRing, Slot};
use grip_link::{
    host::CloseReason,
    message::{EventKind, FaultCode},
};
use grip_session::{session::explain, utc};
use slip_core::grip::GripState;
use std::{
    ffi::OsStr,
    fs::{self, File},
    io::{self, Write as _},
    path::{Path, PathBuf},
};

/// The least time between two files (us).
const EVERY_US: u64 = 10_000_000;
/// Files in a run.
const MOST: u32 = 50;

/// Why a dump is written.
#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// The link closed by error.
    LinkClosed(CloseReason),
    /// The gripper reported a fault.
    GripperFault(FaultCode),
    /// The force controller stopped because the stylus cannot be trusted.
    ControllerFault,
    /// A thread of the daemon ended with a panic, which said this.
    Panic(String),
    /// Somebody asked for it.
    Asked,
}

/// What became of a dump.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Dumped {
    /// It was written.
    File(PathBuf),
    /// One was written just before, or there have been too many in this run.
    TooMany,
    /// No folder is configured, and the service has no state directory.
    NoFolder,
}

/// Why a dump could not be written.
#[derive(Debug, thiserror::Error)]
#[error("the dump cannot be written into {}: {source}", folder.display())]
pub struct DumpError {
    /// The folder.
    folder: PathBuf,
    /// What the system said.
    source: io::Error,
}

/// The last frames, and the rule when they are written.
#[derive(Clone, Debug)]
pub struct FlightRecorder {
    folder: Option<PathBuf>,
    from_device: FrameRing,
    to_device: FrameRing,
    grip: GripState,
    last_us: Option<u64>,
    written: u32,
    suppressed: u64,
}

/// Where dumps go: the configured folder, or the first one of `STATE_DIRECTORY`, which systemd sets.
#[must_use]
pub fn folder(configured: Option<&Path>, state_directory: Option<&OsStr>) -> Option<PathBuf> {
    let state =
        || std::env::split_paths(state_directory?).find(|path| !path.as_os_str().is_empty());
    configured.map(Path::to_owned).or_else(state)
}

impl Cause {
    /// The word in the name of the file.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::LinkClosed(_) => "link_closed",
            Self::GripperFault(_) => "gripper_fault",
            Self::ControllerFault => "controller_fault",
            Self::Panic(_) => "panic",
            Self::Asked => "asked",
        }
    }

    fn sentence(&self) -> String {
        match self {
            Self::LinkClosed(reason) => format!("the link closed: {}", explain(reason)),
            Self::GripperFault(fault) => format!("the gripper reported fault {:04X}", fault.0),
            Self::ControllerFault => {
                "the force controller stopped: the stylus cannot be trusted".to_owned()
            }
            Self::Panic(text) => format!("a thread of gripd panicked: {text}"),
            Self::Asked => "somebody asked for it".to_owned(),
        }
    }
}

impl FlightRecorder {
    /// Remembers frames, and writes files into `folder`, where there is one.
    #[must_use]
    pub fn new(folder: Option<PathBuf>) -> Self {
        let (from_device, to_device) = (FrameRing::new(), FrameRing::new());
        Self {
            folder,
            from_device,
            to_device,
            grip: GripState::Observing,
            last_us: None,
            written: 0,
            suppressed: 0,
        }
    }

    /// Takes what happened; states where that is worth a dump.
    pub fn take(&mut self, item: &Item<'_>) -> Option<Cause> {
        match *item {
            Item::Wire { host_us, to_device, bytes } => {
                let ring = if to_device { &mut self.to_device } else { &mut self.from_device };
                ring.push(host_us, bytes);
                None
            }
            Item::State(state) => {
                let before = core::mem::replace(&mut self.grip, state.grip);
                let fault = GripState::Fault;
                (state.grip == fault && before != fault).then_some(Cause::ControllerFault)
            }
            Item::Link { note: LinkNote::Closed(reason), .. } => {
                (*reason != CloseReason::Requested).then_some(Cause::LinkClosed(*reason))
            }
            Item::Link { note: LinkNote::Device(event), .. } if event.kind == EventKind::Fault => {
                Some(Cause::GripperFault(event.fault))
            }
            _ => None,
        }
    }

    /// Writes a dump, unless it is too early for another one.
    ///
    /// # Errors
    /// Where the folder cannot be made, or the file not be written.
    pub fn write(
        &mut self,
        cause: &Cause,
        board: &Board,
        now: Clocks,
    ) -> Result<Dumped, DumpError> {
        let Some(folder) = self.folder.clone() else { return Ok(Dumped::NoFolder) };
        let early = self.last_us.is_some_and(|last| now.host_us.saturating_sub(last) < EVERY_US);
        if early || self.written >= MOST {
            self.suppressed += 1;
            return Ok(Dumped::TooMany);
        }
        self.last_us = Some(now.host_us);
        self.written += 1;
        let text = self.text(cause, board, now);
        self.suppressed = 0;
        create(
            &folder,
            &format!("gripd-{}-{}", utc::compact(now.wall_us / 1_000_000), cause.name()),
            &text,
        )
        .map(Dumped::File)
        .map_err(|source| DumpError { folder, source })
    }

    /// The text of a dump.
    #[must_use]
    pub fn text(&self, cause: &Cause, board: &Board, now: Clocks) -> String {
        let mut text = format!(
            "gripd {}: dump of {}, {} s after the start\ncause: {}\n",
            board.about.version,
            utc::line(now.wall_us),
            seconds(now.host_us),
            cause.sentence(),
        );
        if self.suppressed > 0 {
            let more = self.suppressed;
            let line = format!("{more} causes since the last dump were not written down\n");
            text.push_str(&line);
        }
        let status = Status::of(board, now.host_us);
        let status = status.pretty().unwrap_or_else(|error| error.to_string());
        text.push_str(&format!("\n== state\n{status}\n"));
        text.push_str(
            "\n== last frames: time since the start (s), <- from the gripper, -> to it, what it is | its bytes on the wire\n",
        );
        for (slot, arrow) in self.by_time() {
            // A string takes everything.
            let _: core::fmt::Result =
                writeln!(text, "{:>14} {arrow} {slot}", seconds(slot.host_us));
        }
        text
    }

    /// The frames of both directions in the order of time.
    fn by_time(&self) -> Vec<(&Slot, &'static str)> {
        let from = self.from_device.slots().map(|slot| (slot, "<-"));
        let to = self.to_device.slots().map(|slot| (slot, "->"));
        let mut slots: Vec<(&Slot, &'static str)> = from.chain(to).collect();
        slots.sort_by_key(|(slot, _)| slot.host_us);
        slots
    }
}

/// Microseconds as seconds with all digits.
fn seconds(us: u64) -> String {
    format!("{}.{:06}", us / 1_000_000, us % 1_000_000)
}

/// A new file of that name, with a number where there is one already.
fn create(folder: &Path, name: &str, text: &str) -> io::Result<PathBuf> {
    fs::create_dir_all(folder)?;
    let mut number = 1;
    loop {
        let file = folder.join(format!("{name}-{number}.txt"));
        match File::create_new(&file) {
            Ok(mut out) => {
                out.write_all(text.as_bytes())?;
                out.sync_data()?;
                return Ok(file);
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && number < 1000 => {
                number += 1;
            }
            Err(error) => return Err(error),
        }
    }
}
