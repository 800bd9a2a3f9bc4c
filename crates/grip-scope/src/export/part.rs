//! What of the model is exported: taken at one look, so that nothing waits for a file and nothing is lost while it is written.

use crate::channel::Channel;
use crate::model::{Model, Samples, TaxelFrame};
use crate::span::Span;

/// Times that differ by less than this (s) are one row.
pub(super) const SAME_S: f64 = 1e-6;

/// The samples of some channels in a span, with the frames of the pressure array.
#[derive(Clone, Debug)]
pub struct Part {
    pub(super) columns: Vec<Column>,
    pub(super) frames: Vec<TaxelFrame>,
}

/// One channel of it, and the next of its samples that are numbers.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub(super) channel: Channel,
    pub(super) name: &'static str,
    rest: Samples,
    /// Time (s), value, and whether something is missing before it.
    next: Option<(f64, f32, bool)>,
}

impl Part {
    /// What the model holds of these channels, those without a sample left out.
    #[must_use]
    pub fn of(model: &Model, span: Span, channels: &[Channel]) -> Self {
        let series = channels.iter().filter_map(|channel| model.series(*channel));
        let columns = series.map(|series| {
            // A vibration that is called a stylus would be read as metres.
            let name = match series.channel() {
                Channel::Stylus => model.info().name(Channel::Stylus),
                channel => channel.column(),
            };
            let (channel, rest) = (series.channel(), series.samples(span));
            let mut column = Column { channel, name, rest, next: None };
            column.advance();
            column
        });
        let columns = columns.filter(|column| column.next.is_some()).collect();
        Self { columns, frames: model.taxel_frames(span).cloned().collect() }
    }
}

impl Column {
    /// Time of the next sample (s).
    pub(super) fn next_s(&self) -> Option<f64> {
        self.next.map(|(t_s, ..)| t_s)
    }

    /// The sample at this time, where there is one, and whether something is missing before it.
    pub(super) fn take(&mut self, t_s: f64) -> Option<(f32, bool)> {
        while self.next_s().is_some_and(|at_s| at_s < t_s - SAME_S) {
            self.advance();
        }
        let (_, value, broken) = self.next.filter(|(at_s, ..)| *at_s <= t_s + SAME_S)?;
        self.advance();
        Some((value, broken))
    }

    fn advance(&mut self) {
        let mut missing = false;
        self.next = self.rest.find_map(|(t_s, value, broken)| {
            missing |= broken || value.is_nan();
            (!value.is_nan()).then_some((t_s, value, missing))
        });
    }
}
