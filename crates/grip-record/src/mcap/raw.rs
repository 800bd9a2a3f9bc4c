//! Reader of the records of an MCAP file with their offsets; nothing in a file makes this panic, or take more than
//! [`LONGEST`] bytes for a record or for a chunk.
//!
//! Layout of the format: mcap.dev/spec. A file is magic, records (one byte of opcode, eight of length, a body), magic. A chunk
//! is a record that holds records, compressed. What a record holds is read by the crate `mcap`.

use super::chunk::{ZEROS, cut_chunk, inner_record, unpack};
use mcap::MAGIC;
use mcap::records::{ChunkIndex, Header, Record as RawRecord, op};
use std::io::{self, Read, Seek, SeekFrom};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::{self, JoinHandle};

/// The longest record, and the longest chunk after decompression, that is believed (bytes); far above what any recorder writes.
pub(super) const LONGEST: u64 = 64 << 20;

/// Decompresses a chunk: the name of the compression, its bytes and the size that they must unpack to in, those bytes out. Where the chunk
/// is cut off or damaged, as many of them as can be made out.
pub type Unpack = fn(&str, &[u8], u64) -> io::Result<Vec<u8>>;

/// Where reading stopped.
#[derive(Debug)]
pub(super) enum RawError {
    Io(io::Error),
    NoMcap,
    /// A compression that gripd does not use, and others do.
    Zstd,
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

/// A record of the file as it was read, a chunk decompressed, and how far reading had come.
#[derive(Debug, Default)]
struct Piece {
    /// Where it begins in the file.
    offset: u64,
    /// Where the next one begins.
    next: u64,
    body: Vec<u8>,
    /// The records of a chunk; empty where it is none.
    chunk: Vec<u8>,
    /// Whether reading has come to an end: of the data, or of what can be made out.
    ended: bool,
    /// Whether the end of the data was followed by an index that is whole.
    finished: bool,
    /// Whether the data have the checksum that their end states.
    sound: bool,
    /// Whether `chunk` has the beginning only: the file ends within it, or what follows in it is zeros.
    cut: bool,
}

/// Reads a file piece by piece, from its start to the end of its data.
#[derive(Debug)]
struct Pieces<R> {
    input: R,
    /// Where the next record of the file begins.
    next: u64,
    ended: bool,
    /// Over every byte up to the end of the data.
    sum: crc32fast::Hasher,
    /// For compressions that gripd does not use.
    unpack: Option<Unpack>,
}

/// Where pieces come from.
#[derive(Debug)]
enum Source<R> {
    Here(Pieces<R>),
    /// A thread reads and decompresses while the one that asks uses what is there already.
    Ahead(Ahead<R>),
    /// The thread is gone: it gives nothing back where it panicked.
    Gone,
}

#[derive(Debug)]
struct Ahead<R> {
    read: Receiver<(Piece, Result<Option<u8>, RawError>)>,
    /// Pieces that were used, for their memory.
    used: Sender<Piece>,
    thread: JoinHandle<Pieces<R>>,
}

/// Pieces that wait until they are asked for.
const AHEAD: usize = 1;

/// The records of a file, those in its chunks too.
#[derive(Debug)]
pub(super) struct RawReader<R> {
    source: Source<R>,
    /// The present record of the file, and how far its chunk has been read.
    piece: Piece,
    at: usize,
    /// What the file states of its writer.
    header: Header,
}

impl<R: Read + Seek> RawReader<R> {
    /// Goes to the record of the file that begins at `offset`, and reads here from then on. Whether the data are sound as a whole is not known any more.
    pub(super) fn jump(&mut self, offset: u64) -> Result<(), RawError> {
        let mut pieces = match core::mem::replace(&mut self.source, Source::Gone) {
            Source::Here(pieces) => pieces,
            Source::Ahead(ahead) => ahead.stop()?,
            Source::Gone => return Err(gone()),
        };
        let sought = pieces.input.seek(SeekFrom::Start(offset));
        // Where that failed nobody knows where the input stands.
        (pieces.next, pieces.ended) = (offset, sought.is_err());
        self.source = Source::Here(pieces);
        self.piece.chunk.clear();
        (self.piece.next, self.piece.ended, self.at) = (offset, sought.is_err(), 0);
        sought.map(drop).map_err(RawError::Io)
    }
}

impl<R: Read + Send + 'static> RawReader<R> {
    /// The same file, read and decompressed in a thread of its own: worth it where all of it is read.
    pub(super) fn read_ahead(self) -> Result<Self, RawError> {
        let Source::Here(mut pieces) = self.source else { return Ok(self) };
        let (send, read) = mpsc::sync_channel(AHEAD);
        let (used, again) = mpsc::channel();
        let work = move || {
            loop {
                let mut piece: Piece = again.try_recv().unwrap_or_default();
                let found = pieces.read(&mut piece);
                let ended = piece.ended;
                if send.send((piece, found)).is_err() || ended {
                    return pieces;
                }
            }
        };
        let thread = thread::Builder::new().name("mcap".to_owned()).spawn(work);
        let thread = thread.map_err(RawError::Io)?;
        Ok(Self { source: Source::Ahead(Ahead { read, used, thread }), ..self })
    }
}

