//! Reader of a recording of gripd: its messages, files and notes in their order.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::{Path, PathBuf};

use super::error::McapError;
use super::raw::{Place, RawError, RawReader};
use super::record::Record;
use super::schema::{MESSAGE_ENCODING, SCHEMA_ENCODING, Topic, fields};
use crate::files;
use mcap::records::Record as RawRecord;
use std::borrow::Cow;

/// One thing that a recording holds.
#[derive(Debug, PartialEq)]
pub enum Entry<'a> {
    /// A message.
    Message {
        /// Wall time at which the host had it (ns since 1970); never goes back.
        log_ns: u64,
        /// What it reports.
        record: Record<'a>,
    },
    /// A file inside the recording.
    Attachment {
        /// Its name.
        name: String,
        /// Its media type.
        media_type: String,
        /// Its bytes.
        data: Cow<'a, [u8]>,
    },
    /// Names and values under a title.
    Metadata {
        /// The title.
        name: String,
        /// The values.
        values: BTreeMap<String, String>,
    },
}

/// Reads a recording from its start, chunk by chunk; a file without its end is read as far as it is whole.
#[derive(Debug)]
pub struct McapReader<R> {
    file: PathBuf,
    raw: RawReader<R>,
    /// Schemas by their number: the topics they can serve.
    schemas: BTreeMap<u16, Topic>,
    /// Topics by the number of their channel.
    channels: BTreeMap<u16, Topic>,
    taxels: Vec<f32>,
}

impl McapReader<BufReader<File>> {
    /// Opens the recording in `file`.
    ///
    /// # Errors
    /// Where it cannot be read, or is no MCAP file.
    pub fn open(file: &Path) -> Result<Self, McapError> {
        let input = files::open(file)
            .map_err(|source| McapError::Unreadable { file: file.to_owned(), source })?;
        Self::new(file, BufReader::with_capacity(1 << 16, input))
    }
}

impl<R: Read + Send + 'static> McapReader<R> {
    /// The same recording, read and decompressed in a thread of its own, two chunks ahead, until [`McapReader::jump`]: for who
    /// reads it to its end.
    ///
    /// # Errors
    /// Where there is no thread to be had.
    pub fn read_ahead(self) -> Result<Self, McapError> {
        let Self { file, raw, .. } = self;
        let raw = raw.read_ahead().map_err(|error| reported(&file, error))?;
        Ok(Self { raw, file, ..self })
    }
}

impl<R: Read + Seek> McapReader<R> {
    /// Goes on with the chunk, or other record, that begins at `offset`, as an index shows it. Topics that were announced in a part that
    /// was never read are not known there; gripd announces them at the start of a file.
    ///
    /// # Errors
    /// Where the input cannot be sought.
    pub fn jump(&mut self, offset: u64) -> Result<(), McapError> {
        self.raw.jump(offset).map_err(|error| reported(&self.file, error))
    }
}

impl<R: Read> McapReader<R> {
    /// Bytes of the file up to where reading went.
    #[must_use]
    pub fn position(&self) -> u64 {
        self.raw.position()
    }

    /// Whether [`McapReader::next_entry`] may find more, also after an error that reported damage: then what follows the damaged part. A file
    /// that ends too early, or where no next record can be made out, goes on only after [`McapReader::jump`].
    #[must_use]
    pub fn goes_on(&self) -> bool {
        !self.raw.ended()
    }

    /// Whether the chunk that is being read holds more records.
    #[must_use]
    pub fn chunk_goes_on(&self) -> bool {
        self.raw.chunk_goes_on()
    }

    /// Reads from `input`; `file` is only named in errors.
    ///
    /// # Errors
    /// Where it cannot be read, or does not begin as an MCAP file.
    pub fn new(file: &Path, input: R) -> Result<Self, McapError> {
        let raw = RawReader::new(input).map_err(|error| reported(file, error))?;
        let file = file.to_owned();
        let (schemas, channels) = (BTreeMap::new(), BTreeMap::new());
        Ok(Self { file, raw, schemas, channels, taxels: Vec::new() })
    }

