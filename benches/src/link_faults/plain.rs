//! Frames in a plain framing, for comparison: COBS, a length, CRC-16 (CCITT, as in many serial protocols), no sequence check.

use core::ops::Range;
use grip_link::cobs;
use grip_sim::line_fault::Faulty;

/// Body before the payload: type, seq and length.
const HEADER: usize = 5;

/// The frames of a stream in the plain framing.
#[derive(Debug)]
pub(super) struct Stream {
    pub(super) bytes: Vec<u8>,
    /// Each block without its delimiters, decoded, and where it stands with them.
    bodies: Vec<(Vec<u8>, Range<usize>)>,
}

impl Stream {
    pub(super) fn of(stream: &super::Stream) -> Self {
        let mut made = Self { bytes: Vec::new(), bodies: Vec::new() };
        for sent in &stream.frames {
            let mut body = vec![sent.header.kind.0];
            body.extend(sent.header.seq.to_le_bytes());
            body.extend(u16::try_from(sent.payload.len()).unwrap_or(0).to_le_bytes());
            body.extend(&sent.payload);
            body.extend(crc16(&body).to_le_bytes());
            let mut block = vec![0; cobs::max_encoded(body.len())];
            let used = cobs::encode(&body, &mut block).unwrap_or(0);
            let start = made.bytes.len();
            made.bytes.push(0);
            made.bytes.extend(block.iter().take(used));
            made.bytes.push(0);
            made.bodies.push((body, start..made.bytes.len()));
        }
        made
    }

    /// Blocks accepted that are no frame sent, or one accepted before.
    pub(super) fn undetected(&self, faulty: &Faulty) -> u64 {
        let mut wrong = 0;
        let mut next = 0;
        for block in faulty.bytes.split(|&byte| byte == 0).filter(|block| !block.is_empty()) {
            let mut block = block.to_vec();
            let Some(body) = cobs::decode_in_place(&mut block).filter(|body| good(body)) else {
                continue;
            };
            match self.bodies.iter().position(|(sent, _)| sent == body) {
                Some(index) if index >= next => next = index + 1,
                _ => wrong += 1,
            }
        }
        wrong
    }
}

fn good(body: &[u8]) -> bool {
    let Some((covered, crc)) = body.split_last_chunk::<2>() else { return false };
    let Some([_, _, _, low, high]) = covered.first_chunk::<HEADER>() else { return false };
    let len = usize::from(u16::from_le_bytes([*low, *high]));
    len == covered.len() - HEADER && crc16(covered) == u16::from_le_bytes(*crc)
}

/// CRC-16/IBM-3740 ("CCITT-FALSE"): polynomial 1021, start FFFF.
fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, &byte| {
        let slot = usize::from(crc.to_be_bytes()[0] ^ byte);
        crc << 8 ^ TABLE.get(slot).copied().unwrap_or(0)
    })
}

const TABLE: [u16; 256] = table();

const fn table() -> [u16; 256] {
    let mut table = [0; 256];
    let mut slot = 0;
    let mut value: u16 = 0;
    while slot < 256 {
        let mut crc = value << 8;
        let mut bit = 0;
        while bit < 8 {
            crc = if crc & 0x8000 == 0 { crc << 1 } else { crc << 1 ^ 0x1021 };
            bit += 1;
        }
        table[slot] = crc;
        slot += 1;
        value += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link_faults::Traffic;
    use grip_link::frame::Direction;

    #[test]
    fn check_value_of_the_polynomial() {
        assert_eq!(crc16(b"123456789"), 0x29B1);
    }

    #[test]
    fn undamaged_frames_pass_and_a_doubled_one_is_taken_twice() {
        let plain = Stream::of(&Traffic::new(3).stream(Direction::ToHost, 5).unwrap());
        let whole = Faulty { bytes: plain.bytes.clone(), touched: 0..0, put: 0 };
        assert_eq!(plain.undetected(&whole), 0);
        let again = plain.bodies[1].1.clone();
        let at = plain.bodies[3].1.start;
        let bytes = [&plain.bytes[..at], &plain.bytes[again.clone()], &plain.bytes[at..]].concat();
        let doubled = Faulty { bytes, touched: at..at, put: again.len() };
        assert_eq!(plain.undetected(&doubled), 1);
    }
}
