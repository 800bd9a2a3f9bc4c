//! The bytes of an MCAP file in, its records with their offsets out; nothing in a file makes this panic or take more than
//! [`LONGEST`] bytes at once.
//!
//! Layout of the format: mcap.dev/spec. A file is magic, records (one byte of opcode, eight of length, a body), magic. A chunk
//! is a record that holds records, compressed. What a record holds is read by the crate `mcap`.

use mcap::MAGIC;
use mcap::records::{ChunkIndex, Record as RawRecord, op};
use std::io::{self, Read, Seek, SeekFrom};

/// The longest record, and the longest chunk after decompression, that is believed (bytes); far above what any recorder writes.
pub(super) const LONGEST: u64 = 64 << 20;

/// Decompresses a chunk: the name of the compression, its bytes and the size that they must unpack to in, those bytes out.
pub type Unpack = fn(&str, &[u8], u64) -> io::Result<Vec<u8>>;

/// Where reading stopped.
#[derive(Debug)]
pub(super) enum RawError {
    Io(io::Error),
    NoMcap,
    /// The input ended inside the record that begins there, or before the end of the data.
    Truncated {
        offset: u64,
    },
    /// The record that begins there cannot be what was written.
    Damaged {
        offset: u64,
        what: String,
        skippable: bool,
    },
}

/// Where the present record stands.
#[derive(Clone, Debug)]
pub(super) struct Place {
    opcode: u8,
    /// Its body in the chunk; `None` where it stands in the file itself.
    in_chunk: Option<core::ops::Range<usize>>,
}

impl Place {
    pub(super) fn is_message(&self) -> bool {
        self.opcode == op::MESSAGE
    }

    /// Whether it only announces schemas or channels.
    pub(super) fn announces(&self) -> bool {
        matches!(self.opcode, op::SCHEMA | op::CHANNEL)
    }
}

/// Reads a file from its start to the end of its data.
#[derive(Debug)]
pub(super) struct RawReader<R> {
    input: R,
    /// Where the next record of the file begins.
    next: u64,
    /// Where the present one begins.
    offset: u64,
    body: Vec<u8>,
    /// The present chunk, decompressed, and how far it has been read.
    chunk: Vec<u8>,
    at: usize,
    ended: bool,
    finished: bool,
    /// Over every byte up to the end of the data.
    sum: crc32fast::Hasher,
    sound: bool,
    /// For compressions that gripd does not use.
    unpack: Option<Unpack>,
}

impl<R: Read + Seek> RawReader<R> {
    /// Goes to the record of the file that begins at `offset`. Whether the data are sound as a whole is not known any more.
    pub(super) fn jump(&mut self, offset: u64) -> Result<(), RawError> {
        self.input.seek(SeekFrom::Start(offset)).map_err(RawError::Io)?;
        self.next = offset;
        self.chunk.clear();
        self.at = 0;
        self.ended = false;
        Ok(())
    }
}

impl<R: Read> RawReader<R> {
    /// # Errors
    /// [`RawError::NoMcap`], [`RawError::Io`].
    pub(super) fn new(mut input: R) -> Result<Self, RawError> {
        let mut magic = [0; MAGIC.len()];
        fill(&mut input, &mut magic).map_err(RawError::Io)?;
        if magic != MAGIC {
            return Err(RawError::NoMcap);
        }
        let next = MAGIC.len() as u64;
        let mut sum = crc32fast::Hasher::new();
        sum.update(&magic);
        Ok(Self {
            input,
            next,
            offset: 0,
            body: Vec::new(),
            chunk: Vec::new(),
            at: 0,
            ended: false,
            finished: false,
            sum,
            sound: false,
            unpack: None,
        })
    }

    /// The same with one more way to decompress a chunk.
    pub(super) fn with_unpack(self, unpack: Unpack) -> Self {
        Self { unpack: Some(unpack), ..self }
    }

    /// Where in the file the present record, or the chunk that holds it, begins.
    pub(super) fn offset(&self) -> u64 {
        self.offset
    }

    /// Whether the present chunk holds more records.
    pub(super) fn chunk_goes_on(&self) -> bool {
        self.at < self.chunk.len()
    }