    /// The next thing; `None` at the end of the recording.
    ///
    /// # Errors
    /// Where the file ends too early, is damaged, or is not a recording of gripd.
    pub fn next_entry(&mut self) -> Result<Option<Entry<'_>>, McapError> {
        loop {
            match self.raw.advance().map_err(|error| reported(&self.file, error))? {
                None => return Ok(None),
                Some(place) if place.announces() => self.announce(&place)?,
                Some(place) => return self.entry(&place).map(Some),
            }
        }
    }

    /// Learns a schema or a channel, where it is one of ours.
    fn announce(&mut self, place: &Place) -> Result<(), McapError> {
        match self.raw.record(place).map_err(|error| reported(&self.file, error))? {
            RawRecord::Schema { header, data } => {
                let topic = own_schema(&self.file, &header.name, &header.encoding, &data)?;
                self.schemas.insert(header.id, topic);
            }
            RawRecord::Channel(channel) => {
                let described = self.schemas.get(&channel.schema_id).copied();
                let (topic, encoding) = (channel.topic, channel.message_encoding);
                let own = Topic::from_name(&topic)
                    .filter(|own| described == Some(*own) && encoding == MESSAGE_ENCODING)
                    .ok_or_else(|| {
                        let what = format!("it has the topic {topic:?} ({encoding})");
                        McapError::foreign(&self.file, &what)
                    })?;
                self.channels.insert(channel.id, own);
            }
            _ => {}
        }
        Ok(())
    }

    fn entry(&mut self, place: &Place) -> Result<Entry<'_>, McapError> {
        let Self { file, raw, channels, taxels, .. } = self;
        let offset = raw.offset();
        let damaged = |what| McapError::Damaged { file: file.clone(), offset, what };
        if place.is_message() {
            let (channel, log_ns, data) =
                raw.message(place).map_err(|error| reported(file, error))?;
            let topic = *channels.get(&channel).ok_or_else(|| {
                damaged(format!("a message of channel {channel}, which was not announced"))
            })?;
            let record = Record::decode(topic, data, taxels).map_err(|source| {
                McapError::Message { file: file.clone(), offset, topic, source }
            })?;
            return Ok(Entry::Message { log_ns, record });
        }
        Ok(match raw.record(place).map_err(|error| reported(file, error))? {
            RawRecord::Attachment { header, data, .. } => {
                Entry::Attachment { name: header.name, media_type: header.media_type, data }
            }
            RawRecord::Metadata(metadata) => {
                Entry::Metadata { name: metadata.name, values: metadata.metadata }
            }
            _ => return Err(damaged("no message where one should be".to_owned())),
        })
    }
}

/// The topic whose messages the schema describes, or what is foreign about it.
fn own_schema(file: &Path, name: &str, encoding: &str, data: &[u8]) -> Result<Topic, McapError> {
    let topic = Topic::ALL.into_iter().find(|topic| topic.schema() == name);
    let topic = topic.filter(|_| encoding == SCHEMA_ENCODING);
    let topic = topic.ok_or_else(|| {
        McapError::foreign(file, &format!("it has messages of the type {name:?} ({encoding})"))
    })?;
    let own = fields(&topic.definition());
    // Fields were only ever added at the end: what an earlier version wrote lacks some of the last.
    let known = core::str::from_utf8(data).is_ok_and(|text| {
        let theirs = fields(text);
        let added = match topic {
            Topic::Sample => 2,
            Topic::State => 1,
            _ => 0,
        };
        theirs == own || (own.starts_with(&theirs) && theirs.len() + added == own.len())
    });
    if known {
        return Ok(topic);
    }
    let what = format!(
        "its messages of the type {name:?} have other fields than this version of gripctl knows"
    );
    Err(McapError::Foreign { file: file.to_owned(), what })
}

pub(super) fn reported(file: &Path, error: RawError) -> McapError {
    let file = file.to_owned();
    match error {
        RawError::Io(source) => McapError::Unreadable { file, source },
        RawError::Zstd => McapError::foreign(&file, "its chunks are compressed with zstd"),
        RawError::NoMcap => McapError::NoMcap { file },
        RawError::Truncated { offset } => McapError::Truncated { file, offset },
        RawError::Damaged { offset, what, .. } => McapError::Damaged { file, offset, what },
    }
}
