//! A model that others fill and show meanwhile in; the samples of a span, a piece at each short look, out.

use super::ExportError;
use crate::channel::Channel;
use crate::{model::Model, span::Span};

/// Samples of a channel copied at one look, at most; only samples of one time are never parted.
pub(super) const PIECE: usize = 4096;
/// Times that differ by less than this (s) are one row.
pub(super) const SAME_S: f64 = 1e-6;

/// What of the span was not copied yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest {
    from_s: f64,
    to_s: f64,
    done: bool,
    /// What the model had dropped when the copy began (s).
    dropped_s: Option<f64>,
}

impl Rest {
    pub(super) fn new(span: Span, model: &Model) -> Self {
        let dropped_s = model.dropped_s();
        Self { from_s: span.from_s, to_s: span.to_s, done: false, dropped_s }
    }

    /// The next piece of these channels, its ends included; `None` behind the last. Rows whose channels differ a little in their times
    /// stay together.
    ///
    /// # Errors
    /// Where the model has dropped samples meanwhile that were not copied yet.
    pub(super) fn next(
        &mut self,
        model: &Model,
        channels: impl Iterator<Item = Channel>,
    ) -> Result<Option<Span>, ExportError> {
        let dropped_s = model.dropped_s().filter(|_| !self.done);
        if dropped_s.is_some_and(|s| Some(s) > self.dropped_s && s >= self.from_s) {
            return Err(ExportError::Dropped);
        }
        let series = channels.filter_map(|channel| model.series(channel));
        let reach_s: Vec<Option<f64>> =
            series.map(|series| series.time_of(self.from_s, PIECE)).collect();
        Ok(self.advance(reach_s.into_iter()))
    }

    /// Goes on up to the first sample that is too many of any channel (s); `None`: of this one there are not so many.
    fn advance(&mut self, reach_s: impl Iterator<Item = Option<f64>>) -> Option<Span> {
        if self.done {
            return None;
        }
        let (from_s, nearest_s) = (self.from_s, reach_s.flatten().fold(f64::INFINITY, f64::min));
        // More samples of one time than a piece holds still go on.
        let end_s = (nearest_s - SAME_S).max((from_s + SAME_S).max(from_s.next_up()));
        if end_s > self.to_s {
            self.done = true;
            return Some(Span { from_s, to_s: self.to_s });
        }
        self.from_s = end_s;
        Some(Span { from_s, to_s: end_s.next_down() })
    }
}

#[cfg(test)]
mod tests {
    use super::{PIECE, Rest};
    use crate::feed::{Feed, RowBlock};
    use crate::{Channel, Model, Span};

    fn model(times_us: Vec<u64>) -> Model {
        let mut model = Model::new(64 << 20);
        let values = (0..times_us.len()).map(|row| row as f32).collect();
        let columns = vec![(Channel::Stylus, values)];
        model.take(Feed::Rows(RowBlock { times_us, columns, ..RowBlock::default() }));
        model
    }

    #[test]
    fn every_sample_of_a_span_is_in_one_piece_and_no_piece_is_long() {
        // Uneven: 10 kHz, then 100 Hz.
        let even = (0..20_000_u64).map(|row| 100 * row);
        let model = model(even.chain((0..9_000).map(|row| 2_000_000 + 10_000 * row)).collect());
        let series = model.series(Channel::Stylus).unwrap();
        let mut rest = Rest::new(Span::new(0.5, 81.99), &model);
        let (mut copied, mut piece, mut pieces) = (Vec::new(), Vec::new(), 0);
        while let Some(span) = rest.next(&model, model.channels()).unwrap() {
            series.copy(span, &mut piece);
            assert!(piece.len() <= PIECE, "{}", piece.len());
            copied.extend(piece.iter().map(|point| point[1]));
            pieces += 1;
        }
        let wanted: Vec<f64> = (5_000..28_000).map(f64::from).collect();
        assert_eq!(copied, wanted);
        assert_eq!(pieces, 23_000_usize.div_ceil(PIECE));
    }
}
