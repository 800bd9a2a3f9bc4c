//! Decoder of packets with their records, from bytes of the line; what is broken is counted.
//!
//! ```text
//! 9A  checksum  command  length (0 to 60)  length bytes of records
//! record: type (high 4 bits) | finger << 2 | index, then 16-bit values, big endian
//! ```
//!
//! The checksum is a CRC-8 over command, length and records, of which the maker publishes no polynomial, and its own programs check
//! nothing. So it is learned: where the usual polynomials agree with the first packets it is checked from then on. Records that do not
//! fit the length are refused in any case.

/// First byte of a packet.
const START: u8 = 0x9A;
const HEADER: usize = 4;
const MOST: usize = 60;
/// Packets after which it is decided whether there is a checksum, and how many of them must agree.
const LEARNED_FROM: u32 = 64;
const LEARNED_BY: u32 = 56;
/// Usual polynomials of CRC-8, each with these first values, forward and reflected.
const POLYNOMIALS: [u8; 8] = [0x07, 0x31, 0x1D, 0x2F, 0x9B, 0xD5, 0x39, 0xA6];
const FIRST: [u8; 2] = [0x00, 0xFF];
const WAYS: usize = POLYNOMIALS.len() * FIRST.len() * 2;

/// Whether packets have a checksum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Checksum {
    /// Not known yet.
    Unknown,
    /// None of the usual ones: only the form of a packet is checked.
    None,
    /// A CRC-8 with this polynomial; checked.
    Crc8 {
        /// The polynomial, without its highest bit.
        polynomial: u8,
    },
}

/// What was read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PacketCounters {
    /// Packets as they should be.
    pub packets: u64,
    /// Packets with a wrong checksum.
    pub crc: u64,
    /// Packets whose records do not fit.
    pub malformed: u64,
    /// Bytes between packets.
    pub garbage_bytes: u64,
}

/// A record of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Record<'a> {
    pub(super) kind: Kind,
    pub(super) finger: u8,
    values: &'a [u8],
}

/// What a record holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Taxels,
    Dynamic,
    Acceleration,
    Rotation,
    Magnetic,
    Temperature,
    Time,
}

impl Kind {
    fn of(first: u8) -> Option<Self> {
        Some(match first >> 4 {
            1 => Self::Taxels,
            2 => Self::Dynamic,
            3 => Self::Acceleration,
            4 => Self::Rotation,
            5 => Self::Magnetic,
            6 => Self::Temperature,
            7 => Self::Time,
            _ => return None,
        })
    }

    /// Values of a record.
    const fn values(self) -> usize {
        match self {
            Self::Taxels => 28,
            Self::Acceleration | Self::Rotation | Self::Magnetic => 3,
            Self::Dynamic | Self::Temperature | Self::Time => 1,
        }
    }
}

impl Record<'_> {
    /// The values as unsigned numbers.
    pub(super) fn unsigned(&self) -> impl Iterator<Item = u16> {
        self.values.chunks_exact(2).map(|pair| match *pair {
            [high, low] => u16::from_be_bytes([high, low]),
            _ => 0,
        })
    }

    /// The values as signed numbers.
    pub(super) fn signed(&self) -> impl Iterator<Item = i16> {
        self.unsigned().map(u16::cast_signed)
    }
}

/// A packet that was cut off, or what it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cut<'a> {
    /// Its records.
    Packet(&'a [u8]),
    /// A packet of this many bytes that cannot be used.
    Broken(usize),
}

/// Cuts packets.
#[derive(Debug)]
pub(super) struct Cutter {
    bytes: Vec<u8>,
    start: usize,
    seen: u32,
    /// Packets with which each way to compute a checksum agreed.
    agreed: [u32; WAYS],
    way: Option<usize>,
    counters: PacketCounters,
}

impl Cutter {
    pub(super) fn new() -> Self {
        let bytes = Vec::with_capacity(8192);
        Self {
            bytes,
            start: 0,
            seen: 0,
            agreed: [0; WAYS],
            way: None,
            counters: PacketCounters::default(),
        }
    }

    pub(super) fn counters(&self) -> PacketCounters {
        self.counters
    }

    pub(super) fn checksum(&self) -> Checksum {
        match self.way.and_then(|way| POLYNOMIALS.get(way / 4)) {
            Some(polynomial) => Checksum::Crc8 { polynomial: *polynomial },
            None if self.seen < LEARNED_FROM => Checksum::Unknown,
            None => Checksum::None,
        }
    }

    /// What was begun is forgotten: the line was opened anew.
    pub(super) fn reset(&mut self) {
        self.bytes.clear();
        self.start = 0;
    }

    pub(super) fn push(&mut self, bytes: &[u8]) {
        self.bytes.drain(..self.start);
        self.start = 0;
        self.bytes.extend_from_slice(bytes);
    }

