//! A curve that goes on and the span that is seen of it in; its columns out, of which only those are made that were not there before.
//!
//! Columns stand at whole multiples of their width and not at the edge of the span: one that all its samples have come for never changes, however
//! the span moves, and a curve that runs across the window does not flicker.

use super::envelope::{End, Walk, bucket};
use super::series::{Bucket, Series};
use super::store::Place;
use crate::span::Span;

/// Widths that differ by less than this share are one width: those of a span that moves do, by rounding.
const SAME_WIDTH: f64 = 1e-9;
/// Columns are numbered from time 0 on; beyond this number their edges are no longer distinguished well.
const MOST: f64 = 1e12;

/// Columns of one series, kept from one look to the next.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    width_s: f64,
    buckets: Vec<Bucket>,
    /// How many of them from the front will not change any more.
    settled: usize,
    /// Number of the first column that was looked at.
    first: f64,
    /// Number of the column behind the last settled one, and where its samples begin.
    next: Option<(f64, Place)>,
}

impl Columns {
    /// Brings the columns to what `series` holds in the span now, as [`Series::envelope`] has them but for their edges: these stand at whole
    /// multiples of the width, so that the first and the last column may reach beyond the span by less than their width. Always ask with
    /// the same series; another one needs columns of its own.
    pub fn update(&mut self, series: &Series, span: Span, columns: usize) {
        let width_s = span.length_s() / exact(columns.max(1));
        let usable = width_s > 0.0 && (span.from_s.abs().max(span.to_s.abs()) / width_s) < MOST;
        if !usable || series.preview().span().is_some() {
            // What is still being loaded may change anywhere.
            *self = Self::default();
            series.envelope(span, columns, &mut self.buckets);
            return;
        }
        if (self.width_s - width_s).abs() > SAME_WIDTH * width_s {
            *self = Self { width_s, ..Self::default() };
        }
        let Some((have_from_s, have_to_s)) = series.store().span() else {
            *self = Self { width_s, ..Self::default() };
            return;
        };
        let number = |t_s: f64| (t_s / self.width_s).floor();
        let first = number(span.from_s.max(have_from_s));
        let last = number(span.to_s.min(have_to_s));
        self.keep(first, last);
        self.add(series, first, last, have_to_s);
    }

    /// The columns, in order; parts without samples are left out.
    #[must_use]
    pub fn buckets(&self) -> &[Bucket] {
        &self.buckets
    }

    /// Forgets columns that may still change, and those before `first`; all of them unless those from `first` to `last` go on from what was
    /// looked at before.
    fn keep(&mut self, first: f64, last: f64) {
        let goes_on = |(next, _)| (first..=last + 1.0).contains(&next);
        let follows = first >= self.first && self.next.is_some_and(goes_on);
        if !follows {
            *self = Self { width_s: self.width_s, first, ..Self::default() };
            return;
        }
        self.buckets.truncate(self.settled);
        let from_s = first * self.width_s;
        let gone = self.buckets.partition_point(|bucket| bucket.from_s < from_s);
        self.buckets.drain(..gone);
        self.settled -= gone;
        self.first = first;
    }

    /// Makes the columns up to the one of the number `last` that are not there yet.
    fn add(&mut self, series: &Series, first: f64, last: f64, have_to_s: f64) {
        let (mut number, place) = match self.next {
            Some((number, place)) => (number, Some(place)),
            None => (first, None),
        };
        let edge = |number: f64| number * self.width_s;
        let mut walk = Walk::new(series.store(), place.map(|place| (edge(number), place)));
        while number <= last {
            let (from_s, to_s) = (edge(number), edge(number + 1.0));
            let sum = walk.part(from_s, to_s, End::Near(self.width_s / 8.0));
            if !sum.is_empty() {
                self.buckets.push(bucket(from_s, to_s, &sum));
            }
            number += 1.0;
            if have_to_s >= to_s {
                self.settled = self.buckets.len();
                self.next = walk.place().map(|place| (number, place));
            }
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "columns of a screen")]
const fn exact(columns: usize) -> f64 {
    columns as f64
}

#[cfg(test)]
mod tests {
    use super::{Bucket, Columns, Series, Span};
    use crate::channel::Channel;
    use proptest::prelude::{
        Just, Strategy, TestCaseError, any, prop_assert, prop_oneof, proptest,
    };

    /// Values are the numbers of their samples: what a column holds can be seen from its extremes.
    fn grow(series: &mut Series, times: &mut Vec<f64>, steps: &[(u32, bool)]) {
        for (step_us, broken) in steps {
            let t_s = times.last().map_or(1.0, |last_s| last_s + 1e-6 * f64::from(*step_us));
            series.push(t_s, f32::from(u16::try_from(times.len()).unwrap()), *broken);
            times.push(t_s);
        }
    }

