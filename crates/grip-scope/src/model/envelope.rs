//! A span and a number of columns of pixels in; what each of them shows of a channel out.

use super::node::Light;
use super::series::{Bucket, Series};
use super::store::{Place, Store};
use crate::span::Span;

impl Series {
    /// Writes what each of `columns` equal parts of the span shows to `out`, parts without samples left out.
    ///
    /// Every sample of the span counts in exactly one part, so that a spike of one sample is never lost; where samples are thinned out,
    /// groups of 32 count in the part in which they begin. Parts of few samples (below 128 at an even rate) hold exactly the samples of
    /// their time. Of longer ones samples within an eighth of a part from the border between two may count in the neighbour: parts are cut
    /// where groups of 32, 128 or 1024 samples begin, so that a part costs the same whether it holds ten samples or ten million. The ends
    /// of the span are exact.
    pub fn envelope(&self, span: Span, columns: usize, out: &mut Vec<Bucket>) {
        out.clear();
        let Some(have) = self.span() else { return };
        if columns == 0 || span.length_s() <= 0.0 || have.common(span).is_none() {
            return;
        }
        let loaded_s = self.store().span().map_or(f64::NEG_INFINITY, |(_, last_s)| last_s);
        let width_s = span.length_s() / count(columns);
        let edge = |column: usize| width_s.mul_add(count(column), span.from_s);
        // Columns before the first and behind the last sample are not looked at.
        let first = columns_before(have.from_s - span.from_s, width_s);
        let last = columns_before(have.to_s - span.from_s, width_s).saturating_add(3).min(columns);
        let mut walks = [Walk::new(self.store(), None), Walk::new(self.preview(), None)];
        for column in first..last {
            let (from_s, to_s) = (edge(column), edge(column + 1));
            let end = if column + 1 == columns { End::Closed } else { End::Near(width_s / 8.0) };
            let [loaded, preview] = &mut walks;
            let mut sum = loaded.part(from_s, to_s, end);
            if sum.is_empty() && to_s > loaded_s {
                sum = preview.part(from_s, to_s, end);
            }
            if !sum.is_empty() {
                out.push(bucket(from_s, to_s, &sum));
            }
        }
    }
}

/// Walks over the samples part by part.
pub(super) struct Walk<'a> {
    store: &'a Store,
    /// Where the last part ended, and its place.
    next: Option<(f64, Place)>,
}

/// How a part ends.
#[derive(Clone, Copy, Debug)]
pub(super) enum End {
    /// With the sample at its end.
    Closed,
    /// Before the sample at its end, or at a cheaper place that is off by at most so much (s).
    Near(f64),
}

impl<'a> Walk<'a> {
    /// A walk from the first part that is asked for, or on from where another one ended.
    pub(super) const fn new(store: &'a Store, next: Option<(f64, Place)>) -> Self {
        Self { store, next }
    }

    /// Where the last part ended.
    pub(super) fn place(&self) -> Option<Place> {
        self.next.map(|(_, place)| place)
    }

    /// The samples from `from_s`, or from where the part before was cut, to the end. Parts are asked for in order.
    pub(super) fn part(&mut self, from_s: f64, to_s: f64, end: End) -> Light {
        let from = match self.next {
            Some((end_s, place)) if end_s == from_s => place,
            Some((_, place)) => self.store.place(from_s, place.chunk).max(place),
            None => self.store.place(from_s, 0),
        };
        let to = match end {
            End::Closed => self.store.place(to_s.next_up(), from.chunk),
            End::Near(most_s) => {
                self.store.cut(self.store.place(to_s, from.chunk), to_s, most_s).max(from)
            }
        };
        self.next = Some((to_s, to));
        let mut sum = Light::default();
        self.store.fold(from, to, &mut sum);
        sum
    }
}

#[expect(clippy::cast_possible_truncation, reason = "kept with seven digits")]
pub(super) fn bucket(from_s: f64, to_s: f64, sum: &Light) -> Bucket {
    let Light { min, max, count, broken, .. } = *sum;
    let (min, max) = if count == 0 { (f32::NAN, f32::NAN) } else { (min, max) };
    let mean = if count == 0 { f32::NAN } else { sum.mean() as f32 };
    Bucket { from_s, to_s, min, max, mean, count, broken }
}

#[expect(clippy::cast_precision_loss, reason = "columns of a screen")]
fn count(columns: usize) -> f64 {
    columns as f64
}

/// Whole columns in a stretch of time.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn columns_before(stretch_s: f64, width_s: f64) -> usize {
    // One less, so that rounding at an edge costs a look and not a sample.
    ((stretch_s / width_s).max(0.0) as usize).saturating_sub(1)
}
