//! SAMPLES: a batch of rows, read in place, and the columns of its rows.

use super::ident::{Channel, MAX_CHANNELS};
use super::wire::PayloadError;
use super::{ChannelKind, SampleFormat};
use slip_msg::message;

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

/// Bytes before the rows.
pub const SAMPLES_HEADER: usize = SamplesHeader::SIZE;

message! {
    /// The first 20 bytes of SAMPLES (90), MCU to host. The rows follow: channels of the mask in the order of IDENT; an array takes `count`
    /// elements.
    #[derive(Eq)]
    SamplesHeader {
        0 first_index: u32, "number of the first row; +1 for every row taken since the device started, wraps", "Number of the first row.";
        4 t0_tick: u64, "tick of the first row", "Time of the first row.";
        12 dt_ticks: u16, "ticks from row to row: floor(`tick_hz` / rate)", "Time from row to row.";
        14 rows as "n": u8, "rows, 1..255; 0 is malformed", "Rows.", in 1..;
        15 format: SampleFormat, "sample format; an unknown one is malformed", "Format of the elements.";
        16 dropped_total: u32, "rows dropped by the device since it started, at the time of sending; wraps", "Rows the MCU dropped since it started.";
    }
}

/// A batch: its header and its rows, borrowed from the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Samples<'a> {
    /// The first 20 bytes.
    pub header: SamplesHeader,
    layout: &'a Layout,
    rows: &'a [u8],
}

impl<'a> Samples<'a> {
    /// Reads a payload whose rows have the columns of `layout`.
    ///
    /// # Errors
    /// [`PayloadError`]: too short for its rows, no rows, no columns, or an unknown format.
    pub fn parse(payload: &'a [u8], layout: &'a Layout) -> Result<Self, PayloadError> {
        let header = SamplesHeader::parse(payload)?;
        if layout.row_bytes(header.format) == 0 {
            return Err(PayloadError::Value { at: SAMPLES_HEADER, value: 0 });
        }
        let need = SAMPLES_HEADER + layout.row_bytes(header.format) * usize::from(header.rows);
        let short = PayloadError::Short { need, have: payload.len() };
        Self::of(header, layout, payload).ok_or(short)
    }

    /// The rows of a payload whose header was read before; `None` where it is too short for them.
    pub(crate) fn of(header: SamplesHeader, layout: &'a Layout, payload: &'a [u8]) -> Option<Self> {
        let bytes = layout.row_bytes(header.format) * usize::from(header.rows);
        let rows = payload.get(SAMPLES_HEADER..SAMPLES_HEADER + bytes)?;
        Some(Self { header, layout, rows })
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        usize::from(self.header.rows)
    }

    /// A batch is never empty; here for symmetry with `len`.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.header.rows == 0
    }

    /// The columns of the rows.
    #[must_use]
    pub const fn layout(&self) -> &'a Layout {
        self.layout
    }

    /// Row `n`, from 0 on.
    #[must_use]
    #[inline]
    pub fn row(&self, n: u8) -> Option<Row<'a>> {
        let SamplesHeader { first_index, t0_tick, dt_ticks, format, .. } = self.header;
        let size = self.layout.row_bytes(format);
        let bytes = self.rows.get(size * usize::from(n)..)?.get(..size)?;
        Some(Row {
            index: first_index.wrapping_add(u32::from(n)),
            tick: t0_tick.wrapping_add(u64::from(dt_ticks) * u64::from(n)),
            format,
            layout: self.layout,
            bytes,
        })
    }

    /// The rows in order.
    #[must_use]
    pub fn rows(&self) -> Rows<'a> {
        Rows { samples: *self, done: 0 }
    }
}

impl<'a> IntoIterator for &Samples<'a> {
    type Item = Row<'a>;
    type IntoIter = Rows<'a>;

    fn into_iter(self) -> Rows<'a> {
        self.rows()
    }
}

/// Iterator over the rows of a batch.
#[derive(Debug, Clone)]
pub struct Rows<'a> {
    samples: Samples<'a>,
    done: u8,
}

impl<'a> Iterator for Rows<'a> {
    type Item = Row<'a>;

    fn next(&mut self) -> Option<Row<'a>> {
        let row = self.samples.row(self.done).filter(|_| self.done < self.samples.header.rows)?;
        self.done = self.done.saturating_add(1);
        Some(row)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = usize::from(self.samples.header.rows.saturating_sub(self.done));
        (left, Some(left))
    }
}

impl ExactSizeIterator for Rows<'_> {}

/// One row: all channels at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row<'a> {
    /// Number of the row since the MCU started, wrapping.
    pub index: u32,
    /// Time of the row \[ticks\].
    pub tick: u64,
    format: SampleFormat,
    layout: &'a Layout,
    bytes: &'a [u8],
}

impl Row<'_> {
    /// Its columns in order.
    #[must_use]
    #[inline]
    pub fn columns(&self) -> &[Column] {
        self.layout.columns()
    }

    /// Raw value of an element when the format is i16.
    #[must_use]
    pub fn raw(&self, element: usize) -> Option<i16> {
        if self.format != SampleFormat::I16 {
            return None;
        }
        let bytes = self.bytes.get(element.checked_mul(2)?..)?;
        bytes.first_chunk().copied().map(i16::from_le_bytes)
    }

    /// Value of element `k` of a column in its unit; NaN when the channel had no reading, `None` outside the column.
    #[must_use]
    #[inline]
    pub fn value(&self, column: &Column, k: u8) -> Option<f32> {
        if k >= column.count {
            return None;
        }
        let element = usize::from(column.first) + usize::from(k);
        match self.format {
            SampleFormat::I16 => {
                let raw = self.raw(element)?;
                Some(if raw == i16::MIN { f32::NAN } else { f32::from(raw) * column.scale })
            }
            SampleFormat::F32 => {
                let bytes = self.bytes.get(element.checked_mul(4)?..)?;
                bytes.first_chunk().copied().map(f32::from_le_bytes)
            }
        }
    }

    /// The elements of the first column of a kind, written to `out` as far as they fit; empty when the row has no such channel. NaN
    /// stands for no reading.
    #[must_use]
    pub fn read_all<'b>(&self, kind: ChannelKind, out: &'b mut [f32]) -> &'b [f32] {
        let Some(column) = self.layout.column(kind) else { return &[] };
        let mut taken = 0;
        for (slot, k) in out.iter_mut().zip(0..column.count) {
            let Some(value) = self.value(&column, k) else { break };
            *slot = value;
            taken += 1;
        }
        out.get(..taken).unwrap_or_default()
    }

    /// First element of the first column of a kind; `None` when the row has no such channel.
    #[must_use]
    pub fn read(&self, kind: ChannelKind) -> Option<f32> {
        self.value(&self.layout.column(kind)?, 0)
    }
}