impl<R> Ahead<R> {
    fn next(&self, piece: &mut Piece) -> Result<Option<u8>, RawError> {
        let Ok((read, found)) = self.read.recv() else {
            piece.ended = true;
            return Err(gone());
        };
        // The thread may have ended.
        let _ended = self.used.send(core::mem::replace(piece, read));
        found
    }

    /// What the thread read from, wherever it stands now.
    fn stop(self) -> Result<Pieces<R>, RawError> {
        let Self { read, thread, .. } = self;
        drop(read);
        thread.join().map_err(|_| gone())
    }
}

fn gone() -> RawError {
    RawError::Io(io::Error::other("the thread that reads the file has ended"))
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
        let source = Source::Here(Pieces { input, next, ended: false, sum, unpack: None });
        let header = Header { profile: String::new(), library: String::new() };
        Ok(Self { source, piece: Piece { next, ..Piece::default() }, at: 0, header })
    }

    /// The same with one more way to decompress a chunk. A chunk in which the file ends is read too, as far as it goes.
    pub(super) fn with_unpack(mut self, unpack: Unpack) -> Self {
        if let Source::Here(pieces) = &mut self.source {
            pieces.unpack = Some(unpack);
        }
        self
    }

    /// Where in the file the present record, or the chunk that holds it, begins.
    pub(super) fn offset(&self) -> u64 {
        self.piece.offset
    }

    /// What the file states of its writer, from the first record on.
    pub(super) fn header(&self) -> &Header {
        &self.header
    }

    /// Whether the present chunk has its beginning only.
    pub(super) fn is_cut(&self) -> bool {
        self.piece.cut
    }

    /// Whether the present chunk holds more records.
    pub(super) fn chunk_goes_on(&self) -> bool {
        self.at < self.piece.chunk.len()
    }

    /// Goes to the next record that matters; `None` at the end of the data. After [`RawError::Damaged`] that is `skippable` the
    /// records behind the damage follow.
    pub(super) fn advance(&mut self) -> Result<Option<Place>, RawError> {
        loop {
            if self.chunk_goes_on() {
                let Some((opcode, body)) = inner_record(&self.piece.chunk, self.at) else {
                    self.at = self.piece.chunk.len();
                    if self.piece.cut {
                        continue;
                    }
                    return Err(damaged(
                        self.piece.offset,
                        "a record of the chunk is longer than the chunk",
                    ));
                };
                self.at = body.end;
                if matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
                    return Ok(Some(Place { opcode, in_chunk: Some(body) }));
                }
                continue;
            }
            if core::mem::take(&mut self.piece.cut) {
                let offset = self.piece.offset;
                if self.piece.next > offset {
                    return Err(damaged(offset, "the chunk ends in zeros"));
                }
                self.piece.ended = true;
                return Err(RawError::Truncated { offset });
            }
            match self.next_piece()? {
                None => return Ok(None),
                Some(op::HEADER) => {
                    if let Some(RawRecord::Header(header)) = parse(op::HEADER, &self.piece.body) {
                        self.header = header;
                    }
                }
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
        let parsed = self.body(place).and_then(|body| parse(place.opcode, body));
        parsed.ok_or_else(|| damaged(self.piece.offset, "a record has not the form of its kind"))
    }

    /// The message that [`RawReader::advance`] went to: its channel, its log time (ns since 1970), its bytes.
    pub(super) fn message(&self, place: &Place) -> Result<(u16, u64, &[u8]), RawError> {
        let parsed = self.body(place).and_then(message);
        parsed.ok_or_else(|| damaged(self.piece.offset, "a record has not the form of its kind"))
    }

    fn body(&self, place: &Place) -> Option<&[u8]> {
        match &place.in_chunk {
            Some(range) => self.piece.chunk.get(range.clone()),
            None => Some(&self.piece.body),
        }
    }

    fn next_piece(&mut self) -> Result<Option<u8>, RawError> {
        if self.piece.ended {
            return Ok(None);
        }
        self.at = 0;
        match &mut self.source {
            Source::Here(pieces) => pieces.read(&mut self.piece),
            Source::Ahead(ahead) => ahead.next(&mut self.piece),
            Source::Gone => {
                self.piece.ended = true;
                Err(gone())
            }
        }
    }

    /// Whether reading has come to an end: of the data, or of what can be made out.
    pub(super) fn ended(&self) -> bool {
        self.piece.ended
    }

    /// Whether the end of the data was followed by an index that is whole.
    pub(super) fn finished(&self) -> bool {
        self.piece.finished
    }

    /// Whether the data have the checksum that their end states, or it reports none: also the indexes between chunks, which nothing
    /// else guards.
    pub(super) fn sound(&self) -> bool {
        self.piece.sound
    }

    /// Bytes of the file up to where reading went.
    pub(super) fn position(&self) -> u64 {
        self.piece.next
    }
}

