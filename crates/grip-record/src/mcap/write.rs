//! Writer of a finished MCAP file, from records with their host times.

use core::sync::atomic::{AtomicU64, Ordering};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::Arc;

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, Compression, WriteOptions, Writer};

use super::error::McapWriteError;
use super::record::Record;
use super::schema::{MESSAGE_ENCODING, SCHEMA_ENCODING, Topic};

/// Bytes of a chunk before compression at which it is written; a quarter of a second at 10 kHz has half as many.
const CHUNK: u64 = 512 * 1024;

/// A file that travels inside the recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attached {
    /// Its name, without a folder.
    pub name: String,
    /// Its media type, for example `application/json`.
    pub media_type: String,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// What was written so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Messages of each topic, in the order of [`Topic::ALL`].
    pub messages: [u64; Topic::ALL.len()],
    /// Bytes handed to the output.
    pub bytes: u64,
}

/// Writes a recording, chunk by chunk, each in one go: nothing is ever sought, so that a pipe will do.
///
/// Rules of the readers: a schema for every topic, log times that never go back, an index and statistics at the end. Until
/// [`McapWriter::flush`] the last chunk is in memory only; a file without [`McapWriter::finish`] can be
/// [recovered](super::recover). Many small writes go to `W`: give a buffered one.
pub struct McapWriter<W: Write> {
    out: Writer<NoSeek<Tally<W>>>,
    bytes: Arc<AtomicU64>,
    channels: [u16; Topic::ALL.len()],
    messages: [u64; Topic::ALL.len()],
    zero_ns: u64,
    last_ns: u64,
    message: Vec<u8>,
}

impl<W: Write> core::fmt::Debug for McapWriter<W> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("McapWriter").field("written", &self.written()).finish_non_exhaustive()
    }
}

impl<W: Write> McapWriter<W> {
    /// Begins a recording: schemas and topics. `zero_ns` is the wall time (ns since 1970) at host time 0, `program` names who
    /// writes, with its version.
    ///
    /// # Errors
    /// Where `out` refuses the bytes.
    pub fn new(out: W, program: &str, zero_ns: u64) -> Result<Self, McapWriteError> {
        let bytes = Arc::new(AtomicU64::new(0));
        let tally = NoSeek::new(Tally::new(out, &bytes));
        let mut out = Writer::with_options(tally, options("ros2", program))?;
        let mut channels = [0; Topic::ALL.len()];
        for (channel, topic) in channels.iter_mut().zip(Topic::ALL) {
            let text = topic.definition();
            let schema = out.add_schema(topic.schema(), SCHEMA_ENCODING, text.as_bytes())?;
            *channel = out.add_channel(schema, topic.name(), MESSAGE_ENCODING, &BTreeMap::new())?;
        }
        let messages = [0; Topic::ALL.len()];
        Ok(Self { out, bytes, channels, messages, zero_ns, last_ns: 0, message: Vec::new() })
    }

    /// Writes `record` as of `host_us`, microseconds of a monotonic clock; a time before the last one counts as the last one.
    ///
    /// # Errors
    /// Where the output refuses the bytes: nothing more can be written then.
    #[inline]
    pub fn write(&mut self, host_us: u64, record: &Record<'_>) -> Result<(), McapWriteError> {
        let log_time = self.log_ns(host_us);
        self.message.clear();
        record.encode(log_time, &mut self.message);
        let topic = record.topic().index();
        let header = MessageHeader {
            channel_id: self.channels[topic],
            #[expect(clippy::cast_possible_truncation, reason = "a sequence number wraps")]
            sequence: self.messages[topic] as u32,
            log_time,
            publish_time: log_time,
        };
        self.out.write_to_known_channel(&header, &self.message)?;
        self.messages[topic] += 1;
        Ok(())
    }

    /// Puts a file into the recording; ends the chunk.
    ///
    /// # Errors
    /// Where the output refuses the bytes.
    pub fn attach(&mut self, host_us: u64, file: &Attached) -> Result<(), McapWriteError> {
        let log_time = self.log_ns(host_us);
        let attachment = Attachment {
            log_time,
            create_time: log_time,
            name: file.name.clone(),
            media_type: file.media_type.clone(),
            data: Cow::Borrowed(&file.data),
        };
        Ok(self.out.attach(&attachment)?)
    }

    /// Writes names and values under a title; ends the chunk.
    ///
    /// # Errors
    /// Where the output refuses the bytes.
    pub fn metadata(
        &mut self,
        name: &str,
        values: &BTreeMap<String, String>,
    ) -> Result<(), McapWriteError> {
        let metadata = Metadata { name: name.to_owned(), metadata: values.clone() };
        Ok(self.out.write_metadata(&metadata)?)
    }

    /// Ends the chunk and hands everything to the operating system: what stands in the file survives a kill from here on.
    ///
    /// # Errors
    /// Where the output refuses the bytes.
    pub fn flush(&mut self) -> Result<(), McapWriteError> {
        Ok(self.out.flush()?)
    }

    /// Ends the recording with its index and statistics.
    ///
    /// # Errors
    /// Where the output refuses the bytes.
    pub fn finish(mut self) -> Result<Written, McapWriteError> {
        self.out.finish()?;
        Ok(self.written())
    }

    /// What was written so far; what waits in the chunk is not among the bytes.
    #[must_use]
    pub fn written(&self) -> Written {
        Written { messages: self.messages, bytes: self.bytes.load(Ordering::Relaxed) }
    }

    fn log_ns(&mut self, host_us: u64) -> u64 {
        let log_ns = self.zero_ns.saturating_add(host_us.saturating_mul(1000)).max(self.last_ns);
        self.last_ns = log_ns;
        log_ns
    }
}

/// How every file is written.
pub(super) fn options(profile: &str, program: &str) -> WriteOptions {
    WriteOptions::new()
        .profile(profile)
        .library(program)
        .compression(Some(Compression::Lz4))
        .chunk_size(Some(CHUNK))
        .disable_seeking(true)
}

/// Counts the bytes on their way.
pub(super) struct Tally<W> {
    out: W,
    bytes: Arc<AtomicU64>,
}

impl<W> Tally<W> {
    pub(super) fn new(out: W, bytes: &Arc<AtomicU64>) -> Self {
        Self { out, bytes: Arc::clone(bytes) }
    }
}

impl<W: Write> Write for Tally<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = self.out.write(bytes)?;
        self.bytes.fetch_add(taken as u64, Ordering::Relaxed);
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
