//! Index at the end of an MCAP file: the places and times of its chunks, needed to look into the middle of a large recording.

use super::raw::{LONGEST, footer, summary_chunks};
use mcap::records::ChunkIndex;
use std::io::{self, Read, Seek, SeekFrom};

/// Bytes at the end of a file that hold its footer.
const TAIL: u64 = 64;

/// A chunk of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChunkPlace {
    /// Where it begins (bytes from the start of the file).
    pub offset: u64,
    /// Bytes that it takes in the file.
    pub len: u64,
    /// Log time of its first message (ns since 1970).
    pub from_ns: u64,
    /// Log time of its last message (ns since 1970).
    pub to_ns: u64,
}

/// Where the chunks of a recording stand, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct McapIndex {
    /// The chunks.
    pub chunks: Vec<ChunkPlace>,
}

impl McapIndex {
    /// Reads the index of a finished file; `None` where there is none that can be believed, as in a file that was cut off. `input` stands
    /// anywhere afterwards.
    ///
    /// # Errors
    /// Where the input cannot be read.
    pub fn read(mut input: impl Read + Seek) -> io::Result<Option<Self>> {
        let len = input.seek(SeekFrom::End(0))?;
        let tail = read_at(&mut input, len.saturating_sub(TAIL), TAIL.min(len))?;
        let Some(start) = footer(&tail).filter(|start| (1..len).contains(start)) else {
            return Ok(None);
        };
        if len - start > LONGEST {
            return Ok(None);
        }
        let summary = read_at(&mut input, start, len - start)?;
        let believable = |chunk: &ChunkIndex| {
            chunk.chunk_start_offset.checked_add(chunk.chunk_length).is_some_and(|end| end <= start)
        };
        let Some(mut chunks) = summary_chunks(&summary) else { return Ok(None) };
        if !chunks.iter().all(believable) {
            return Ok(None);
        }
        chunks.sort_by_key(|chunk| chunk.chunk_start_offset);
        let place = |chunk: &ChunkIndex| ChunkPlace {
            offset: chunk.chunk_start_offset,
            len: chunk.chunk_length,
            from_ns: chunk.message_start_time,
            to_ns: chunk.message_end_time,
        };
        Ok(Some(Self { chunks: chunks.iter().map(place).collect() }))
    }
}

fn read_at(input: &mut (impl Read + Seek), from: u64, len: u64) -> io::Result<Vec<u8>> {
    input.seek(SeekFrom::Start(from))?;
    let mut bytes = Vec::new();
    input.take(len).read_to_end(&mut bytes)?;
    Ok(bytes)
}
