//! Samples in; blocks of rows, and what the observer derives from them, out.

use super::reported::Blocks;
use crate::derive::Observer;
use crate::feed::{DerivedBlock, Feed};
use slip_core::{Sample, Step};

/// Samples on their way to the model.
#[derive(Default)]
pub(super) struct Stream {
    blocks: Blocks,
    observer: Option<Observer>,
    done: Vec<Feed>,
}

impl Stream {
    /// What is derived from now on, and with which settings; `None` for nothing.
    pub(super) fn observe(&mut self, observer: Option<Observer>) {
        self.flush();
        self.observer = observer;
        if let Some(observer) = &mut self.observer {
            observer.interrupt();
        }
    }

    /// Takes a sample and the frame of the array that came with it: what the observer states.
    pub(super) fn push(&mut self, sample: &Sample, taxels: &[f32]) -> Option<Step> {
        self.blocks.push(sample, taxels);
        self.observer.as_mut().and_then(|observer| observer.push(sample, taxels))
    }

    /// Rows are missing before the next sample; how many, where that is known, otherwise 0.
    pub(super) fn broken(&mut self, lost: u32) {
        // What was derived before the break goes before it.
        self.flush();
        let none = self.blocks.broken(lost);
        self.done.extend(none.map(Feed::Rows));
        if let Some(observer) = &mut self.observer {
            observer.interrupt();
        }
    }

    /// Rows that wait.
    pub(super) fn len(&self) -> usize {
        self.blocks.len()
    }

    fn flush(&mut self) {
        self.done.extend(self.blocks.take().map(Feed::Rows));
        let derived = self.observer.as_mut().map(Observer::take);
        let worth = |block: &DerivedBlock| {
            let parts = block.bands.len() + block.turns.len() + block.evidence.len();
            parts + block.spectra.len() > 0
        };
        if let Some(block) = derived.filter(worth) {
            self.done.push(Feed::Derived(Box::new(block)));
        }
    }

    /// Everything so far, in order.
    pub(super) fn take(&mut self) -> Vec<Feed> {
        self.flush();
        core::mem::take(&mut self.done)
    }
}