    /// The next packet; `None` where more bytes are needed.
    pub(super) fn next(&mut self) -> Option<Cut<'_>> {
        let rest = self.bytes.get(self.start..)?;
        let skipped = rest.iter().position(|byte| *byte == START).unwrap_or(rest.len());
        self.start += skipped;
        self.counters.garbage_bytes += skipped as u64;
        let &[_, sum, _, length, ..] = self.bytes.get(self.start..)? else { return None };
        let size = HEADER + usize::from(length);
        if usize::from(length) > MOST {
            return Some(self.refuse(size, false));
        }
        let end = self.start + size;
        let (Some(checked), Some(records)) =
            (self.bytes.get(self.start + 2..end), self.bytes.get(self.start + HEADER..end))
        else {
            return None;
        };
        if !fits(records) {
            return Some(self.refuse(size, false));
        }
        if let Some(way) = self.way {
            if crc8(way, checked) != sum {
                return Some(self.refuse(size, true));
            }
        } else if self.seen < LEARNED_FROM {
            self.seen += 1;
            for (way, agreed) in self.agreed.iter_mut().enumerate() {
                *agreed += u32::from(crc8(way, checked) == sum);
            }
            if self.seen == LEARNED_FROM {
                self.way = self.agreed.iter().position(|agreed| *agreed >= LEARNED_BY);
            }
        }
        self.counters.packets += 1;
        let from = self.start + HEADER;
        self.start = end;
        self.bytes.get(from..end).map(Cut::Packet)
    }

    /// Goes on behind the first byte of what is no packet.
    fn refuse(&mut self, size: usize, crc: bool) -> Cut<'static> {
        let count = if crc { &mut self.counters.crc } else { &mut self.counters.malformed };
        *count += 1;
        self.start += 1;
        Cut::Broken(size)
    }
}

/// The records of a packet that was cut off.
pub(super) fn records(mut bytes: &[u8]) -> impl Iterator<Item = Record<'_>> {
    core::iter::from_fn(move || {
        let (first, rest) = bytes.split_first()?;
        let kind = Kind::of(*first)?;
        let (values, rest) = rest.split_at_checked(2 * kind.values())?;
        bytes = rest;
        Some(Record { kind, finger: first >> 2 & 3, values })
    })
}

/// Whether records fill these bytes, neither more nor less.
fn fits(bytes: &[u8]) -> bool {
    let used: usize = records(bytes).map(|record| 1 + record.values.len()).sum();
    used == bytes.len()
}

/// CRC-8 of one of the usual kinds: the polynomial, its first value, and whether bits come lowest first.
fn crc8(way: usize, bytes: &[u8]) -> u8 {
    let polynomial = POLYNOMIALS.get(way / 4).copied().unwrap_or_default();
    let first = FIRST.get(way / 2 % 2).copied().unwrap_or_default();
    let reflected = way % 2 == 1;
    let crc = bytes.iter().fold(first, |crc, byte| {
        let byte = if reflected { byte.reverse_bits() } else { *byte };
        (0..8).fold(
            crc ^ byte,
            |crc, _| {
                if crc & 0x80 == 0 { crc << 1 } else { crc << 1 ^ polynomial }
            },
        )
    });
    if reflected { crc.reverse_bits() } else { crc }
}

#[cfg(test)]
mod tests {
    use super::{Checksum, Cut, Cutter, crc8};

    /// A packet of one dynamic value, with this checksum.
    fn packet(value: i16, sum: impl Fn(&[u8]) -> u8) -> Vec<u8> {
        let [high, low] = value.to_be_bytes();
        let body = [0x58, 3, 0x20, high, low];
        [&[0x9A, sum(&body)], &body[..]].concat()
    }

    fn cut_all(cutter: &mut Cutter, bytes: &[u8]) -> (usize, usize) {
        let (mut whole, mut broken) = (0, 0);
        for piece in bytes.chunks(5) {
            cutter.push(piece);
            while let Some(cut) = cutter.next() {
                match cut {
                    Cut::Packet(_) => whole += 1,
                    Cut::Broken(_) => broken += 1,
                }
            }
        }
        (whole, broken)
    }

    #[test]
    fn known_values_of_the_usual_checksums() {
        // The check values of the catalogue of CRCs over "123456789": SMBUS, MAXIM-DOW, SAE-J1850 without its last step, ROHC.
        let ways = [(0, 0xF4), (5, 0xA1), (10, 0x4B ^ 0xFF), (3, 0xD0)];
        for (way, check) in ways {
            assert_eq!(crc8(way, b"123456789"), check, "{way}");
        }
    }

    #[test]
    fn a_checksum_is_learned_and_then_checked() {
        let mut cutter = Cutter::new();
        let sum = |body: &[u8]| crc8(4, body);
        for value in 0..64 {
            assert_eq!(cut_all(&mut cutter, &packet(7 * value, sum)), (1, 0));
        }
        assert_eq!(cutter.checksum(), Checksum::Crc8 { polynomial: 0x31 });
        let mut wrong = packet(321, sum);
        wrong[5] ^= 4;
        let stream = [packet(1, sum), wrong, packet(2, sum)].concat();
        assert_eq!(cut_all(&mut cutter, &stream), (2, 1));
        assert_eq!(cutter.counters().crc, 1);
    }

    #[test]
    fn a_byte_that_is_no_checksum_is_not_checked() {
        for byte in [0, 0x5A] {
            let mut cutter = Cutter::new();
            let stream: Vec<u8> = (0..100).flat_map(|value| packet(value, |_| byte)).collect();
            assert_eq!(cut_all(&mut cutter, &stream), (100, 0));
            assert_eq!(cutter.checksum(), Checksum::None);
        }
    }

    #[test]
    fn what_is_no_packet_is_left_out_and_the_next_one_found() {
        let mut cutter = Cutter::new();
        let good = packet(0x1234, |_| 0);
        let long = [0x9A, 0, 0x58, 200];
        let odd = [0x9A, 0, 0x58, 2, 0x20, 1];
        let stream = [&[1, 2, 3], &good[..], &long, &good, &odd, &good, &[0x9A]].concat();
        let (whole, broken) = cut_all(&mut cutter, &stream);
        assert_eq!(whole, 3);
        assert!(broken >= 2 && cutter.counters().garbage_bytes >= 3);
    }
}