    /// Every sample of the span is in one column, in order, and in the one of its time but for an eighth of a column at the borders.
    fn check(buckets: &[Bucket], times: &[f64], span: Span) -> Result<(), TestCaseError> {
        let mut next = None;
        for part in buckets.iter().filter(|part| part.count > 0) {
            let (low, high) = (place(part.min), place(part.max));
            prop_assert!(next.is_none_or(|next| next == low), "{next:?} {part:?}");
            prop_assert!(part.count == (high - low + 1) as u64, "{part:?}");
            let near_s = (part.to_s - part.from_s) / 8.0 + 3e-6;
            prop_assert!(times[low] >= part.from_s - near_s && times[high] <= part.to_s + near_s);
            next = Some(high + 1);
        }
        let wanted: Vec<usize> = (0..times.len()).filter(|k| span.holds(times[*k])).collect();
        if let (Some(first), Some(last)) = (wanted.first(), wanted.last()) {
            let have = buckets.iter().find(|part| part.count > 0).map(|part| place(part.min));
            prop_assert!(have.is_some_and(|have| have <= *first), "{have:?} after {first}");
            prop_assert!(next.is_some_and(|next| next > *last), "{next:?} before {last}");
        }
        Ok(())
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place")]
    fn place(value: f32) -> usize {
        value as usize
    }

    /// What is done between two looks.
    #[derive(Clone, Debug)]
    enum Act {
        Grow(Vec<(u32, bool)>),
        /// Looks at a span so long that ends so far before the newest sample (s), in so many columns.
        Look(f64, f64, usize),
        Thin,
        Drop,
    }

    fn acts() -> impl Strategy<Value = Vec<Act>> {
        let step = prop_oneof![30 => Just(50_u32), 1 => 1_u32..200, 1 => 1000_u32..20_000];
        let steps = proptest::collection::vec((step, proptest::bool::weighted(0.002)), 1..900);
        let length_s = prop_oneof![4 => Just(0.1), 1 => 0.001..0.3];
        let look = (
            length_s,
            prop_oneof![3 => Just(0.0), 1 => 0.0..0.2],
            prop_oneof![4 => Just(40_usize), 1 => 1_usize..400],
        );
        let act = prop_oneof![
            8 => steps.prop_map(Act::Grow),
            8 => look.prop_map(|(length_s, before_s, columns)| Act::Look(length_s, before_s, columns)),
            1 => any::<bool>().prop_map(|thin| if thin { Act::Thin } else { Act::Drop }),
        ];
        proptest::collection::vec(act, 1..60)
    }

    proptest! {
        #![proptest_config(proptest::test_runner::Config::with_cases(128))]

        #[test]
        fn kept_columns_hold_every_sample_of_the_span_once_however_it_moves(acts in acts()) {
            let (mut series, mut times) = (Series::new(Channel::Stylus), Vec::new());
            let mut columns = Columns::default();
            let mut dropped = false;
            for act in acts {
                match act {
                    Act::Grow(steps) => grow(&mut series, &mut times, &steps),
                    Act::Thin => series.store_mut().thin_oldest(),
                    Act::Drop => {
                        series.store_mut().drop_oldest();
                        dropped = true;
                    }
                    Act::Look(length_s, before_s, count) => {
                        let to_s = times.last().copied().unwrap_or(1.0) - before_s;
                        let span = Span::new(to_s - length_s, to_s);
                        columns.update(&series, span, count);
                        let have = series.store().span().map_or(f64::INFINITY, |(from_s, _)| from_s);
                        let seen = Span { from_s: span.from_s.max(have), to_s };
                        // Where samples are thinned out, groups of them count where they begin.
                        if series.thin_before_s().is_none_or(|thin_s| thin_s < span.from_s - length_s) {
                            check(columns.buckets(), &times, seen)?;
                        }
                        let outside = |part: &&Bucket| part.to_s <= span.from_s || part.from_s > span.to_s;
                        prop_assert!(dropped || !columns.buckets().iter().any(|part| outside(&part)));
                    }
                }
            }
        }
    }

    #[test]
    fn a_curve_whose_history_has_gone_has_no_columns() {
        let (mut series, mut times) = (Series::new(Channel::Stylus), Vec::new());
        grow(&mut series, &mut times, &[(50, false); 1024]);
        let mut columns = Columns::default();
        let span = Span::new(1.0, 1.05);
        columns.update(&series, span, 100);
        assert!(!columns.buckets().is_empty());
        series.store_mut().drop_oldest();
        columns.update(&series, span, 100);
        assert_eq!(columns.buckets(), []);
    }

    #[test]
    fn a_column_that_is_over_stays_as_it_is_while_the_span_moves() {
        let (mut series, mut times) = (Series::new(Channel::Stylus), Vec::new());
        grow(&mut series, &mut times, &[(50, false); 4000]);
        let mut columns = Columns::default();
        let look = |columns: &mut Columns, series: &Series, to_s: f64| {
            columns.update(series, Span::new(to_s - 0.1, to_s), 100);
            columns.buckets().to_vec()
        };
        let before = look(&mut columns, &series, times[3999]);
        grow(&mut series, &mut times, &[(50, false); 333]);
        let after = look(&mut columns, &series, times[4332]);
        let both: Vec<_> = before.iter().filter(|part| after.contains(part)).collect();
        // A hundred columns of twenty samples; 333 are seventeen columns, of which the one that was under way is another now.
        assert!((82..=84).contains(&both.len()), "{} of {}", both.len(), before.len());
    }
}
