//! A WAV file in (RIFF, RIFX, RF64, BW64, Wave64): one signal a channel, as share of full scale.

use crate::error::ImportError;
use grip_record::{Cell, Coding, NumberColumn, NumberTable, Strand, files};
use std::{
    fs::File,
    io::{BufReader, Read as _, Seek as _, SeekFrom},
    path::Path,
};

/// Most channels that are read, and chunks that are passed over.
const MOST_CHANNELS: usize = 256;
const MOST_CHUNKS: usize = 10_000;
/// From here on a length is what a program writes that does not know it: 2^31 less a page, 2^31, 2^32 - 1.
const NO_LENGTH: u64 = 0x7fff_f000;
/// What follows `wave`, `fmt ` and `data` in the names of Wave64.
const W64: [u8; 8] = [0xf3, 0xac, 0xd3, 0x11, 0x8c, 0xd1, 0x00, 0xc0];

/// What stands in the header.
struct Header {
    rate_hz: u32,
    channels: usize,
    /// Bytes of a sample of all channels.
    frame: usize,
    cell: Cell,
    kind: String,
}

/// How chunks are written.
#[derive(Clone, Copy)]
enum Chunks {
    /// Names of 4 and lengths of 4 bytes, at even places.
    Riff { big_endian: bool },
    /// Names of 16 and lengths of 8 bytes, at multiples of 8; the length counts both.
    W64,
}

struct Chunk {
    name: [u8; 4],
    /// Place and length of the content.
    at: u64,
    length: u64,
}

struct Reader {
    input: BufReader<File>,
    length: u64,
    chunks: Chunks,
}

pub(crate) fn read(file: &Path) -> Result<NumberTable, ImportError> {
    let input = files::open(file).map_err(ImportError::unreadable(file))?;
    let length = input.metadata().map_err(ImportError::unreadable(file))?.len();
    let mut reader =
        Reader { input: BufReader::new(input), length, chunks: Chunks::Riff { big_endian: false } };
    let no_wav = |what: String| ImportError::nothing(file, &what);
    let (header, mut table) = reader.table(file).map_err(no_wav)?;
    let rate = f64::from(header.rate_hz);
    let place = match header.rate_hz {
        0 => "its header states 0 samples a second".to_owned(),
        rate_hz => format!("the header: {rate_hz} Hz, {}", header.kind),
    };
    #[expect(clippy::cast_possible_truncation, reason = "a rate has 24 bits")]
    let rate_hz = rate as f32;
    (table.rate_hz, table.clock, table.named) = (Some(rate_hz), place, false);
    Ok(table)
}

impl Reader {
    /// The header, and where the samples lie.
    fn table(&mut self, file: &Path) -> Result<(Header, NumberTable), String> {
        let mut at = self.begin()?;
        let (mut header, mut data, mut long, mut more) = (None, None, None, 0_u64);
        for _ in 0..MOST_CHUNKS {
            let Some(chunk) = self.chunk(at) else { break };
            at = chunk.at.saturating_add(chunk.length);
            match &chunk.name {
                b"fmt " if header.is_none() => header = Some(self.header(&chunk, file)?),
                b"ds64" => long = Some(u64::from_le_bytes(self.bytes(chunk.at + 8)?)),
                b"data" if data.is_none() => {
                    let length = self.data_length(&chunk, long);
                    at = chunk.at.saturating_add(length.0);
                    data = Some((chunk.at, length));
                }
                b"data" => more = more.saturating_add(chunk.length),
                _ => {}
            }
            at = self.padded(at);
        }
        let cut = "was cut off, or is none";
        let (start, (length, announced)) =
            data.ok_or_else(|| format!("has no sample: it {cut}"))?;
        let header = header.ok_or_else(|| format!("does not state its format: it {cut}"))?;
        let mut table = NumberTable::new(file);
        table.strands.push(Strand { offset: start, frame: header.frame, packed: None });
        table.rows = length / header.frame as u64;
        if table.rows == 0 {
            return Err(format!("has no sample: it {cut}"));
        }
        for k in 0..header.channels {
            let cell = Cell { at: k * header.cell.size, ..header.cell };
            let name = format!("channel_{}", k + 1);
            let unit = Some("share of full scale");
            table.columns.push(NumberColumn { name, strand: 0, cell, unit, is_time: false });
        }
        let rows = |bytes: u64| bytes.div_ceil(header.frame as u64);
        table.cut = match announced {
            Some(announced) if length < announced => {
                Some(format!("cut off: {} of {} samples are there", table.rows, rows(announced)))
            }
            _ if more > 0 => Some(format!("{} samples in further chunks, not read", rows(more))),
            _ => None,
        };
        if announced.is_none() {
            let note = "its header states no length (written to a pipe, or by a program that was killed): read to its end";
            table.notes.push(note.to_owned());
        }
        Ok((header, table))
    }

