//! CRC-32C (Castagnoli) of frames and records, by the crate `crc`.
//!
//! Reflected polynomial `82F63B78`, initial value and final xor `FFFFFFFF`; the check value of
//! `123456789` is `E3069283`. The Hamming distance is 6 up to 655 bytes, which covers the longest frame body
//! (P. Koopman, "32-bit cyclic redundancy codes for Internet applications", 2002).

use crc::{CRC_32_ISCSI, Crc, Table};

/// Sixteen bytes a step: 16 KiB of tables.
#[cfg(not(target_os = "none"))]
type Tables = Table<16>;
/// A byte a step, up to twenty times slower: 1 KiB of flash, because a microcontroller has little of it.
#[cfg(target_os = "none")]
type Tables = Table<1>;

static CRC_32C: Crc<u32, Tables> = Crc::<u32, Tables>::new(&CRC_32_ISCSI);

/// CRC-32C of `bytes`.
///
/// ```
/// assert_eq!(grip_link::crc::crc32c(b"123456789"), 0xE306_9283);
/// ```
#[must_use]
pub fn crc32c(bytes: &[u8]) -> u32 {
    of_parts([bytes])
}

/// CRC-32C of all bytes of `parts`.
#[inline]
pub(crate) fn of_parts<const N: usize>(parts: [&[u8]; N]) -> u32 {
    let mut digest = CRC_32C.digest();
    for part in parts {
        // In blocks, because the compiler then sees that no index of the crate can be out of bounds (scripts/no-std-check.sh).
        let (blocks, rest) = part.as_chunks::<16>();
        blocks.iter().for_each(|block| digest.update(block));
        digest.update(rest);
    }
    digest.finalize()
}
