//! Writer of items to one MCAP file, with everything in it that a replay needs.

use super::{About, RecorderError, link, name};
use crate::{Beginning, Item, LinkNote};
use grip_link::message::Status;
use grip_record::mcap::{
    CommandRecord, LinkRecord, McapWriteError, McapWriter, PipelineRecord, Record, SampleRecord,
    WireRecord,
};
use grip_session::{
    config::Uid,
    recording::{ABOUT, PART, RUN, UNRECORDED, event_record, pipeline_record},
};
use slip_core::{PipelineState, units::Micros};

use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, BufWriter},
    path::{Path, PathBuf},
};

/// The state is recorded when scene or controller change, and otherwise this often.
const STATE_EVERY: Micros = Micros(10_000);
/// So is what the gripper reports of itself, when its state, fault or limits change and otherwise this often (us): it comes with every
/// frame, and the raw bytes of the line have all of it.
const STATUS_EVERY_US: u64 = 10_000;
/// Bytes on their way to the operating system.
const BUFFER: usize = 1 << 16;

/// What every file of a recording repeats at its start.
#[derive(Clone, Debug)]
pub(super) struct Standing {
    pub(super) about: About,
    /// Wall time (ns since 1970) at host time 0.
    pub(super) zero_ns: u64,
    /// The pipeline that runs, where there is one.
    pub(super) beginning: Option<Beginning>,
    /// Identity and number of starts of the gripper.
    pub(super) gripper: Option<([u8; 16], u32)>,
}

/// One file that is being written.
#[derive(Debug)]
pub(super) struct Tape {
    writer: McapWriter<BufWriter<File>>,
    sync: Option<File>,
    pub(super) file: PathBuf,
    pub(super) number: u32,
    pub(super) began_us: u64,
    last_state: Option<PipelineState>,
    last_status: Option<(u64, Status)>,
    json: Vec<u8>,
}

impl Tape {
    /// Begins the next free file from `number` on; `part` counts the files of the recording.
    pub(super) fn begin(
        wanted: &Path,
        number: u32,
        part: u32,
        standing: &Standing,
        now_us: u64,
    ) -> Result<Self, RecorderError> {
        let unwritable = |source| RecorderError::Create { file: wanted.to_owned(), source };
        let (out, file, number) = name::create(wanted, number).map_err(unwritable)?;
        let regular = out.metadata().map_err(unwritable)?.is_file();
        let sync = regular.then(|| out.try_clone()).transpose().map_err(unwritable)?;
        let written = |source| RecorderError::Write { file: file.clone(), source };
        let out = BufWriter::with_capacity(BUFFER, out);
        let writer =
            McapWriter::new(out, &standing.about.program, standing.zero_ns).map_err(written)?;
        let (json, began_us) = (Vec::new(), now_us);
        let mut tape = Self {
            writer,
            sync,
            file: file.clone(),
            number,
            began_us,
            last_state: None,
            last_status: None,
            json,
        };
        match tape.head(part, standing, now_us) {
            Ok(()) => Ok(tape),
            Err(source) => {
                // Not even the head has room: the empty file leaves its name free.
                if let Some(file) = tape.sync.take() {
                    drop(tape.writer);
                    file.set_len(0).map_err(unwritable)?;
                }
                Err(written(source))
            }
        }
    }

    /// A failure to write, with the name of the file.
    pub(super) fn error(&self, source: McapWriteError) -> RecorderError {
        RecorderError::Write { file: self.file.clone(), source }
    }

    fn head(&mut self, part: u32, standing: &Standing, now_us: u64) -> Result<(), McapWriteError> {
        let mut about = standing.about.facts.clone();
        about.insert("program".to_owned(), standing.about.program.clone());
        about.insert("zero_ns".to_owned(), standing.zero_ns.to_string());
        about.insert(RUN.to_owned(), standing.about.run.clone());
        about.insert(PART.to_owned(), part.to_string());
        self.writer.metadata(ABOUT, &about)?;
        for file in &standing.about.attached {
            self.writer.attach(now_us, file)?;
        }
        if let Some((uid, boot_id)) = &standing.gripper {
            self.gripper(uid, *boot_id)?;
        }
        if let Some(beginning) = &standing.beginning {
            self.pipeline(now_us, beginning, true)?;
        }
        self.writer.flush()
    }