    /// Finds what kind of file it is; where its chunks begin.
    fn begin(&mut self) -> Result<u64, String> {
        let mut start = 0;
        let mut magic: [u8; 16] = self.bytes(0)?;
        if magic.starts_with(b"ID3") {
            // A tag before everything; its length has 7 bits a byte.
            let size = magic[6..10].iter().fold(0, |all, byte| all << 7 | u64::from(byte & 127));
            start = 10 + size;
            magic = self.bytes(start)?;
        }
        self.chunks = match &magic[..4] {
            b"RIFF" | b"RF64" | b"BW64" => Chunks::Riff { big_endian: false },
            b"RIFX" => Chunks::Riff { big_endian: true },
            b"riff" => Chunks::W64,
            _ => {
                return Err(
                    "is no WAV file: it begins with neither RIFF, RIFX, RF64, BW64 nor riff"
                        .to_owned(),
                );
            }
        };
        let (kind, chunks) = match self.chunks {
            Chunks::Riff { .. } => (8, 12),
            Chunks::W64 => (24, 40),
        };
        let wave: [u8; 4] = self.bytes(start + kind)?;
        if !wave.eq_ignore_ascii_case(b"wave") {
            return Err(format!(
                "is no WAV file, but RIFF of {:?}",
                String::from_utf8_lossy(&wave)
            ));
        }
        Ok(start + chunks)
    }

    /// The chunk that begins at `at`; `None` behind the last one.
    fn chunk(&mut self, at: u64) -> Option<Chunk> {
        match self.chunks {
            Chunks::Riff { big_endian } => {
                let [a, b, c, d, length @ ..]: [u8; 8] = self.bytes(at).ok()?;
                let length = if big_endian {
                    u32::from_be_bytes(length)
                } else {
                    u32::from_le_bytes(length)
                };
                Some(Chunk { name: [a, b, c, d], at: at + 8, length: u64::from(length) })
            }
            Chunks::W64 => {
                let name: [u8; 16] = self.bytes(at).ok()?;
                let length = u64::from_le_bytes(self.bytes(at + 16).ok()?);
                let known = name[4..12] == W64;
                let name = if known { [name[0], name[1], name[2], name[3]] } else { [0; 4] };
                Some(Chunk { name, at: at + 24, length: length.saturating_sub(24) })
            }
        }
    }

    /// Where the next chunk begins behind one that ends at `at`.
    fn padded(&mut self, at: u64) -> u64 {
        match self.chunks {
            Chunks::W64 => at.checked_next_multiple_of(8).unwrap_or(at),
            Chunks::Riff { .. } if at.is_multiple_of(2) => at,
            // Some programs leave the byte out.
            Chunks::Riff { .. } => match self.bytes(at) {
                Ok(name) if [*b"fmt ", *b"data", *b"fact", *b"LIST"].contains(&name) => at,
                _ => at + 1,
            },
        }
    }

