//! Spectra in order of time in, as many of them as memory allows out: older ones are joined in pairs.

use crate::feed::SpectrumColumn;
use crate::span::Span;
use std::collections::VecDeque;

/// Power of a bin whose byte is 0 (dB).
pub const DB_BASE: f32 = -260.0;
/// Power from byte to byte (dB).
pub const DB_STEP: f32 = 1.5;

/// The spectra of the stylus.
#[derive(Clone, Debug, Default)]
pub struct Spectrogram {
    columns: VecDeque<SpectrumColumn>,
    bytes: usize,
}

impl Spectrogram {
    pub(super) fn push(&mut self, column: SpectrumColumn, most_bytes: usize) {
        let in_order = self.columns.back().is_none_or(|last| last.span[1] <= column.span[1]);
        if !in_order || column.bins.is_empty() {
            return;
        }
        self.bytes += size(&column);
        self.columns.push_back(column);
        if self.bytes > most_bytes {
            self.join_older_half();
        }
    }

    /// Joins neighbours of the older half, the higher one of each bin; what does not join stays as it is.
    fn join_older_half(&mut self) {
        let half = self.columns.len() / 2;
        let newer = self.columns.split_off(half);
        let older = core::mem::replace(&mut self.columns, VecDeque::with_capacity(half));
        let mut open: Option<SpectrumColumn> = None;
        for column in older {
            let Some(mut left) = open.take() else {
                open = Some(column);
                continue;
            };
            let alike = left.bins.len() == column.bins.len();
            let near = column.span[0] - left.span[1] <= 2.0 * (left.span[1] - left.span[0]);
            if alike && near {
                left.bins.iter_mut().zip(&column.bins).for_each(|(l, r)| *l = (*l).max(*r));
                left.span[1] = column.span[1];
                self.columns.push_back(left);
            } else {
                self.columns.push_back(left);
                open = Some(column);
            }
        }
        self.columns.extend(open);
        self.columns.extend(newer);
        self.bytes = self.columns.iter().map(size).sum();
        // Where nothing joins, the oldest go.
        if self.columns.len() > half + half / 2 + 2 {
            self.bytes -= self.columns.drain(..half / 2).map(|column| size(&column)).sum::<usize>();
        }
    }

    /// The spectra that touch the span, in order.
    #[must_use]
    pub fn in_span(&self, span: Span) -> impl DoubleEndedIterator<Item = &SpectrumColumn> {
        let from = self.columns.partition_point(|column| column.span[1] < span.from_s);
        let to = self.columns.partition_point(|column| column.span[0] <= span.to_s);
        self.columns.range(from..to.max(from))
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// Power (dB) of a byte of [`SpectrumColumn::bins`].
    #[must_use]
    pub fn db(byte: u8) -> f32 {
        DB_STEP.mul_add(f32::from(byte), DB_BASE)
    }

    /// Bytes it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let free = self.columns.capacity() - self.columns.len();
        self.bytes + free * size_of::<SpectrumColumn>()
    }
}

fn size(column: &SpectrumColumn) -> usize {
    size_of::<SpectrumColumn>() + super::allocated(column.bins.len())
}
