//! Channel descriptions of IDENT and a channel mask in, the columns of a SAMPLES row out.

use super::wire::{PayloadError, Reader, Writer};
use super::{ChannelKind, SampleFormat, Unit};

/// Most channels a gripper describes.
pub const MAX_CHANNELS: usize = 16;

/// Most elements of a channel, the taxels of an array.
pub const MAX_ELEMENTS: u8 = 64;

/// One channel of IDENT.
///
/// | offset | size | type | field | range |
/// |---|---|---|---|---|
/// | 0 | 1 | u8 | kind | [`ChannelKind`] code |
/// | 1 | 1 | u8 | unit | [`Unit`] code |
/// | 2 | 1 | u8 | formats | b0 i16, b1 f32; the formats in which it can be sent |
/// | 3 | 1 | u8 | count | elements a row, 1..=64; 1 except for an array |
/// | 4 | 4 | f32 | scale | unit per i16 step, finite and > 0 |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel {
    /// What it measures.
    pub kind: ChannelKind,
    /// Unit after scaling.
    pub unit: Unit,
    /// b0 i16, b1 f32.
    pub formats: u8,
    /// Elements a row.
    pub count: u8,
    /// Unit per i16 step.
    pub scale: f32,
}

impl Channel {
    /// Bytes of an entry.
    pub const SIZE: usize = 8;

    /// A channel of one element in its own unit that can be sent in both formats.
    #[must_use]
    pub const fn single(kind: ChannelKind, scale: f32) -> Self {
        Self { kind, unit: kind.unit(), formats: 3, count: 1, scale }
    }

    /// Whether it can be sent in `format`.
    #[must_use]
    pub const fn offers(&self, format: SampleFormat) -> bool {
        self.formats & (1 << format.code()) != 0
    }

    /// Whether count and scale are in their ranges: a host refuses any other.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        self.count_is_possible() && self.scale_is_possible()
    }

    pub(crate) fn count_is_possible(&self) -> bool {
        (1..=MAX_ELEMENTS).contains(&self.count)
    }

    pub(crate) fn scale_is_possible(&self) -> bool {
        self.scale.is_finite() && self.scale > 0.0
    }

    pub(crate) fn read(reader: &mut Reader<'_>) -> Result<Self, PayloadError> {
        Ok(Self {
            kind: ChannelKind::from_code(reader.u8()?),
            unit: Unit::from_code(reader.u8()?),
            formats: reader.u8()?,
            count: reader.u8()?,
            scale: reader.f32()?,
        })
    }

    pub(crate) fn write<'a>(&self, writer: Writer<'a>) -> Writer<'a> {
        writer
            .u8(self.kind.code())
            .u8(self.unit.code())
            .u8(self.formats)
            .u8(self.count)
            .f32(self.scale)
    }
}

/// Place of one channel in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column {
    /// What it measures.
    pub kind: ChannelKind,
    /// Unit per i16 step.
    pub scale: f32,
    /// Its first element in the row.
    pub first: u16,
    /// Its elements.
    pub count: u8,
}

/// The columns of a row: the channels of the mask, in the order of IDENT.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    columns: [Column; MAX_CHANNELS],
    used: usize,
    elements: u16,
}

impl Layout {
    /// No columns.
    pub const EMPTY: Self = Self {
        columns: [Column { kind: ChannelKind::Other(0), scale: 1.0, first: 0, count: 0 };
            MAX_CHANNELS],
        used: 0,
        elements: 0,
    };

    /// The layout of rows with those `channels` whose bit is set in `mask` (bit 0 = first channel).
    #[must_use]
    pub fn new(channels: &[Channel], mask: u32) -> Self {
        let mut layout = Self::EMPTY;
        let chosen = channels
            .iter()
            .take(MAX_CHANNELS)
            .enumerate()
            .filter(|(bit, _)| mask & (1 << bit) != 0);
        for (slot, (_, channel)) in layout.columns.iter_mut().zip(chosen) {
            let Channel { kind, scale, count, .. } = *channel;
            *slot = Column { kind, scale, first: layout.elements, count };
            layout.elements += u16::from(count);
            layout.used += 1;
        }
        layout
    }

    /// The columns in row order.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        self.columns.get(..self.used).unwrap_or(&[])
    }

    /// The first column of a kind.
    #[must_use]
    pub fn column(&self, kind: ChannelKind) -> Option<Column> {
        self.columns().iter().copied().find(|column| column.kind == kind)
    }

    /// Elements of a row.
    #[must_use]
    pub const fn elements(&self) -> u16 {
        self.elements
    }

    /// Bytes of a row.
    #[must_use]
    pub fn row_bytes(&self, format: SampleFormat) -> usize {
        usize::from(self.elements) * format.size()
    }
}