    /// Goes to the next record that matters; `None` at the end of the data. After [`RawError::Damaged`] that is `skippable` the
    /// records behind the damage follow.
    pub(super) fn advance(&mut self) -> Result<Option<Place>, RawError> {
        loop {
            if self.chunk_goes_on() {
                let Some((opcode, body)) = inner_record(&self.chunk, self.at) else {
                    self.at = self.chunk.len();
                    return Err(damaged(
                        self.offset,
                        "a record of the chunk is longer than the chunk",
                    ));
                };
                self.at = body.end;
                if matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
                    return Ok(Some(Place { opcode, in_chunk: Some(body) }));
                }
                continue;
            }
            match self.read_record()? {
                None => return Ok(None),
                Some(op::CHUNK) => self.open_chunk()?,
                Some(
                    opcode @ (op::SCHEMA
                    | op::CHANNEL
                    | op::MESSAGE
                    | op::ATTACHMENT
                    | op::METADATA),
                ) => return Ok(Some(Place { opcode, in_chunk: None })),
                Some(_) => {}
            }
        }
    }

    /// The record that [`RawReader::advance`] went to.
    pub(super) fn record(&self, place: &Place) -> Result<RawRecord<'_>, RawError> {
        let body = match &place.in_chunk {
            Some(range) => self.chunk.get(range.clone()),
            None => Some(self.body.as_slice()),
        };
        let parsed = body.and_then(|body| parse(place.opcode, body));
        parsed.ok_or_else(|| damaged(self.offset, "a record has not the form of its kind"))
    }

    /// Reads the next record of the file into `body`: its opcode, or `None` at the end of the data.
    fn read_record(&mut self) -> Result<Option<u8>, RawError> {
        if self.ended {
            return Ok(None);
        }
        self.offset = self.next;
        let offset = self.offset;
        let mut head = [0; 9];
        let read = fill(&mut self.input, &mut head).map_err(RawError::Io)?;
        if read < head.len() {
            self.ended = true;
            return Err(RawError::Truncated { offset });
        }
        let [opcode, len @ ..] = head;
        let len = u64::from_le_bytes(len);
        if matches!(opcode, op::DATA_END | op::FOOTER) {
            self.ended = true;
            self.read_end(opcode, len)?;
            return Ok(None);
        }
        if len > LONGEST || opcode == 0 {
            self.ended = true;
            let what = format!("a record of {len} bytes, kind {opcode:#04x}");
            return Err(RawError::Damaged { offset, what, skippable: false });
        }
        self.body.clear();
        let read = (&mut self.input).take(len).read_to_end(&mut self.body).map_err(RawError::Io)?;
        if (read as u64) < len {
            self.ended = true;
            return Err(RawError::Truncated { offset });
        }
        self.sum.update(&head);
        self.sum.update(&self.body);
        self.next = offset + head.len() as u64 + len;
        Ok(Some(opcode))
    }

    /// Whether reading has come to an end: of the data, or of what can be made out.
    pub(super) fn ended(&self) -> bool {
        self.ended
    }

    /// Whether the end of the data was followed by an index that is whole.
    pub(super) fn finished(&self) -> bool {
        self.finished
    }

    /// Whether the data have the checksum that their end states, or it reports none: also the indexes between chunks, which nothing
    /// else guards.
    pub(super) fn sound(&self) -> bool {
        self.sound
    }

    /// Bytes of the file up to where reading went.
    pub(super) fn position(&self) -> u64 {
        self.next
    }

    /// Reads what follows the data, whose last record has just begun, and checks it.
    fn read_end(&mut self, opcode: u8, len: u64) -> Result<(), RawError> {
        self.body.clear();
        let read =
            (&mut self.input).take(LONGEST).read_to_end(&mut self.body).map_err(RawError::Io)?;
        self.next = self.offset + 9 + read as u64;
        let data_end = usize::try_from(len).ok().filter(|_| opcode == op::DATA_END);
        let stated: Option<[u8; 4]> = data_end.and_then(|_| self.body.first_chunk().copied());
        let stated = stated.map(u32::from_le_bytes);
        self.sound = stated.is_some_and(|crc| crc == 0 || crc == self.sum.clone().finalize());
        self.finished = data_end.and_then(|len| self.body.get(len..)).is_some_and(is_end);
        Ok(())
    }

    /// Decompresses the chunk in `body` and checks it.
    fn open_chunk(&mut self) -> Result<(), RawError> {
        let offset = self.offset;
        self.chunk.clear();
        self.at = 0;
        let damage = |what: &str| damaged(offset, what);
        let Some(RawRecord::Chunk { header, data }) = parse(op::CHUNK, &self.body) else {
            return Err(damage("the chunk has not the form of one"));
        };
        let size = header.uncompressed_size;
        if size > LONGEST {
            return Err(damage("the chunk says it is longer than any chunk"));
        }
        match header.compression.as_str() {
            "" => self.chunk.extend_from_slice(&data),
            "lz4" => {
                let decoder = lz4::Decoder::new(&*data).map_err(RawError::Io)?;
                if decoder.take(size + 1).read_to_end(&mut self.chunk).is_err() {
                    self.chunk.clear();
                    return Err(damage("the chunk cannot be decompressed"));
                }
            }
            other if self.unpack.is_some() => {
                let unpacked = self.unpack.map(|unpack| unpack(other, &data, size)).transpose();
                self.chunk =
                    unpacked.map_err(|error| damage(&error.to_string()))?.unwrap_or_default();
            }
            other => {
                let what = format!("chunks compressed with {other:?}, which gripd does not use");
                return Err(RawError::Damaged { offset, what, skippable: true });
            }
        }
        let (whole, crc) = (self.chunk.len() as u64 == size, header.uncompressed_crc);
        if !whole || (crc != 0 && crc32fast::hash(&self.chunk) != crc) {
            self.chunk.clear();
            return Err(damage("the chunk has not the checksum that it says"));
        }
        Ok(())
    }
}

