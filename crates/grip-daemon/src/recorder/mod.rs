//! Recorder of what leaves the hot thread, to files on disk: MCAP with everything, or CSV with the samples.
//!
//! The recorder starts no thread and reads no clock: whoever runs it calls [`Recorder::take`] for each item and
//! [`Recorder::tick`] some times a second. Whatever goes wrong with a file stops the recording and nothing else: it is reported once
//! ([`Recorder::updates`]), every item that is not recorded is counted, and a new file is tried after a while.
//!
//! **Names.** `run.mcap` is written to `run.mcap` where that is not there or empty, else to the first free one of
//! `run-0001.mcap`, `run-0002.mcap`, ..: a finished recording is never overwritten, of MCAP or CSV. Rotation takes the next free
//! number, and so do the samples of each further pipeline in CSV, because times start again with it.
//!
//! **Rotation.** Every file stands for itself: attachments, metadata and the settings of the pipeline are written again. But a
//! pipeline remembers its past, which no file repeats, so a file that starts in the middle of a run is marked so, and only a replay
//! of all files in their order gives the identical events (`gripctl replay run.mcap run-0001.mcap`).
//!
//! **Loss.** What has been flushed survives a kill, what has been synced a power cut: [`FLUSH_US`] and [`SYNC_US`].

mod link;
mod name;
mod table;
mod tape;

use crate::{Item, LinkNote};
use core::mem;
use grip_record::{
    WriteError,
    mcap::{Attached, McapWriteError},
};
use std::{
    collections::{BTreeMap, VecDeque},
    fs, io,
    path::{Path, PathBuf},
};
use table::Table;
use tape::{Standing, Tape};

/// What was taken is handed to the operating system at least this often (us), unless other options are given.
pub const FLUSH_US: u64 = 250_000;
/// What was flushed is on the disk at least this often (us).
pub const SYNC_US: u64 = 2_000_000;
/// A new file is tried after this time (us), then after twice as long, up to [`LONGEST_PAUSE_US`].
const PAUSE_US: u64 = 10_000_000;
const LONGEST_PAUSE_US: u64 = 640_000_000;

/// How a recording is cut into files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordingOptions {
    /// A file is ended when it has this many bytes; `None` for never. Of no effect on CSV.
    pub rotate_bytes: Option<u64>,
    /// A file is ended when it is this old (us); `None` for never. Of no effect on CSV.
    pub rotate_us: Option<u64>,
    /// When the files of this recording have more bytes than this together, the oldest are deleted; `None` for never.
    pub keep_bytes: Option<u64>,
    /// What was taken is handed to the operating system at least this often (us).
    pub flush_us: u64,
    /// Whether raw bytes of the line are recorded too.
    pub wire: bool,
}

impl Default for RecordingOptions {
    /// One file, flushed every [`FLUSH_US`], without raw bytes; nothing is deleted.
    fn default() -> Self {
        Self {
            rotate_bytes: None,
            rotate_us: None,
            keep_bytes: None,
            flush_us: FLUSH_US,
            wire: false,
        }
    }
}

/// What a recording states of its origin. Times belong together: both clocks were read at once.
#[derive(Clone, Debug, Default)]
pub struct About {
    /// Program and version, for example `gripd 0.1.0`.
    pub program: String,
    /// A name of this recording that no other one has, for example its start in hexadecimal.
    pub run: String,
    /// Wall time (ns since 1970), read once; from here on only the monotonic clock counts.
    pub wall_ns: u64,
    /// Host time (us) at that moment.
    pub host_us: u64,
    /// Configuration, model and calibration, named as in [`grip_session::recording`].
    pub attached: Vec<Attached>,
    /// Whatever else is worth knowing, by name.
    pub facts: BTreeMap<String, String>,
}