    /// Writes `item`.
    pub(super) fn take(&mut self, item: &Item<'_>) -> Result<(), McapWriteError> {
        match *item {
            Item::Began { host_us, beginning } => self.pipeline(host_us, beginning, false),
            Item::Sample { host_us, index, sample, taxels } => {
                let record = SampleRecord { index, sample: *sample, taxels };
                self.writer.write(host_us, &Record::Sample(record))
            }
            Item::State(state) => self.state(state),
            Item::Event { host_us, event } => {
                let record = event_record(event, &mut self.json).map_err(io::Error::from)?;
                self.writer.write(host_us, &Record::Event(record))
            }
            Item::Command { host_us, grip } => {
                let record = CommandRecord {
                    cmd_id: grip.cmd_id,
                    mode: grip.mode,
                    flags: grip.flags,
                    ttl_ms: grip.ttl_ms,
                    force_mn: grip.force_mn,
                    slew_mn_s: grip.slew_mn_s,
                    cause_sample: grip.cause_sample,
                };
                self.writer.write(host_us, &Record::Command(record))
            }
            Item::Evidence { .. } => Ok(()),
            Item::Client { host_us, command } => {
                self.writer.write(host_us, &Record::Client(command))
            }
            Item::Link { host_us, note } => {
                if let LinkNote::Identified { uid, boot_id, .. } = note {
                    self.gripper(uid, *boot_id)?;
                }
                if let LinkNote::Status(status) = note
                    && !self.is_updates(host_us, status)
                {
                    return Ok(());
                }
                let (kind, detail) = link::reported(note);
                let record = LinkRecord { kind, detail: &detail.to_string() };
                self.writer.write(host_us, &Record::Link(record))
            }
            Item::Wire { host_us, to_device, bytes } => {
                self.writer.write(host_us, &Record::Wire(WireRecord { to_device, bytes }))
            }
        }
    }

    /// Reports that items are missing here.
    pub(super) fn unrecorded(&mut self, host_us: u64, items: u64) -> Result<(), McapWriteError> {
        let detail = serde_json::json!({ "items": items }).to_string();
        let record = LinkRecord { kind: UNRECORDED, detail: &detail };
        self.writer.write(host_us, &Record::Link(record))
    }

    /// Puts a file into the recording.
    pub(super) fn attach(
        &mut self,
        host_us: u64,
        file: &grip_record::mcap::Attached,
    ) -> Result<(), McapWriteError> {
        self.writer.attach(host_us, file)
    }

    pub(super) fn flush(&mut self) -> Result<(), McapWriteError> {
        self.writer.flush()
    }

    /// Waits until the disk has what was flushed.
    pub(super) fn sync(&mut self) -> io::Result<()> {
        self.sync.as_ref().map_or(Ok(()), File::sync_data)
    }

    /// Bytes in the file.
    pub(super) fn bytes(&self) -> u64 {
        self.writer.written().bytes
    }

    /// Ends the file with index and statistics, and waits until the disk has it; how long it is (bytes).
    pub(super) fn finish(self) -> Result<u64, RecorderError> {
        let (file, sync) = (self.file, self.sync);
        let written = self
            .writer
            .finish()
            .map_err(|source| RecorderError::Write { file: file.clone(), source })?;
        let synced = sync.as_ref().map_or(Ok(()), File::sync_all);
        synced.map_err(|source| RecorderError::Sync { file, source })?;
        Ok(written.bytes)
    }

    fn gripper(&mut self, uid: &[u8; 16], boot_id: u32) -> Result<(), McapWriteError> {
        let values = [("uid", Uid(*uid).to_string()), ("boot_id", boot_id.to_string())];
        self.writer.metadata("gripper", &owned(values))
    }

    fn pipeline(
        &mut self,
        host_us: u64,
        beginning: &Beginning,
        continued: bool,
    ) -> Result<(), McapWriteError> {
        if let Some(grip) = beginning.config.grip {
            let limits = [
                ("sample_rate_hz", beginning.config.sample_rate.0.to_string()),
                ("f_max_n", grip.f_max_n.to_string()),
                ("slew_n_s", grip.slew_n_s.to_string()),
            ];
            self.writer.metadata("limits", &owned(limits))?;
        }
        let record = pipeline_record(beginning, &mut self.json).map_err(io::Error::from)?;
        let record = PipelineRecord { continued, ..record };
        self.writer.write(host_us, &Record::Pipeline(record))
    }

    /// Whether a status is worth a record.
    fn is_updates(&mut self, host_us: u64, status: &Status) -> bool {
        let stated = |status: &Status| (status.state, status.fault, status.clamp, status.rejected);
        let known = self.last_status.is_some_and(|(last_us, last)| {
            stated(&last) == stated(status) && host_us.saturating_sub(last_us) < STATUS_EVERY_US
        });
        if !known {
            self.last_status = Some((host_us, *status));
        }
        !known
    }

    fn state(&mut self, state: &PipelineState) -> Result<(), McapWriteError> {
        if let Some(last) = &self.last_state
            && (last.scene, last.grip) == (state.scene, state.grip)
            && state.host.since(last.host) < STATE_EVERY
        {
            return Ok(());
        }
        self.last_state = Some(*state);
        self.writer.write(state.host.0, &Record::State(*state))
    }
}

fn owned<const N: usize>(values: [(&str, String); N]) -> BTreeMap<String, String> {
    values.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}