    /// Bytes of samples that are there, and as many as the header states where it knows.
    fn data_length(&mut self, chunk: &Chunk, long: Option<u64>) -> (u64, Option<u64>) {
        let left = self.length.saturating_sub(chunk.at);
        let length = match (self.chunks, long) {
            (Chunks::Riff { .. }, Some(long)) if chunk.length == u64::from(u32::MAX) => long,
            _ => chunk.length,
        };
        let streamed = match length {
            // Nothing, with another chunk behind it or the end; or nothing yet.
            0 => left > 0 && !self.is_chunk(chunk.at),
            length => length > left && (NO_LENGTH..=u64::from(u32::MAX)).contains(&length),
        };
        if streamed { (left, None) } else { (length.min(left), Some(length)) }
    }

    /// Whether a name of letters and a length that fits stand at `at`.
    fn is_chunk(&mut self, at: u64) -> bool {
        let found = self.chunk(at);
        found.is_some_and(|chunk| {
            chunk.name.iter().all(|byte| (b' '..=b'~').contains(byte))
                && chunk.at.saturating_add(chunk.length) <= self.length
        })
    }

    fn header(&mut self, chunk: &Chunk, file: &Path) -> Result<Header, String> {
        let big_endian = matches!(self.chunks, Chunks::Riff { big_endian: true });
        let word = |bytes: [u8; 2]| {
            if big_endian { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) }
        };
        let [tag, channels, _, _, _, _, frame, bits] = {
            let bytes: [u8; 16] = self.bytes(chunk.at)?;
            let mut words = [0; 8];
            for (place, pair) in words.iter_mut().zip(bytes.as_chunks::<2>().0) {
                *place = word(*pair);
            }
            words
        };
        let rate = self.bytes(chunk.at + 4)?;
        let rate_hz = if big_endian { u32::from_be_bytes(rate) } else { u32::from_le_bytes(rate) };
        // The format of an extensible header stands in its sub-format.
        let tag = if tag == 0xfffe { word(self.bytes(chunk.at + 24)?) } else { tag };
        let channels = usize::from(channels);
        if !(1..=MOST_CHANNELS).contains(&channels) {
            return Err(format!("has {channels} channels; 1 to {MOST_CHANNELS} are read"));
        }
        let bits = usize::from(bits);
        let frame = if frame == 0 { channels * bits.div_ceil(8) } else { usize::from(frame) };
        let size = frame / channels;
        let (coding, zero, kind) = match (tag, size) {
            (1, 1) => (Coding::Unsigned, 128, "integers"),
            (1, 2..=8) => (Coding::Signed, 0, "integers"),
            (3, 4 | 8) => (Coding::Float, 0, "floats"),
            (6, 1) => (Coding::ALaw, 0, "A-law"),
            (7, 1) => (Coding::MuLaw, 0, "mu-law"),
            _ => return Err(not_read(tag, size, file)),
        };
        let scale = match coding {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_possible_wrap,
                reason = "1 to 8"
            )]
            Coding::Signed | Coding::Unsigned => 2.0_f64.powi(1 - 8 * size as i32),
            _ => 1.0,
        };
        let cell = Cell { zero, scale, ..Cell::new(0, size, coding, big_endian) };
        let kind = format!("{kind} of {bits} bits");
        Ok(Header { rate_hz, channels, frame, cell, kind })
    }

    /// So many bytes from `at` on.
    fn bytes<const N: usize>(&mut self, at: u64) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        let read =
            self.input.seek(SeekFrom::Start(at)).and_then(|_| self.input.read_exact(&mut bytes));
        read.map(|()| bytes).map_err(|_| "ends within its header".to_owned())
    }
}

/// What a format is whose samples are not read.
fn not_read(tag: u16, size: usize, file: &Path) -> String {
    let name = match tag {
        1 | 3 => return format!("has samples of {size} bytes in format {tag}, which is not read"),
        2 => "MS ADPCM",
        0x11 => "IMA ADPCM",
        0x31 => "GSM 6.10",
        0x40 | 0x45 => "G.721",
        0x50 | 0x55 => "MPEG",
        _ => "unknown",
    };
    format!(
        "is compressed (format {tag:#06x}, {name}); unpack it and import that: \
         `ffmpeg -i '{}' -c:a pcm_f32le '{}'`",
        file.display(),
        file.with_extension("plain.wav").display()
    )
}
