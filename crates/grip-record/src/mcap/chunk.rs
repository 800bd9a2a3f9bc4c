//! The bytes of a chunk, whole or cut off, and the records in it.

use std::io::{self, Read as _};

/// So many zeros at the end of a chunk that is damaged are no data.
pub(super) const ZEROS: usize = 64;

/// Unpacks a chunk that is not compressed, or with lz4, into `chunk` as far as it goes; whether without fault.
pub(super) fn unpack(name: &str, data: &[u8], size: u64, chunk: &mut Vec<u8>) -> io::Result<bool> {
    if name.is_empty() {
        chunk.extend_from_slice(data);
        return Ok(true);
    }
    Ok(lz4::Decoder::new(data)?.take(size + 1).read_to_end(chunk).is_ok())
}

/// Compression, size and data of a chunk whose end is missing.
pub(super) fn cut_chunk(body: &[u8]) -> Option<(&str, u64, &[u8])> {
    let (head, rest) = body.split_first_chunk::<28>()?;
    let size = u64::from_le_bytes(*head.get(16..)?.first_chunk()?);
    let (len, rest) = rest.split_first_chunk()?;
    let (name, rest) = rest.split_at_checked(usize::try_from(u32::from_le_bytes(*len)).ok()?)?;
    Some((core::str::from_utf8(name).ok()?, size, rest.get(8..)?))
}

/// Opcode and place of the body of the record that begins at `from`.
pub(super) fn inner_record(chunk: &[u8], from: usize) -> Option<(u8, core::ops::Range<usize>)> {
    let head: [u8; 9] = *chunk.get(from..)?.first_chunk()?;
    let [opcode, len @ ..] = head;
    let start = from + head.len();
    let end = start.checked_add(usize::try_from(u64::from_le_bytes(len)).ok()?)?;
    (end <= chunk.len()).then_some((opcode, start..end))
}
