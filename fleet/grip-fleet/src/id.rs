//! Number and time of an event, encoded in 24 bytes and decoded.

use core::{fmt, str::FromStr};
use serde_with::{DeserializeFromStr, SerializeDisplay};

/// Which event of a gripper this is. Every start of the daemon that keeps the log is a run of its own and counts from 1, so that
/// no number is ever given twice, also where a crash of the machine has cost the end of the log.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, SerializeDisplay, DeserializeFromStr,
)]
pub struct EventId {
    /// The run: differs from start to start of the daemon, in no order.
    pub run: u32,
    /// Number in the run, from 1; 0 before the first event.
    pub seq: u64,
}

/// Why a text is no number of an event.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no number of an event: expected RUN.NUMBER, for example 7f03a1c2.15")]
pub struct IdError(pub String);

/// A time of day, by the clock of the gripper's computer, and how far off it may be of that clock. All zero where it is not known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WallTime {
    /// Since 1970, UTC (ns).
    pub ns: u64,
    /// Largest error (us).
    pub error_us: u32,
}

/// What stands beside a publication: which event it is, or the last event before it, and when it happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stamp {
    /// Which.
    pub id: EventId,
    /// When.
    pub at: WallTime,
}

impl From<EventId> for Stamp {
    fn from(id: EventId) -> Self {
        Self { id, at: WallTime::default() }
    }
}

impl Stamp {
    /// Bytes that [`Stamp::to_bytes`] gives.
    pub const SIZE: usize = 24;

    /// Run (u32) and number (u64) of the event, time (u64) and error (u32), little-endian: what stands beside a publication.
    #[must_use]
    pub fn to_bytes(self) -> [u8; Self::SIZE] {
        let mut bytes = [0; Self::SIZE];
        let Self { id, at } = self;
        let (run, seq) = (id.run.to_le_bytes(), id.seq.to_le_bytes());
        let (ns, error_us) = (at.ns.to_le_bytes(), at.error_us.to_le_bytes());
        let parts = [&run[..], &seq, &ns, &error_us];
        bytes.iter_mut().zip(parts.concat()).for_each(|(byte, part)| *byte = part);
        bytes
    }

    /// What these bytes stand for; `None` for another count of bytes.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (run, rest) = bytes.split_first_chunk()?;
        let (seq, rest) = rest.split_first_chunk()?;
        let (ns, error_us) = rest.split_first_chunk()?;
        let error_us = u32::from_le_bytes(error_us.try_into().ok()?);
        let id = EventId { run: u32::from_le_bytes(*run), seq: u64::from_le_bytes(*seq) };
        Some(Self { id, at: WallTime { ns: u64::from_le_bytes(*ns), error_us } })
    }
}

impl fmt::Display for EventId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:08x}.{}", self.run, self.seq)
    }
}

impl FromStr for EventId {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        let wrong = || IdError(text.to_owned());
        let plain = |part: &str| part.bytes().all(|byte| byte.is_ascii_hexdigit());
        let (run, seq) = text.split_once('.').ok_or_else(wrong)?;
        if run.len() != 8 || !plain(run) || !plain(seq) {
            return Err(wrong());
        }
        let run = u32::from_str_radix(run, 16).map_err(|_| wrong())?;
        Ok(Self { run, seq: seq.parse().map_err(|_| wrong())? })
    }
}

#[cfg(test)]
mod tests {
    use super::{EventId, Stamp, WallTime};

    #[test]
    fn numbers_are_read_as_they_are_written() {
        for id in [EventId::default(), EventId { run: 0x7f03_a1c2, seq: u64::MAX }] {
            assert_eq!(id.to_string().parse(), Ok(id));
        }
        for wrong in ["", "1.2", "7f03a1c2", "7f03a1c2.", "7f03a1c2.+1", "7f03a1c2.f", "+f03a1c2.1"]
        {
            assert!(wrong.parse::<EventId>().is_err(), "{wrong}");
        }
        let id = EventId { run: 7, seq: 9 };
        let stamp = Stamp { id, at: WallTime { ns: u64::MAX - 1, error_us: 20_000 } };
        let bytes = stamp.to_bytes();
        assert_eq!(
            (&bytes[..4], &bytes[4..12]),
            (&[7, 0, 0, 0][..], &[9, 0, 0, 0, 0, 0, 0, 0][..])
        );
        assert_eq!((bytes[12], bytes[20]), (0xFE, 0x20), "little-endian");
        assert_eq!(Stamp::from_bytes(&bytes), Some(stamp));
        for len in [0, 12, 23, 25] {
            assert_eq!(Stamp::from_bytes(&vec![0; len]), None);
        }
    }
}