impl<R: Read> Pieces<R> {
    /// Reads the next record of the file into `piece`, a chunk decompressed: its opcode, or `None` at the end of the data.
    fn read(&mut self, piece: &mut Piece) -> Result<Option<u8>, RawError> {
        piece.body.clear();
        piece.chunk.clear();
        (piece.finished, piece.sound, piece.cut) = (false, false, false);
        piece.offset = self.next;
        let read = match self.record(piece) {
            Ok(Some(op::CHUNK)) if !piece.cut => match self.open_chunk(piece) {
                // Blocks that never reached the disk read as zeros.
                Err(_) if self.cut_zeros(piece) => Ok(Some(op::CHUNK)),
                opened => opened.map(|()| Some(op::CHUNK)),
            },
            other => other,
        };
        // The end of a cut chunk comes behind its records.
        (piece.next, piece.ended) = (self.next, self.ended && !piece.cut);
        read
    }

    fn record(&mut self, piece: &mut Piece) -> Result<Option<u8>, RawError> {
        if self.ended {
            return Ok(None);
        }
        let offset = piece.offset;
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
            self.read_end(opcode, len, piece)?;
            return Ok(None);
        }
        if len > LONGEST || opcode == 0 {
            self.ended = true;
            let what = format!("a record of {len} bytes, kind {opcode:#04x}");
            return Err(RawError::Damaged { offset, what, skippable: false });
        }
        let body = &mut piece.body;
        let read = (&mut self.input).take(len).read_to_end(body).map_err(RawError::Io)?;
        if (read as u64) < len {
            self.ended = true;
            piece.cut = opcode == op::CHUNK && self.open_cut(piece);
            return if piece.cut { Ok(Some(opcode)) } else { Err(RawError::Truncated { offset }) };
        }
        self.sum.update(&head);
        self.sum.update(body);
        self.next = offset + head.len() as u64 + len;
        Ok(Some(opcode))
    }

    /// Reads what follows the data, whose last record has just begun, and checks it.
    fn read_end(&mut self, opcode: u8, len: u64, piece: &mut Piece) -> Result<(), RawError> {
        let body = &mut piece.body;
        let read = (&mut self.input).take(LONGEST).read_to_end(body).map_err(RawError::Io)?;
        self.next = piece.offset + 9 + read as u64;
        let data_end = usize::try_from(len).ok().filter(|_| opcode == op::DATA_END);
        let stated: Option<[u8; 4]> = data_end.and_then(|_| body.first_chunk().copied());
        let stated = stated.map(u32::from_le_bytes);
        piece.sound = stated.is_some_and(|crc| crc == 0 || crc == self.sum.clone().finalize());
        piece.finished = data_end.and_then(|len| body.get(len..)).is_some_and(is_end);
        Ok(())
    }

    /// Decompresses the chunk in the body of `piece` and checks it.
    fn open_chunk(&self, piece: &mut Piece) -> Result<(), RawError> {
        let Piece { offset, body, chunk, .. } = piece;
        let damage = |what: &str| damaged(*offset, what);
        let Some(RawRecord::Chunk { header, data }) = parse(op::CHUNK, body) else {
            return Err(damage("the chunk has not the form of one"));
        };
        let size = header.uncompressed_size;
        if size > LONGEST {
            return Err(damage("the chunk states that it is longer than any chunk"));
        }
        match header.compression.as_str() {
            "" | "lz4" => {
                if !unpack(&header.compression, &data, size, chunk).map_err(RawError::Io)? {
                    chunk.clear();
                    return Err(damage("the chunk cannot be decompressed"));
                }
            }
            "zstd" if self.unpack.is_none() => return Err(RawError::Zstd),
            other => match self.unpack {
                Some(unpack) => {
                    *chunk =
                        unpack(other, &data, size).map_err(|error| damage(&error.to_string()))?;
                }
                None => {
                    let what =
                        format!("chunks compressed with {other:?}, which gripd does not use");
                    return Err(RawError::Damaged { offset: *offset, what, skippable: true });
                }
            },
        }
        let (whole, crc) = (chunk.len() as u64 == size, header.uncompressed_crc);
        if !whole || (crc != 0 && crc32fast::hash(chunk) != crc) {
            chunk.clear();
            return Err(damage("the chunk has not the checksum that it states"));
        }
        Ok(())
    }

    /// Decompresses what is there of a chunk, up to where its bytes are zeros to its end; whether that could be done.
    fn cut_zeros(&self, piece: &mut Piece) -> bool {
        let used = piece.body.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
        if piece.body.len() - used < ZEROS {
            return false;
        }
        piece.body.truncate(used);
        piece.cut = self.open_cut(piece);
        piece.cut
    }

    /// Decompresses the beginning of a chunk, as far as the body of `piece` goes; whether that could be done.
    fn open_cut(&self, piece: &mut Piece) -> bool {
        let (Some(other), Some((name, size, data))) = (self.unpack, cut_chunk(&piece.body)) else {
            return false;
        };
        let size = size.min(LONGEST);
        match name {
            "" | "lz4" => unpack(name, data, size, &mut piece.chunk).is_ok(),
            name => other(name, data, size).map(|chunk| piece.chunk = chunk).is_ok(),
        }
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

/// The record in `body`; `None` where it has not the form of its kind.
fn parse(opcode: u8, body: &[u8]) -> Option<RawRecord<'_>> {
    if opcode == op::ATTACHMENT && !may_be_attachment(body) {
        return None;
    }
    mcap::parse_record(opcode, body).ok()
}

