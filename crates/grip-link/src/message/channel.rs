//! Channel descriptions of IDENT and a channel mask in, the columns of a SAMPLES row out.

use super::wire::{PayloadError, Reader, Writer};

/// Most channels a gripper describes.
pub const MAX_CHANNELS: usize = 16;

/// What a channel measures; the number is the code on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ChannelKind {
    /// 1: displacement of the stylus \[m\], or in another unit a vibration; every gripper has it.
    Stylus,
    /// 2: normal force \[N\].
    NormalForce,
    /// 3: tangential force \[N\].
    TangentialForce,
    /// 4: moved distance of the object, from a roller or encoder \[m\].
    Travel,
    /// 5: speed of the object \[m/s\].
    Velocity,
    /// 6: displacement of a second stylus \[m\].
    SecondStylus,
    /// 7: motion reference: an accelerometer on the gripper or arm \[m/s2\].
    Reference,
    /// 8: contact pressure \[Pa\].
    Pressure,
    /// 9: contact pressures of an array \[Pa\], `count` elements a row.
    PressureArray,
    /// A code of a later protocol: carried, not understood.
    Other(u8),
}

impl ChannelKind {
    /// From the wire.
    #[must_use]
    pub const fn from_code(code: u8) -> Self {
        match code {
            1 => Self::Stylus,
            2 => Self::NormalForce,
            3 => Self::TangentialForce,
            4 => Self::Travel,
            5 => Self::Velocity,
            6 => Self::SecondStylus,
            7 => Self::Reference,
            8 => Self::Pressure,
            9 => Self::PressureArray,
            other => Self::Other(other),
        }
    }

    /// To the wire.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Stylus => 1,
            Self::NormalForce => 2,
            Self::TangentialForce => 3,
            Self::Travel => 4,
            Self::Velocity => 5,
            Self::SecondStylus => 6,
            Self::Reference => 7,
            Self::Pressure => 8,
            Self::PressureArray => 9,
            Self::Other(code) => code,
        }
    }

    /// The unit that the channel is meant to have.
    #[must_use]
    pub const fn unit(self) -> Unit {
        match self {
            Self::Stylus | Self::Travel | Self::SecondStylus => Unit::Metre,
            Self::NormalForce | Self::TangentialForce => Unit::Newton,
            Self::Velocity => Unit::MetrePerSecond,
            Self::Reference => Unit::MetrePerSecond2,
            Self::Pressure | Self::PressureArray => Unit::Pascal,
            Self::Other(_) => Unit::None,
        }
    }
}

/// Unit of a channel after scaling; the number is the code on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Unit {
    /// 0: a bare number, uncalibrated.
    None,
    /// 1: m.
    Metre,
    /// 2: N.
    Newton,
    /// 3: m/s.
    MetrePerSecond,
    /// 4: m/s2.
    MetrePerSecond2,
    /// 5: Pa.
    Pascal,
    /// A code of a later protocol.
    Other(u8),
}

impl Unit {
    /// From the wire.
    #[must_use]
    pub const fn from_code(code: u8) -> Self {
        match code {
            0 => Self::None,
            1 => Self::Metre,
            2 => Self::Newton,
            3 => Self::MetrePerSecond,
            4 => Self::MetrePerSecond2,
            5 => Self::Pascal,
            other => Self::Other(other),
        }
    }

    /// To the wire.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::None => 0,
            Self::Metre => 1,
            Self::Newton => 2,
            Self::MetrePerSecond => 3,
            Self::MetrePerSecond2 => 4,
            Self::Pascal => 5,
            Self::Other(code) => code,
        }
    }
}

/// How the elements of a row stand in SAMPLES; the number is the code on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SampleFormat {
    /// 0: i16; value = raw * scale of the channel; raw -32768 means no reading.
    I16,
    /// 1: f32 in the channel's unit, the scale is not applied; NaN means no reading.
    F32,
}

impl SampleFormat {
    /// From the wire.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Self::I16),
            1 => Some(Self::F32),
            _ => None,
        }
    }

    /// To the wire.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::I16 => 0,
            Self::F32 => 1,
        }
    }

    /// Bytes of one element.
    #[must_use]
    pub const fn size(self) -> usize {
        match self {
            Self::I16 => 2,
            Self::F32 => 4,
        }
    }
}

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
        (1..=64).contains(&self.count)
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
