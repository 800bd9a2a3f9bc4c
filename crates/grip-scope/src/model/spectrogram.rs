//! Spectra in order of time, as many of them as memory allows; the oldest go first.

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
        while self.bytes > most_bytes {
            let oldest = self.columns.pop_front();
            self.bytes -= oldest.map_or(self.bytes, |column| size(&column));
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

#[cfg(test)]
mod tests {
    use super::{Spectrogram, SpectrumColumn};

    #[test]
    fn the_oldest_spectra_go_where_there_are_too_many() {
        let mut spectra = Spectrogram::default();
        for k in 0..1000_u16 {
            let span = [f64::from(k), f64::from(k) + 1.0];
            spectra.push(SpectrumColumn { span, top_hz: 1.0, bins: vec![1; 100].into() }, 20_000);
            assert!(spectra.bytes <= 20_000, "{} at {k}", spectra.bytes);
        }
        let first_s = spectra.columns.front().map(|column| column.span[0]);
        assert_eq!(first_s, Some(1000.0 - spectra.len() as f64));
        assert!(spectra.len() > 100, "{}", spectra.len());
    }
}