/// Channel, log time and bytes of the message in `body`, as `mcap` reads them, in fewer instructions.
fn message(body: &[u8]) -> Option<(u16, u64, &[u8])> {
    let (channel, rest) = body.split_first_chunk()?;
    let (_sequence, rest) = rest.split_first_chunk::<4>()?;
    let (log, rest) = rest.split_first_chunk()?;
    let (_published, data) = rest.split_first_chunk::<8>()?;
    Some((u16::from_le_bytes(*channel), u64::from_le_bytes(*log), data))
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

#[cfg(test)]
mod tests {
    use super::{MAGIC, RawError, RawReader, RawRecord, message, op, parse};
    use std::io::{self, Cursor, Read, Seek, SeekFrom};

    struct Unseekable(Cursor<&'static [u8]>);

    impl Read for Unseekable {
        fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
            self.0.read(out)
        }
    }

    impl Seek for Unseekable {
        fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
            Err(io::ErrorKind::NotSeekable.into())
        }
    }

    #[test]
    fn where_seeking_fails_reading_has_ended() {
        let reader = || RawReader::new(Unseekable(Cursor::new(MAGIC))).unwrap();
        for mut reader in [reader(), reader().read_ahead().unwrap()] {
            assert!(matches!(reader.jump(8), Err(RawError::Io(_))));
            assert!(reader.ended() && matches!(reader.advance(), Ok(None)));
        }
    }

    #[test]
    fn a_message_is_read_as_mcap_reads_it() {
        let bytes: Vec<u8> = (3..60).collect();
        for len in 0..bytes.len() {
            let body = &bytes[..len];
            let theirs = match parse(op::MESSAGE, body) {
                Some(RawRecord::Message { header, data }) => {
                    Some((header.channel_id, header.log_time, data.into_owned()))
                }
                _ => None,
            };
            let ours = message(body).map(|(channel, log, data)| (channel, log, data.to_vec()));
            assert_eq!(ours, theirs, "{len}");
        }
    }
}
