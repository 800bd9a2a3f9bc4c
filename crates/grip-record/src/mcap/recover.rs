//! Recovery of a recording that was cut off or damaged: a finished one with all that is whole.

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::path::Path;

use mcap::records::{MessageHeader, Record as RawRecord};
use mcap::write::NoSeek;
use mcap::{Attachment, Writer};

use super::error::{McapError, McapWriteError};
use super::raw::{RawError, RawReader, Unpack};
use super::read::reported;
use super::write::options;

/// What a recovery has saved and what it could not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Recovered {
    /// Messages saved.
    pub messages: u64,
    /// Files inside the recording that were saved.
    pub attachments: u64,
    /// Log times (ns since 1970) of the first and the last message saved.
    pub span_ns: Option<(u64, u64)>,
    /// Places in the middle that were damaged and left out: the offset and what does not fit.
    pub holes: Vec<(u64, String)>,
    /// Messages among those saved of chunks that have their beginning only.
    pub of_cut_chunk: u64,
    /// Program that wrote the input, as the file states it.
    pub library: String,
    /// Where the file ends too early, or where nothing more can be made out; its length where only the index is missing or damaged.
    pub cut_at: Option<u64>,
}

impl Recovered {
    /// Whether the input was a finished recording without damage.
    #[must_use]
    pub fn was_whole(&self) -> bool {
        self.holes.is_empty() && self.cut_at.is_none()
    }

    /// Whether a program of this workspace states that it wrote the input.
    #[must_use]
    pub fn was_ours(&self) -> bool {
        ["gripd ", "gripctl ", "grip-scope "].iter().any(|name| self.library.starts_with(name))
    }
}

/// Why a recovery failed.
#[derive(Debug, thiserror::Error)]
pub enum RecoverError {
    /// The input cannot be read at all.
    #[error(transparent)]
    Read(#[from] McapError),
    /// The output cannot be written.
    #[error(transparent)]
    Write(#[from] McapWriteError),
}

/// Copies every whole record from `input` to `out` and finishes it. `file` names the input in errors, `program` who writes, `unpack`
/// decompresses what gripd does not use ([`ForeignReader::open`](super::ForeignReader::open)).
///
/// Profile, topics and schemas may be anybody's. Of a chunk in which the file ends the whole messages are saved, as far as it can be
/// decompressed. A damaged chunk in the middle is left out and reported; messages whose topic was announced only there are lost with it.
///
/// # Errors
/// Where the input is no MCAP file or cannot be read, or the output cannot be written.
pub fn recover(
    file: &Path,
    input: impl Read,
    out: impl Write,
    program: &str,
    unpack: Unpack,
) -> Result<Recovered, RecoverError> {
    let raw = RawReader::new(input).map_err(|error| reported(file, error))?;
    let mut raw = raw.with_unpack(unpack);
    let mut next = raw.advance();
    let options = options(&raw.header().profile, program);
    let mut copy = Copy {
        out: Writer::with_options(NoSeek::new(out), options).map_err(McapWriteError)?,
        channels: BTreeMap::new(),
        schemas: BTreeMap::new(),
        saved: Recovered { library: raw.header().library.clone(), ..Recovered::default() },
    };
    loop {
        match next.and_then(|place| place.map(|place| raw.record(&place)).transpose()) {
            Ok(None) => {
                // Of a damaged file the holes are known already.
                let whole = raw.finished() && (raw.sound() || !copy.saved.holes.is_empty());
                copy.saved.cut_at = (!whole).then(|| raw.position());
                break;
            }
            Ok(Some(record)) => {
                let before = copy.saved.messages;
                copy.take(record, raw.offset()).map_err(McapWriteError)?;
                if raw.is_cut() {
                    copy.saved.of_cut_chunk += copy.saved.messages - before;
                }
            }
            Err(RawError::Damaged { offset, what, skippable: true }) => {
                copy.saved.holes.push((offset, what));
            }
            Err(RawError::Truncated { offset } | RawError::Damaged { offset, .. }) => {
                copy.saved.cut_at = Some(offset);
                break;
            }
            Err(error) => return Err(reported(file, error).into()),
        }
        next = raw.advance();
    }
    copy.out.finish().map_err(McapWriteError)?;
    Ok(copy.saved)
}

struct Copy<W: Write> {
    out: Writer<NoSeek<W>>,
    /// Numbers in the input and in the output.
    channels: BTreeMap<u16, u16>,
    schemas: BTreeMap<u16, u16>,
    saved: Recovered,
}

impl<W: Write> Copy<W> {
    fn take(&mut self, record: RawRecord<'_>, offset: u64) -> mcap::McapResult<()> {
        match record {
            RawRecord::Schema { header, data } => {
                let ours = self.out.add_schema(&header.name, &header.encoding, &data)?;
                self.schemas.insert(header.id, ours);
            }
            RawRecord::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id).copied().unwrap_or(0);
                let (topic, encoding) = (&channel.topic, &channel.message_encoding);
                let ours = self.out.add_channel(schema, topic, encoding, &channel.metadata)?;
                self.channels.insert(channel.id, ours);
            }
            RawRecord::Message { header, data } => {
                let Some(&channel_id) = self.channels.get(&header.channel_id) else {
                    let channel = header.channel_id;
                    let what = format!("a message of channel {channel}, which was not announced");
                    self.saved.holes.push((offset, what));
                    return Ok(());
                };
                self.out.write_to_known_channel(&MessageHeader { channel_id, ..header }, &data)?;
                self.saved.messages += 1;
                let first = self.saved.span_ns.map_or(header.log_time, |(first, _)| first);
                self.saved.span_ns = Some((first, header.log_time));
            }
            RawRecord::Attachment { header, data, .. } => {
                self.out.attach(&Attachment {
                    log_time: header.log_time,
                    create_time: header.create_time,
                    name: header.name,
                    media_type: header.media_type,
                    data,
                })?;
                self.saved.attachments += 1;
            }
            RawRecord::Metadata(metadata) => self.out.write_metadata(&metadata)?,
            _ => {}
        }
        Ok(())
    }
}