/// Why a recording stopped.
#[derive(Debug, thiserror::Error)]
pub enum RecorderError {
    /// No file can be written there.
    #[error("cannot write the recording {}: {source}", file.display())]
    Create {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file takes no more.
    #[error("{}: {source}", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// Why.
        source: McapWriteError,
    },
    /// A row of a CSV file cannot be written.
    #[error("{}: {source}", file.display())]
    Row {
        /// The file.
        file: PathBuf,
        /// Why.
        source: WriteError,
    },
    /// The disk does not confirm what was written.
    #[error("{}: the disk does not take the recording: {source}", file.display())]
    Sync {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// What a person should know.
#[derive(Debug)]
pub enum RecorderUpdate {
    /// A file has been begun.
    Began(PathBuf),
    /// The recording has stopped; the control of the gripper goes on.
    Stopped(RecorderError),
    /// The oldest file was deleted, because newer ones need the room.
    Deleted(PathBuf),
    /// It was to be deleted and could not be.
    Kept(PathBuf, io::Error),
}

/// Counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecorderCounters {
    /// Items taken, those that a file of this kind leaves out included.
    pub items: u64,
    /// Samples written and flushed.
    pub samples: u64,
    /// Items that came while no file could be written, and those that a failure took with it.
    pub stopped: u64,
    /// Items that never reached the recorder, by [`Recorder::dropped`].
    pub dropped: u64,
    /// Bytes written into files that were ended, and into the present one; of no effect on CSV.
    pub bytes: u64,
    /// Files begun.
    pub files: u32,
    /// Times the recording has stopped.
    pub failures: u32,
}

/// Records items until it is [finished](Recorder::finish).
#[derive(Debug)]
pub struct Recorder {
    wanted: PathBuf,
    options: RecordingOptions,
    standing: Standing,
    output: Output,
    counters: RecorderCounters,
    updates: VecDeque<RecorderUpdate>,
    /// Files that are finished, with their bytes, the oldest first.
    finished: VecDeque<(PathBuf, u64)>,
    flushed_us: u64,
    synced_us: u64,
    /// Items since the last file stopped, which the next one reports.
    missing: u64,
    unflushed: Unflushed,
}

/// What has been taken since the last flush, and would be lost with a file that stops.
#[derive(Clone, Copy, Debug, Default)]
struct Unflushed {
    items: u64,
    samples: u64,
}

#[derive(Debug)]
enum Output {
    Mcap(Box<Tape>),
    Csv(Box<Table>),
    /// Nothing is written before `again_us`; the next file is at least number `next`.
    Stopped {
        again_us: u64,
        pause_us: u64,
        next: u32,
    },
}

impl Recorder {
    /// Begins a recording: CSV where `file` ends in `.csv`, MCAP where it ends in `.mcap`; CSV for every other ending.
    ///
    /// # Errors
    /// Where the first file cannot be written.
    pub fn create(
        file: &Path,
        options: RecordingOptions,
        about: About,
    ) -> Result<Self, RecorderError> {
        let now_us = about.host_us;
        let zero_ns = about.wall_ns.saturating_sub(now_us.saturating_mul(1000));
        let standing = Standing { about, zero_ns, beginning: None, gripper: None };
        let mut recorder = Self {
            wanted: file.to_owned(),
            options,
            standing,
            output: Output::Stopped { again_us: 0, pause_us: PAUSE_US, next: 0 },
            counters: RecorderCounters::default(),
            updates: VecDeque::new(),
            finished: VecDeque::new(),
            flushed_us: now_us,
            synced_us: now_us,
            missing: 0,
            unflushed: Unflushed::default(),
        };
        recorder.output = if is_mcap(file) {
            recorder.next_tape(0, now_us)?
        } else {
            Output::Csv(Box::new(Table::open(file, 0)?))
        };
        if let Some(file) = recorder.file().map(Path::to_owned) {
            recorder.began(file);
        }
        Ok(recorder)
    }

    /// Records `item`.
    pub fn take(&mut self, item: &Item<'_>, now_us: u64) {
        self.counters.items += 1;
        self.remember(item);
        if !self.options.wire && matches!(item, Item::Wire { .. }) {
            return;
        }
        if matches!(self.output, Output::Stopped { .. }) {
            self.counters.stopped += 1;
            self.missing += 1;
            return;
        }
        self.unflushed.items += 1;
        self.unflushed.samples += u64::from(matches!(item, Item::Sample { .. }));
        let taken = match &mut self.output {
            Output::Mcap(tape) => tape.take(item).map_err(|source| tape.error(source)),
            Output::Csv(_) => self.tabulate(item),
            Output::Stopped { .. } => Ok(()),
        };
        if let Err(error) = taken {
            self.stop(error, now_us);
        }
    }

