//! Reader of an MCAP file of any program: its channels and messages, as they are.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use super::error::McapError;
use super::raw::{RawReader, Unpack};
use super::read::reported;
use crate::files;
use mcap::records::Record as RawRecord;
use std::borrow::Cow;

/// A channel as its file announces it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ForeignChannel {
    /// Topic.
    pub topic: String,
    /// Encoding of the messages, `cdr`, `json`, ...
    pub encoding: String,
    /// Name of the type.
    pub schema: String,
    /// Encoding of its definition, `ros2msg`, `jsonschema`, ...; empty where there is none.
    pub schema_encoding: String,
    /// The definition.
    pub definition: Vec<u8>,
}

/// What comes next in such a file.
#[derive(Debug, PartialEq, Eq)]
pub enum Foreign<'a> {
    /// A channel whose messages follow.
    Channel {
        /// Its number.
        id: u16,
        /// What it is.
        channel: ForeignChannel,
    },
    /// A message of a channel.
    Message {
        /// Number of the channel.
        channel: u16,
        /// When it was recorded (ns).
        log_ns: u64,
        /// Its bytes.
        data: &'a [u8],
    },
}

/// Reads any MCAP file from its start, chunk by chunk: at most 64 MiB of it are in memory.
#[derive(Debug)]
pub struct ForeignReader<R> {
    file: PathBuf,
    raw: RawReader<R>,
    /// Name, encoding and text of each definition.
    schemas: BTreeMap<u16, (String, String, Vec<u8>)>,
}

impl ForeignReader<BufReader<File>> {
    /// Opens `file`. `unpack` decompresses chunks whose compression this crate does not know (lz4 it does): name, bytes and the size
    /// that they must unpack to in, those bytes out.
    ///
    /// # Errors
    /// Where it cannot be read, or is no MCAP file.
    pub fn open(file: &Path, unpack: Unpack) -> Result<Self, McapError> {
        let input = files::open(file)
            .map_err(|source| McapError::Unreadable { file: file.to_owned(), source })?;
        Self::new(file, BufReader::with_capacity(1 << 16, input), unpack)
    }
}

impl<R: Read> ForeignReader<R> {
    /// [`ForeignReader::open`] of `input`; `file` is only named in errors.
    ///
    /// # Errors
    /// As there.
    pub fn new(file: &Path, input: R, unpack: Unpack) -> Result<Self, McapError> {
        let raw = RawReader::new(input).map_err(|error| reported(file, error))?.with_unpack(unpack);
        Ok(Self { file: file.to_owned(), raw, schemas: BTreeMap::new() })
    }

    /// The next channel or message; `None` at the end of the data.
    ///
    /// # Errors
    /// Where the file ends too early or is damaged.
    pub fn next_item(&mut self) -> Result<Option<Foreign<'_>>, McapError> {
        loop {
            let Some(place) = self.raw.advance().map_err(|error| reported(&self.file, error))?
            else {
                return Ok(None);
            };
            match self.raw.record(&place).map_err(|error| reported(&self.file, error))? {
                RawRecord::Schema { header, data } => {
                    let schema = (header.name, header.encoding, data.into_owned());
                    self.schemas.insert(header.id, schema);
                }
                RawRecord::Channel(channel) => {
                    let (schema, schema_encoding, definition) =
                        self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                    let (id, topic, encoding) =
                        (channel.id, channel.topic, channel.message_encoding);
                    let channel =
                        ForeignChannel { topic, encoding, schema, schema_encoding, definition };
                    return Ok(Some(Foreign::Channel { id, channel }));
                }
                RawRecord::Message { .. } => {}
                _ => continue,
            }
            // Taken again, because what is returned borrows the reader.
            if place.is_message() {
                let record =
                    self.raw.record(&place).map_err(|error| reported(&self.file, error))?;
                let RawRecord::Message { header, data: Cow::Borrowed(data) } = record else {
                    return Ok(None);
                };
                let (channel, log_ns) = (header.channel_id, header.log_time);
                return Ok(Some(Foreign::Message { channel, log_ns, data }));
            }
        }
    }
}

/// [`Unpack`] that knows no further compression.
///
/// # Errors
/// Always.
pub fn no_unpack(name: &str, _packed: &[u8], _size: u64) -> io::Result<Vec<u8>> {
    Err(io::Error::other(format!("the compression {name:?} is not known")))
}