fn damaged(offset: u64, what: &str) -> RawError {
    RawError::Damaged { offset, what: what.to_owned(), skippable: true }
}

/// Fills `out` as far as the input goes: how far.
fn fill(input: &mut impl Read, out: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while let Some(rest) = out.get_mut(filled..).filter(|rest| !rest.is_empty()) {
        match input.read(rest) {
            Ok(0) => break,
            Ok(read) => filled += read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}

/// Where the index begins, by the last bytes of a file; `None` where they are no end of a file or there is no index.
pub(super) fn footer(tail: &[u8]) -> Option<u64> {
    let rest = tail.strip_suffix(MAGIC)?;
    let (&opcode, record) = rest.get(rest.len().checked_sub(FOOTER)?..)?.split_first()?;
    match parse(opcode, record.get(8..)?)? {
        RawRecord::Footer(footer) => Some(footer.summary_start).filter(|start| *start > 0),
        _ => None,
    }
}

/// The chunks that the bytes from the index on report; `None` where a record is not whole.
pub(super) fn summary_chunks(summary: &[u8]) -> Option<Vec<ChunkIndex>> {
    if !is_end(summary) {
        return None;
    }
    let mut chunks = Vec::new();
    let mut at = 0;
    while at + FOOTER + MAGIC.len() < summary.len() {
        let (opcode, body) = inner_record(summary, at)?;
        at = body.end;
        if opcode == op::CHUNK_INDEX {
            let RawRecord::ChunkIndex(chunk) = parse(opcode, summary.get(body)?)? else {
                return None;
            };
            chunks.push(chunk);
        }
    }
    Some(chunks)
}

/// Bytes of a footer: opcode, length, place of the index, place of its offsets, checksum.
const FOOTER: usize = 9 + 8 + 8 + 4;

/// Whether the bytes after the data are an index with its checksum, the footer and the magic.
fn is_end(bytes: &[u8]) -> bool {
    let whole = || {
        let rest = bytes.strip_suffix(MAGIC)?;
        let footer = rest.get(rest.len().checked_sub(FOOTER)?..)?;
        let (checked, crc) = rest.split_last_chunk::<4>()?;
        let crc = u32::from_le_bytes(*crc);
        let good = crc == 0 || crc == crc32fast::hash(checked);
        Some(good && footer.first() == Some(&op::FOOTER))
    };
    whole().unwrap_or(false)
}

/// Opcode and place of the body of the record that begins at `from`.
fn inner_record(chunk: &[u8], from: usize) -> Option<(u8, core::ops::Range<usize>)> {
    let head: [u8; 9] = *chunk.get(from..)?.first_chunk()?;
    let [opcode, len @ ..] = head;
    let start = from + head.len();
    let end = start.checked_add(usize::try_from(u64::from_le_bytes(len)).ok()?)?;
    (end <= chunk.len()).then_some((opcode, start..end))
}

/// The record in `body`; `None` where it has not the form of its kind.
fn parse(opcode: u8, body: &[u8]) -> Option<RawRecord<'_>> {
    if opcode == op::ATTACHMENT && !may_be_attachment(body) {
        return None;
    }
    mcap::parse_record(opcode, body).ok()
}

/// Whether an attachment has room for its checksum behind times and names, without which `mcap` 0.26 panics.
fn may_be_attachment(body: &[u8]) -> bool {
    let behind_names = body.get(16..).and_then(behind_text).and_then(behind_text);
    behind_names.is_some_and(|rest| rest.len() >= 8 + 4)
}

fn behind_text(from: &[u8]) -> Option<&[u8]> {
    let (len, text) = from.split_first_chunk()?;
    text.get(usize::try_from(u32::from_le_bytes(*len)).ok()?..)
}