    /// Flushes, syncs, rotates and tries again, whatever is due. Call it some times a second.
    pub fn tick(&mut self, now_us: u64) {
        if let Output::Stopped { again_us, .. } = self.output {
            if now_us >= again_us {
                self.try_again(now_us);
            }
            return;
        }
        let outcome = if now_us.saturating_sub(self.flushed_us) >= self.options.flush_us {
            self.flushed_us = now_us;
            self.flush(now_us).and_then(|()| self.rotate(now_us))
        } else {
            Ok(())
        };
        if let Err(error) = outcome {
            self.stop(error, now_us);
        }
    }

    /// Another configuration, model or calibration is in force from the next [`Item::Began`] on: it replaces the one of its name.
    pub fn attach(&mut self, file: &Attached, now_us: u64) {
        let attached = &mut self.standing.about.attached;
        attached.retain(|other| other.name != file.name);
        attached.push(file.clone());
        if let Output::Mcap(tape) = &mut self.output
            && let Err(source) = tape.attach(now_us, file)
        {
            let error = tape.error(source);
            self.stop(error, now_us);
        }
    }

    /// So many items never reached the recorder, because it was too slow; the recording reports it at this place.
    pub fn dropped(&mut self, items: u64, now_us: u64) {
        self.counters.dropped += items;
        if let Output::Mcap(tape) = &mut self.output
            && let Err(source) = tape.unrecorded(now_us, items)
        {
            let error = tape.error(source);
            self.stop(error, now_us);
        }
    }

    /// What happened since the last call, oldest first; each thing once.
    pub fn updates(&mut self) -> Option<RecorderUpdate> {
        self.updates.pop_front()
    }

    /// Counts so far.
    #[must_use]
    pub fn counters(&self) -> RecorderCounters {
        let present = match &self.output {
            Output::Mcap(tape) => tape.bytes(),
            Output::Csv(_) | Output::Stopped { .. } => 0,
        };
        RecorderCounters { bytes: self.counters.bytes + present, ..self.counters }
    }

