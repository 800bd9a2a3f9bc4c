//! Attachment of a publication: its number and time in the 33 bytes that stand beside it.

use twox_hash::XxHash3_128;

/// What names a publisher in ROS: XXH3 (128 bits, no seed) of its liveliness token, the lowest byte first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Gid(pub [u8; 16]);

impl Gid {
    /// That of the publisher with this token.
    #[must_use]
    pub fn of(token: &str) -> Self {
        Self(XxHash3_128::oneshot(token.as_bytes()).to_le_bytes())
    }
}

/// What stands beside each publication.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// Counts the publications of the publisher from 1; subscribers count what is missing.
    pub sequence: i64,
    /// When it was published (ns since 1970).
    pub source_ns: i64,
    /// Who published it.
    pub gid: Gid,
}

impl Attachment {
    /// Bytes that [`Attachment::to_bytes`] gives.
    pub const SIZE: usize = 33;

    /// Number and time, little-endian, then the length of the name as one byte, and the name.
    #[must_use]
    pub fn to_bytes(self) -> [u8; Self::SIZE] {
        let mut out = [0; Self::SIZE];
        let number = self.sequence.to_le_bytes();
        let time = self.source_ns.to_le_bytes();
        let all = number.iter().chain(&time).chain(&[16]).chain(&self.gid.0);
        out.iter_mut().zip(all).for_each(|(out, byte)| *out = *byte);
        out
    }
}

#[cfg(test)]
mod tests {
    use super::{Attachment, Gid};

    #[test]
    fn the_bytes_are_those_of_the_serializer_of_zenoh() {
        let gid = Gid(core::array::from_fn(|at| 0xA0 + u8::try_from(at).unwrap()));
        let attachment = Attachment { sequence: 0x0102, source_ns: -2, gid };
        let mut wanted = vec![2, 1, 0, 0, 0, 0, 0, 0, 0xFE];
        wanted.extend_from_slice(&[0xFF; 7]);
        wanted.push(16);
        wanted.extend(0xA0..=0xAF);
        assert_eq!(attachment.to_bytes().as_slice(), wanted);
    }

    /// XXH3 of nothing and of one byte, as the reference implementation prints them (`xxhsum -H2`).
    #[test]
    fn a_publisher_is_named_by_the_hash_of_its_token() {
        let hex =
            |gid: Gid| gid.0.iter().rev().map(|byte| format!("{byte:02x}")).collect::<String>();
        assert_eq!(hex(Gid::of("")), "99aa06d3014798d86001c324468d497f");
        assert_eq!(hex(Gid::of("a")), "a96faf705af16834e6c632b61e964e1f");
        assert_ne!(Gid::of("@ros2_lv/0/a"), Gid::of("@ros2_lv/0/b"));
    }
}
