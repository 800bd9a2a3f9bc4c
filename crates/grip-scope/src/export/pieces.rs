//! A model that others fill and show meanwhile in; the samples of a span, a piece at each short look, out.

use crate::{model::Series, span::Span};

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
}

impl Rest {
    pub(super) const fn new(span: Span) -> Self {
        Self { from_s: span.from_s, to_s: span.to_s, done: false }
    }

    /// The next piece, its ends included; `None` behind the last. `reach_s`: how far a look gets in each channel, see [`reach`]. Rows
    /// whose channels differ a little in their times stay together.
    pub(super) fn next(&mut self, reach_s: impl Iterator<Item = Option<f64>>) -> Option<Span> {
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

    /// Where the next piece begins (s).
    pub(super) const fn begin_s(&self) -> f64 {
        self.from_s
    }
}

/// How far a look gets in this channel: the time of the first sample that is too many (s), `None` where there is none.
pub(super) fn reach(series: &Series, from_s: f64) -> Option<f64> {
    series.time_of(from_s, PIECE)
}

#[cfg(test)]
mod tests {
    use super::{PIECE, Rest, reach};
    use crate::feed::{Feed, RowBlock};
    use crate::{Channel, Model, Span};

    fn model(times_us: Vec<u64>) -> Model {
        let mut model = Model::new(64 << 20);
        #[expect(clippy::cast_precision_loss, reason = "a test")]
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
        let mut rest = Rest::new(Span::new(0.5, 81.99));
        let (mut copied, mut piece, mut pieces) = (Vec::new(), Vec::new(), 0);
        while let Some(span) = rest.next([reach(series, rest.begin_s())].into_iter()) {
            assert!(series.copy(span, &mut piece));
            assert!(piece.len() <= PIECE, "{}", piece.len());
            copied.extend(piece.iter().map(|point| point[1]));
            pieces += 1;
        }
        let wanted: Vec<f64> = (5_000..28_000).map(f64::from).collect();
        assert_eq!(copied, wanted);
        assert_eq!(pieces, 23_000_usize.div_ceil(PIECE));
    }
}
