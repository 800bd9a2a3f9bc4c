//! Byte slices in, their CRC-32C (Castagnoli) out.
//!
//! Reflected polynomial `82F63B78`, initial value and final xor `FFFFFFFF`; the check value of
//! `123456789` is `E3069283`. The Hamming distance is 6 up to 655 bytes, which covers the longest frame body
//! (P. Koopman, "32-bit cyclic redundancy codes for Internet applications", 2002).

const POLYNOMIAL: u32 = 0x82F6_3B78;

const fn one_byte(index: u32) -> u32 {
    let mut crc = index;
    let mut bit = 0;
    while bit < 8 {
        crc = if crc & 1 == 1 { (crc >> 1) ^ POLYNOMIAL } else { crc >> 1 };
        bit += 1;
    }
    crc
}

const fn byte_table() -> [u32; 256] {
    let mut table = [0; 256];
    let mut index = 0_u32;
    let mut slot = 0_usize;
    while slot < 256 {
        table[slot] = one_byte(index);
        index += 1;
        slot += 1;
    }
    table
}

#[cfg(not(feature = "small-table"))]
const LANES: usize = 16;

#[cfg(not(feature = "small-table"))]
const fn lane_tables() -> [[u32; 256]; LANES] {
    let mut tables = [byte_table(); LANES];
    let mut lane = 1;
    while lane < LANES {
        let mut slot = 0;
        while slot < 256 {
            let before = tables[lane - 1][slot];
            tables[lane][slot] = (before >> 8) ^ tables[0][(before & 0xFF) as usize];
            slot += 1;
        }
        lane += 1;
    }
    tables
}

#[cfg(not(feature = "small-table"))]
static TABLES: [[u32; 256]; LANES] = lane_tables();
#[cfg(feature = "small-table")]
static TABLES: [[u32; 256]; 1] = [byte_table()];

/// A CRC-32C under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crc32c(u32);

impl Default for Crc32c {
    fn default() -> Self {
        Self::new()
    }
}

impl Crc32c {
    /// The state before the first byte.
    #[must_use]
    pub const fn new() -> Self {
        Self(u32::MAX)
    }

    /// The state after `bytes`.
    #[must_use]
    pub fn update(self, bytes: &[u8]) -> Self {
        let (state, rest) = wide(self.0, bytes);
        Self(rest.iter().fold(state, |crc, &byte| {
            let [low, ..] = crc.to_le_bytes();
            (crc >> 8) ^ TABLES[0][usize::from(low ^ byte)]
        }))
    }

    /// The checksum of everything seen.
    #[must_use]
    pub const fn value(self) -> u32 {
        !self.0
    }
}

/// Sixteen bytes a step: byte k of a block goes through the table that advances it by 15 - k zero bytes.
#[cfg(not(feature = "small-table"))]
fn wide(state: u32, bytes: &[u8]) -> (u32, &[u8]) {
    let (blocks, rest) = bytes.as_chunks::<LANES>();
    let crc = blocks.iter().fold(state, |crc, block| {
        let mut mixed = *block;
        for (byte, old) in mixed.iter_mut().zip(crc.to_le_bytes()) {
            *byte ^= old;
        }
        mixed
            .iter()
            .zip(TABLES.iter().rev())
            .fold(0, |sum, (&byte, table)| sum ^ table[usize::from(byte)])
    });
    (crc, rest)
}

#[cfg(feature = "small-table")]
fn wide(state: u32, bytes: &[u8]) -> (u32, &[u8]) {
    (state, bytes)
}

/// CRC-32C of `bytes`.
///
/// ```
/// assert_eq!(grip_link::crc::crc32c(b"123456789"), 0xE306_9283);
/// ```
#[must_use]
pub fn crc32c(bytes: &[u8]) -> u32 {
    Crc32c::new().update(bytes).value()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bit_by_bit(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(u32::MAX, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |c, _| {
                if c & 1 == 1 { (c >> 1) ^ POLYNOMIAL } else { c >> 1 }
            })
        })
    }

    #[test]
    fn check_value() {
        assert_eq!(crc32c(b"123456789"), 0xE306_9283);
        assert_eq!(crc32c(b""), 0);
    }

    #[test]
    fn tables_agree_with_the_shift_register_at_every_length_and_split() {
        let bytes: [u8; 100] = core::array::from_fn(|i| u8::try_from(i * 37 % 251).unwrap());
        for end in 0..bytes.len() {
            let whole = &bytes[..end];
            assert_eq!(crc32c(whole), bit_by_bit(whole));
            let (a, b) = whole.split_at(end / 3);
            assert_eq!(Crc32c::new().update(a).update(b).value(), bit_by_bit(whole));
        }
    }
}