    /// The file that is being written; `None` while the recording has stopped.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        match &self.output {
            Output::Mcap(tape) => Some(&tape.file),
            Output::Csv(table) => Some(&table.file),
            Output::Stopped { .. } => None,
        }
    }

    /// Ends the recording: the last file is whole and on the disk.
    ///
    /// # Errors
    /// Where that cannot be done.
    pub fn finish(mut self) -> Result<RecorderCounters, RecorderError> {
        self.counters.samples += self.unflushed.samples;
        match self.output {
            Output::Mcap(tape) => self.counters.bytes += tape.finish()?,
            Output::Csv(table) => table.finish()?,
            Output::Stopped { .. } => {}
        }
        Ok(self.counters)
    }

    /// Keeps what every further file has to repeat.
    fn remember(&mut self, item: &Item<'_>) {
        match item {
            Item::Began { beginning, .. } => self.standing.beginning = Some(**beginning),
            Item::Link { note: LinkNote::Identified { uid, boot_id, .. }, .. } => {
                self.standing.gripper = Some((*uid, *boot_id));
            }
            _ => {}
        }
    }

    fn tabulate(&mut self, item: &Item<'_>) -> Result<(), RecorderError> {
        let Output::Csv(table) = &mut self.output else { return Ok(()) };
        match item {
            Item::Began { beginning, .. } => {
                if table.begun() {
                    let next = Table::open(&self.wanted, table.number + 1)?;
                    let file = next.file.clone();
                    mem::replace(&mut **table, next).finish()?;
                    table.begin(beginning);
                    self.began(file);
                } else {
                    table.begin(beginning);
                }
                Ok(())
            }
            Item::Sample { sample, taxels, .. } => table.sample(sample, taxels),
            _ => Ok(()),
        }
    }

    fn flush(&mut self, now_us: u64) -> Result<(), RecorderError> {
        let due = now_us.saturating_sub(self.synced_us) >= SYNC_US;
        if due {
            self.synced_us = now_us;
        }
        let synced = match &mut self.output {
            Output::Mcap(tape) => {
                tape.flush().map_err(|source| tape.error(source))?;
                if due { tape.sync() } else { Ok(()) }
            }
            Output::Csv(table) => {
                table.flush()?;
                if due { table.sync() } else { Ok(()) }
            }
            Output::Stopped { .. } => Ok(()),
        };
        let file = self.file().unwrap_or(&self.wanted).to_owned();
        synced.map_err(|source| RecorderError::Sync { file, source })?;
        self.counters.samples += mem::take(&mut self.unflushed).samples;
        Ok(())
    }

    fn rotate(&mut self, now_us: u64) -> Result<(), RecorderError> {
        let Output::Mcap(tape) = &self.output else { return Ok(()) };
        let large = self.options.rotate_bytes.is_some_and(|limit| tape.bytes() >= limit);
        let age_us = now_us.saturating_sub(tape.began_us);
        let old = self.options.rotate_us.is_some_and(|limit| age_us >= limit);
        if !(large || old) {
            return Ok(());
        }
        let next = self.next_tape(tape.number + 1, now_us)?;
        let full = mem::replace(&mut self.output, next);
        if let Some(file) = self.file().map(Path::to_owned) {
            self.began(file);
        }
        if let Output::Mcap(full) = full {
            let file = full.file.clone();
            let bytes = full.finish()?;
            self.counters.bytes += bytes;
            self.finished.push_back((file, bytes));
        }
        self.make_room();
        Ok(())
    }

    /// Deletes the oldest finished files while all of them together are too large.
    fn make_room(&mut self) {
        let Some(keep_bytes) = self.options.keep_bytes else { return };
        let mut bytes: u64 = self.finished.iter().map(|(_, bytes)| bytes).sum();
        while bytes > keep_bytes {
            let Some((file, size)) = self.finished.pop_front() else { return };
            bytes -= size;
            self.updates.push_back(match fs::remove_file(&file) {
                Ok(()) => RecorderUpdate::Deleted(file),
                Err(error) => RecorderUpdate::Kept(file, error),
            });
        }
    }

    fn next_tape(&self, number: u32, now_us: u64) -> Result<Output, RecorderError> {
        let part = self.counters.files;
        let tape = Tape::begin(&self.wanted, number, part, &self.standing, now_us)?;
        Ok(Output::Mcap(Box::new(tape)))
    }

    fn began(&mut self, file: PathBuf) {
        self.counters.files += 1;
        self.updates.push_back(RecorderUpdate::Began(file));
    }

    fn stop(&mut self, error: RecorderError, now_us: u64) {
        self.counters.bytes = self.counters().bytes;
        if let Output::Mcap(tape) = &self.output {
            self.finished.push_back((tape.file.clone(), tape.bytes()));
            self.make_room();
        }
        let next = match &self.output {
            Output::Mcap(tape) => tape.number + 1,
            Output::Csv(table) => table.number + 1,
            Output::Stopped { next, .. } => *next,
        };
        let lost = mem::take(&mut self.unflushed).items;
        self.counters.stopped += lost;
        self.missing += lost;
        self.counters.failures += 1;
        self.updates.push_back(RecorderUpdate::Stopped(error));
        let again_us = now_us.saturating_add(PAUSE_US);
        self.output = Output::Stopped { again_us, pause_us: PAUSE_US, next };
    }

    /// A new file after a failure. Where there is still no room, nothing is said, and the next try comes later.
    fn try_again(&mut self, now_us: u64) {
        let Output::Stopped { pause_us, next, .. } = self.output else { return };
        let begun = if is_mcap(&self.wanted) {
            self.next_tape(next, now_us).and_then(|mut output| {
                if let Output::Mcap(tape) = &mut output {
                    let file = tape.file.clone();
                    let reported =
                        tape.unrecorded(now_us, self.missing).and_then(|()| tape.flush());
                    reported.map_err(|source| RecorderError::Write { file, source })?;
                }
                Ok(output)
            })
        } else {
            Table::open(&self.wanted, next).map(|mut table| {
                if let Some(beginning) = &self.standing.beginning {
                    table.begin(beginning);
                }
                Output::Csv(Box::new(table))
            })
        };
        match begun {
            Ok(output) => {
                self.output = output;
                self.missing = 0;
                if let Some(file) = self.file().map(Path::to_owned) {
                    self.began(file);
                }
            }
            Err(_) => {
                let pause_us = (pause_us * 2).min(LONGEST_PAUSE_US);
                let again_us = now_us.saturating_add(pause_us);
                self.output = Output::Stopped { again_us, pause_us, next };
            }
        }
    }
}

fn is_mcap(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"))
}
