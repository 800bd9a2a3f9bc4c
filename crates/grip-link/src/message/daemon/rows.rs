//! ROWS: samples as the pipeline got them, read in place.
//!
//! A layout of its own and not that of SAMPLES: numbers and times of the rows need not be evenly spaced (rows get lost, clients ask
//! for every n-th), values are in SI units without the scales of IDENT, and each frame states itself which channels it
//! holds, so that a client can begin anywhere.

use crate::frame::MAX_PAYLOAD;
use crate::message::bits::bits;
use crate::message::wire::{PayloadError, Reader, Writer};
use slip_msg::message;

/// Bytes before the rows.
pub const ROWS_HEADER: usize = RowsHeader::SIZE;

bits! {
    /// The channels of a row, as bits in the order in which their values stand.
    RowSet(u16) {
        0 STYLUS "m, displacement of the stylus, or a vibration in the unit of its channel; always there.",
        1 NORMAL_FORCE "N.",
        2 TANGENTIAL_FORCE "N.",
        3 TRAVEL "m, moved distance of the object.",
        4 VELOCITY "m/s, speed of the object.",
        5 SECOND_STYLUS "m.",
        6 REFERENCE "motion reference, in its own unit.",
        7 PRESSURE "in its own unit.",
        8 MOTION "commanded motion; 0 = commanded to stand still.",
    }
}

impl RowSet {
    /// Channels there can be.
    pub const MOST: usize = 9;

    /// Channels of the set.
    #[must_use]
    pub const fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Whether it is empty.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Place of a single channel's value in a row of this set; `None` where it has no such channel.
    #[must_use]
    pub const fn place(self, channel: Self) -> Option<usize> {
        if self.0 & channel.0 == 0 {
            return None;
        }
        Some((self.0 & channel.0.wrapping_sub(1)).count_ones() as usize)
    }
}

message! {
    /// The first 20 bytes of ROWS (A5), daemon to client.
    ///
    /// A row is a u32, its time after the first one (us), and an f32 for each channel and taxel; NaN = no reading.
    #[derive(Eq)]
    RowsHeader {
        0 first_index: u32, "number of the first row, as in SAMPLES; wraps", "Number of the first row.";
        4 t0_us: u64, "us, device time of the first row", "Its device time.";
        12 every_nth: u16, "step from number to number; 0 is malformed", "Step from number to number.", in 1..;
        14 channels: RowSet, "row channels; none is malformed", "The channels.", in RowSet(1)..;
        16 rows as "n": u8, "rows, 1..255; 0 is malformed", "Rows.", in 1..;
        17 taxels: u8, "values of the taxel array at the end of each row", "Taxels after the channels of each row.", reserved 2;
    }
}

impl RowsHeader {
    /// Bytes of a row.
    #[must_use]
    pub const fn row_bytes(&self) -> usize {
        4 + 4 * (self.channels.len() + self.taxels as usize)
    }

    /// Rows that fit a frame.
    #[must_use]
    pub const fn room(&self) -> usize {
        (MAX_PAYLOAD - ROWS_HEADER) / self.row_bytes()
    }
}

/// A batch: its header and its rows, borrowed from the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rows<'a> {
    /// The first 20 bytes.
    pub header: RowsHeader,
    bytes: &'a [u8],
}

impl<'a> Rows<'a> {
    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError`]: as [`RowsHeader::parse`], or too short for its rows.
    pub fn parse(payload: &'a [u8]) -> Result<Self, PayloadError> {
        let header = RowsHeader::parse(payload)?;
        let size = header.row_bytes() * usize::from(header.rows);
        Ok(Self { header, bytes: Reader::at_offset(payload, ROWS_HEADER).slice(size)? })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let have = out.len();
        let full = PayloadError::Full { have };
        let at = self.header.write(out).map_err(|_| full)?;
        Writer::new(out.get_mut(at..).ok_or(full)?).put(self.bytes).finish().map_err(|_| full)?;
        Ok(at + self.bytes.len())
    }

    /// The rows in order.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = RowOfSample<'a>> {
        let header = self.header;
        self.bytes.chunks_exact(header.row_bytes()).enumerate().map(move |(k, bytes)| {
            let k = u32::try_from(k).unwrap_or(0);
            let (time, values) = bytes.split_at_checked(4).unwrap_or_default();
            let after = time.first_chunk().copied().map_or(0, u32::from_le_bytes);
            RowOfSample {
                index: header.first_index.wrapping_add(k * u32::from(header.every_nth)),
                t_us: header.t0_us.wrapping_add(u64::from(after)),
                channels: header.channels,
                values,
            }
        })
    }
}

/// One row: all channels at one time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RowOfSample<'a> {
    /// Number of the row since the gripper started, wrapping.
    pub index: u32,
    /// Device time (us).
    pub t_us: u64,
    channels: RowSet,
    values: &'a [u8],
}

impl RowOfSample<'_> {
    /// A single channel of [`RowSet`]; NaN where it had no reading, `None` where the row has no such channel.
    #[must_use]
    pub fn value(&self, channel: RowSet) -> Option<f32> {
        self.element(self.channels.place(channel)?)
    }

    /// Taxel `k`; `None` beyond the last.
    #[must_use]
    pub fn taxel(&self, k: usize) -> Option<f32> {
        self.element(self.channels.len().checked_add(k)?)
    }

    fn element(&self, place: usize) -> Option<f32> {
        let bytes = self.values.get(place.checked_mul(4)?..)?;
        bytes.first_chunk().copied().map(f32::from_le_bytes)
    }
}
