//! Chunks of an MCAP file that are compressed with zstd, whole or cut off.

use grip_record::mcap::no_unpack;
use std::io::{self, Read as _};

/// Decompresses chunks with zstd, for readers of MCAP; of one that is cut off or damaged as many whole blocks as there are.
///
/// # Errors
/// Where the compression is another one, or the bytes do not begin as zstd.
pub fn unpack(name: &str, packed: &[u8], size: u64) -> io::Result<Vec<u8>> {
    if name != "zstd" {
        return no_unpack(name, packed, size);
    }
    let no_zstd = |error| io::Error::other(format!("the chunk is no zstd: {error}"));
    let mut unpacked = Vec::new();
    let decoder = ruzstd::decoding::StreamingDecoder::new(packed).map_err(no_zstd)?;
    if decoder.take(size + 1).read_to_end(&mut unpacked).is_err() {
        // The decoder keeps its window back until the frame ends.
        let ended = ended_early(packed);
        let decoder = ruzstd::decoding::StreamingDecoder::new(&*ended).map_err(no_zstd)?;
        unpacked.clear();
        // What came before a damaged block is of use.
        let _damaged = decoder.take(size + 1).read_to_end(&mut unpacked);
    }
    Ok(unpacked)
}

/// The frame up to its last block that is whole, with an empty one as its end (RFC 8878, 3.1.1).
fn ended_early(packed: &[u8]) -> Vec<u8> {
    const LAST: [u8; 3] = [1, 0, 0];
    let descriptor = packed.get(4).copied().unwrap_or(0);
    let single = usize::from(descriptor >> 5 & 1);
    let content_size = [single, 2, 4, 8][usize::from(descriptor >> 6)];
    let mut end = 5 + (1 - single) + [0, 1, 2, 4][usize::from(descriptor & 3)] + content_size;
    while let Some(&[a, b, c]) = packed.get(end..).and_then(|rest| rest.first_chunk()) {
        let head = usize::from(a) | usize::from(b) << 8 | usize::from(c) << 16;
        // Of a run only its byte is there.
        let len = if head >> 1 & 3 == 1 { 1 } else { head >> 3 };
        if end + 3 + len > packed.len() || head & 1 == 1 {
            break;
        }
        end += 3 + len;
    }
    let checksum = if descriptor & 4 == 0 { 0 } else { 4 };
    let frame = packed.get(..end).unwrap_or(packed);
    [frame, &LAST, &[0; 4][..checksum]].concat()
}

#[cfg(test)]
mod tests {
    use super::unpack;

    #[test]
    fn a_cut_frame_gives_its_whole_blocks() {
        // Numbers that compress a little, over several blocks of 128 KiB.
        let plain: Vec<u8> = (0..600_000_u32)
            .map(|n| u8::try_from((n.wrapping_mul(n) >> 7) & 0x3F).unwrap())
            .collect();
        let level = ruzstd::encoding::CompressionLevel::Fastest;
        let packed = ruzstd::encoding::compress_to_vec(&*plain, level);
        let size = plain.len() as u64;
        assert_eq!(unpack("zstd", &packed, size).unwrap(), plain);
        let mut most = 0;
        for len in (0..packed.len()).step_by(1009) {
            let found = unpack("zstd", &packed[..len], size).unwrap_or_default();
            assert!(plain.starts_with(&found) && found.len() >= most, "{len}");
            most = found.len();
        }
        assert!(most > 400_000, "{most}");
        assert!(unpack("zstd", b"no frame", 10).is_err() && unpack("xz", &packed, size).is_err());
    }
}
