//! Transfer of a folder of recordings at one gripper to copies elsewhere: what is asked and answered under [`Part::Recordings`], and both ends
//! of it, without a network.
//!
//! A question without parameters is answered with the [`Recording`]s there are, as JSON lists of at most [`LISTED`] each. One with `name`,
//! `from`, `bytes` (at most [`MOST`]), `size` and `modified` is answered with the bytes from there on in [pieces](Piece); or refused,
//! where the file is not any more what `size` and `modified` state.
//!
//! [`Part::Recordings`]: crate::Part::Recordings

mod fetch;
mod shelf;

pub use fetch::{Asking, FetchError, Fetched, fetch};
pub use shelf::{Reading, Shelf, ShelfError};

use grip_link::crc::crc32c;
use serde::{Deserialize, Serialize};

/// Bytes of a piece, at most.
pub const PIECE: usize = 256 * 1024;
/// Bytes that one question may ask for.
pub const MOST: u64 = 1 << 20;
/// Recordings in one part of the answer, at most.
pub const LISTED: usize = 1000;
/// Bytes before those of a piece: its place (u64) and its CRC-32C (u32), little-endian.
const HEAD: usize = 12;
/// Longest name (bytes).
const LONGEST: usize = 200;

/// One recording at a gripper.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Recording {
    /// Name of the file, without a folder.
    pub name: String,
    /// How long it is.
    pub bytes: u64,
    /// When it was begun (ns since 1970), where the file system knows.
    pub begin_ns: Option<u64>,
    /// When it was written last (ns since 1970).
    pub modified_ns: u64,
    /// Whether it is being written.
    pub growing: bool,
}

impl Recording {
    /// The question for its bytes from a place on: names and values.
    #[must_use]
    pub fn question(&self, from: u64, bytes: u64) -> [(&'static str, String); 5] {
        let [from, bytes, size, modified] =
            [from, bytes, self.bytes, self.modified_ns].map(|number| number.to_string());
        [
            ("name", self.name.clone()),
            ("from", from),
            ("bytes", bytes),
            ("size", size),
            ("modified", modified),
        ]
    }
}

/// Whether a text is the name of a recording that can travel: letters, digits and `._-+@ ` in ASCII, no point or space at its start, `.mcap` at
/// its end. So it leads nowhere else, on either side.
#[must_use]
pub fn is_plain(name: &str) -> bool {
    let fits = |byte: u8| byte.is_ascii_alphanumeric() || b"._-+@ ".contains(&byte);
    name.len() <= LONGEST
        && name.ends_with(".mcap")
        && !name.starts_with(['.', ' '])
        && name.bytes().all(fits)
}

/// Some bytes of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece<'a> {
    /// Where they stand in the file.
    pub at: u64,
    /// The bytes.
    pub bytes: &'a [u8],
}

impl<'a> Piece<'a> {
    /// What travels.
    #[must_use]
    pub fn write(&self) -> Vec<u8> {
        let mut out = Vec::with_capacity(HEAD + self.bytes.len());
        out.extend(self.at.to_le_bytes());
        out.extend(crc32c(self.bytes).to_le_bytes());
        out.extend(self.bytes);
        out
    }

    /// What came; `None` where it is none, or damaged.
    #[must_use]
    pub fn read(bytes: &'a [u8]) -> Option<Self> {
        let (at, rest) = bytes.split_first_chunk()?;
        let (crc, bytes) = rest.split_first_chunk()?;
        let piece = Self { at: u64::from_le_bytes(*at), bytes };
        (crc32c(bytes) == u32::from_le_bytes(*crc)).then_some(piece)
    }
}

#[cfg(test)]
mod tests {
    use super::{Piece, is_plain};

    #[test]
    fn names_lead_nowhere_else() {
        for name in ["run.mcap", "20261121T225908Z-0001.mcap", "cell 1@hall+x_2.mcap"] {
            assert!(is_plain(name), "{name}");
        }
        let long = format!("{}.mcap", "x".repeat(200));
        for name in [
            "",
            ".mcap",
            "..mcap",
            "../../etc/passwd",
            "../run.mcap",
            "a/run.mcap",
            "/etc/x.mcap",
            "run.csv",
            "run.mcap\n",
            "run\0.mcap",
            "a\\b.mcap",
            "a;b.mcap",
            "ä.mcap",
            " a.mcap",
            &long,
        ] {
            assert!(!is_plain(name), "{name:?}");
        }
    }

    #[test]
    fn pieces_come_as_they_went_or_not_at_all() {
        let sent = Piece { at: 7 << 33, bytes: b"some bytes" };
        let wire = sent.write();
        assert_eq!(Piece::read(&wire), Some(sent));
        for at in 8..wire.len() {
            let mut bad = wire.clone();
            bad[at] ^= 1;
            assert_eq!(Piece::read(&bad), None, "byte {at}");
        }
        assert_eq!(Piece::read(&wire[..11]), None);
    }
}
