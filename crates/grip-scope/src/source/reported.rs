//! Conversion of messages of a daemon to items for the model.

use crate::channel::Channel;
use crate::feed::{EventKind, EventMark, Feed, RowBlock, TaxelBlock};
use slip_core::Sample;

/// What became of a command: a line for people, and the same among the events.
pub(super) fn answer(text: String) -> [Feed; 2] {
    let mark = EventMark::plain(f64::NAN, EventKind::Client, text.clone());
    [Feed::Event(mark), Feed::Notice(text)]
}

/// Samples on their way into blocks of one set of channels.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    block: RowBlock,
    /// Rows of the last block: the next one has about as many.
    usual: usize,
}

impl Blocks {
    /// Adds a sample with the frame of the array that came with it.
    pub(super) fn push(&mut self, sample: &Sample, taxels: &[f32]) {
        let row = self.block.times_us.len();
        if row == 0 {
            self.block.times_us.reserve(self.usual);
        }
        self.block.times_us.push(sample.t.0);
        for (channel, value) in Channel::ROWS.into_iter().zip(sample.readings()) {
            match self.block.columns.iter_mut().find(|(known, _)| *known == channel) {
                Some((_, column)) => column.push(value.unwrap_or(f32::NAN)),
                None if value.is_some() => {
                    let mut column = Vec::with_capacity(self.usual.max(row + 1));
                    column.resize(row, f32::NAN);
                    column.push(value.unwrap_or(f32::NAN));
                    self.block.columns.push((channel, column));
                }
                None => {}
            }
        }
        self.push_taxels(taxels, row);
    }

    fn push_taxels(&mut self, taxels: &[f32], row: usize) {
        if taxels.is_empty() && self.block.taxels.is_none() {
            return;
        }
        let block = self.block.taxels.get_or_insert_with(|| TaxelBlock {
            count: taxels.len(),
            values: vec![f32::NAN; row * taxels.len()],
        });
        let none = core::iter::repeat(&f32::NAN);
        block.values.extend(taxels.iter().chain(none).take(block.count));
    }

    /// The rows so far.
    pub(super) fn take(&mut self) -> Option<RowBlock> {
        if self.block.times_us.is_empty() {
            return None;
        }
        self.usual = self.block.times_us.len();
        Some(core::mem::take(&mut self.block))
    }

    /// Rows are missing before the next one: the rows so far, and the next block shows it.
    pub(super) fn broken(&mut self, lost: u32) -> Option<RowBlock> {
        let before = self.take();
        self.block.broken = true;
        self.block.lost = self.block.lost.saturating_add(lost);
        before
    }
}
