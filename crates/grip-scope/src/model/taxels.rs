//! Frames of the pressure array in, the frame at a time out.

use crate::feed::TaxelBlock;
use crate::span::Span;
use std::collections::VecDeque;

/// Bytes kept; the oldest frames go first.
const MOST_BYTES: usize = 16 << 20;
/// Frames closer together than this (s) are not all kept: nobody sees them.
const STEP_S: f64 = 0.01;

/// One frame of the array.
#[derive(Clone, Debug, PartialEq)]
pub struct TaxelFrame {
    /// When (s).
    pub t_s: f64,
    /// Readings; NaN: none.
    pub values: Vec<f32>,
}

/// The frames that are kept.
#[derive(Clone, Debug, Default)]
pub(super) struct Taxels {
    frames: VecDeque<TaxelFrame>,
    bytes: usize,
}

impl Taxels {
    /// Takes the frame of row `row`.
    pub(super) fn push(&mut self, t_s: f64, block: &TaxelBlock, row: usize) {
        if self.frames.back().is_some_and(|last| t_s - last.t_s < STEP_S) {
            return;
        }
        let from = row * block.count;
        let Some(values) = block.values.get(from..from + block.count) else { return };
        if values.iter().all(|value| value.is_nan()) {
            return;
        }
        self.frames.push_back(TaxelFrame { t_s, values: values.to_vec() });
        self.bytes += frame_bytes(values.len());
        while self.bytes > MOST_BYTES {
            let gone = self.frames.pop_front();
            self.bytes -= gone.map_or(self.bytes, |frame| frame_bytes(frame.values.len()));
        }
    }

    /// The last frame at or before `t_s`.
    pub(super) fn at(&self, t_s: f64) -> Option<&TaxelFrame> {
        let behind = self.frames.partition_point(|frame| frame.t_s <= t_s);
        self.frames.get(behind.checked_sub(1)?)
    }

    /// The frames of a span, its ends included.
    pub(super) fn within(&self, span: Span) -> impl Iterator<Item = &TaxelFrame> {
        let from = self.frames.partition_point(|frame| frame.t_s < span.from_s);
        self.frames.range(from..).take_while(move |frame| frame.t_s <= span.to_s)
    }

    pub(super) fn bytes(&self) -> usize {
        let free = self.frames.capacity() - self.frames.len();
        self.bytes + free * size_of::<TaxelFrame>()
    }
}

fn frame_bytes(values: usize) -> usize {
    size_of::<TaxelFrame>() + super::allocated(4 * values)
}
