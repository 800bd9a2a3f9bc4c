//! History of one channel: its samples, and the numbers of any stretch of them.

use super::node::Sum;
use super::store::{LEAF, Samples, Store};
use crate::num::{count, whole};
use crate::{channel::Channel, span::Span};
use core::ops::Range;
use grip_record::HUGE_READING;

/// Columns of more samples than this begin where a group of 32 does.
const COARSE: u64 = 256;
/// Extremes further from the middle than this many times what nine of ten parts show are left out.
const BEYOND: f32 = 1e5;

/// What a column of pixels shows of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bucket {
    /// Where it begins (s).
    pub from_s: f64,
    /// Where it ends (s), not included.
    pub to_s: f64,
    /// The lowest sample; NaN where there is none.
    pub min: f32,
    /// The highest one.
    pub max: f32,
    /// Finite samples.
    pub count: u64,
    /// Whether samples are missing in it or right before it.
    pub broken: bool,
}

/// Numbers of a stretch of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stats {
    /// The lowest sample.
    pub min: f32,
    /// The highest one.
    pub max: f32,
    /// The mean.
    pub mean: f64,
    /// Root of the mean square.
    pub rms: f64,
    /// Finite samples.
    pub count: u64,
}

impl Stats {
    /// From the lowest to the highest.
    #[must_use]
    pub fn peak_to_peak(&self) -> f32 {
        self.max - self.min
    }
}

/// One channel's history.
#[derive(Clone, Debug)]
pub struct Series {
    channel: Channel,
    pub(super) store: Store,
    /// What is known of a recording beyond the part that is loaded.
    preview: Store,
    /// Points further apart than this (s) have a gap between them.
    patience_s: f64,
    last: Option<(f64, f32)>,
    /// Samples that came before the last one and were left out.
    pub(super) misplaced: u64,
    /// Finite samples beyond [`HUGE_READING`]: no reading of a gripper.
    pub(super) huge: u64,
    /// Samples that are no number.
    pub(super) nan: u64,
}

impl Series {
    pub(super) fn new(channel: Channel) -> Self {
        // Rows are numbered, so that their gaps are known; anything else comes at least every 10 ms while samples do.
        let patience_s = if channel.is_row() { f64::INFINITY } else { 0.5 };
        let (store, preview) = (Store::default(), Store::default());
        Self { channel, store, preview, patience_s, last: None, misplaced: 0, huge: 0, nan: 0 }
    }

    /// Takes a sample; one that is before the last one is counted and left out.
    pub(super) fn push(&mut self, t_s: f64, value: f32, broken: bool) {
        let last_s = self.last.map_or(f64::NEG_INFINITY, |(t_s, _)| t_s);
        if t_s < last_s || !t_s.is_finite() {
            self.misplaced += 1;
            return;
        }
        self.huge += u64::from(value.abs() >= HUGE_READING);
        self.nan += u64::from(value.is_nan());
        let broken = broken || (self.last.is_some() && t_s - last_s > self.patience_s);
        self.store.push(t_s, value, broken);
        self.last = Some((t_s, value));
    }

    /// Takes a sample of what is not loaded yet.
    pub(super) fn push_preview(&mut self, t_s: f64, value: f32, broken: bool) {
        let in_order = self.preview.span().is_none_or(|(_, last_s)| t_s >= last_s);
        if in_order && t_s.is_finite() {
            self.preview.push(t_s, value, broken);
        }
    }

    pub(super) fn forget_preview(&mut self) {
        self.preview = Store::default();
    }

    /// Bytes it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + self.store.bytes() + self.preview.bytes()
    }

    /// Which channel it is.
    #[must_use]
    pub const fn channel(&self) -> Channel {
        self.channel
    }

    /// From the first to the last sample, previewed ones included; `None` while there is none.
    #[must_use]
    pub fn span(&self) -> Option<Span> {
        let span = |(from_s, to_s)| Span { from_s, to_s };
        match (self.store.span().map(span), self.preview.span().map(span)) {
            (Some(loaded), Some(preview)) => Some(loaded.union(preview)),
            (loaded, preview) => loaded.or(preview),
        }
    }

    /// The last sample.
    #[must_use]
    pub const fn latest(&self) -> Option<(f64, f32)> {
        self.last
    }

    /// Whether it has samples, and all of them are before `t_s`.
    pub(super) fn is_before(&self, t_s: f64) -> bool {
        self.last.is_some_and(|(last_s, _)| last_s < t_s)
    }

    /// Numbers of the samples in the span, both ends included.
    pub(super) fn numbers(&self, span: Span) -> Range<u64> {
        let from = self.store.index(span.from_s, 0);
        from..self.store.index(span.to_s.next_up(), from)
    }

    /// Writes the samples of the span to `out` where they are at most `most`, with the ones right before and behind it; a NaN stands where
    /// samples are missing. `false`, and an empty `out`, where they are more.
    pub fn points(&self, span: Span, most: usize, out: &mut Vec<[f64; 2]>) -> bool {
        out.clear();
        let Range { start, end } = self.numbers(span);
        if end - start > most as u64 {
            return false;
        }
        // One more at each side, so that a line leaves the plot.
        let first = start.saturating_sub(1).max(self.store.first());
        for number in first..(end + 1).min(self.store.end()) {
            let t_s = self.store.time(number).unwrap_or(f64::NAN);
            // What lies before the first point is not seen.
            if number > first && self.store.is_break(number) {
                out.push([t_s, f64::NAN]);
            }
            out.push([t_s, f64::from(self.store.value(number))]);
        }
        true
    }

    /// The samples of the span, both ends included, whatever becomes of the series meanwhile.
    pub(crate) fn samples(&self, span: Span) -> Samples {
        self.store.samples(self.numbers(span))
    }

    /// The last sample at or before `t_s`. `None` before the first one, beyond the last, and in gaps.
    #[must_use]
    pub fn at(&self, t_s: f64) -> Option<f32> {
        let (from_s, to_s) = self.store.span()?;
        if !(from_s..=to_s).contains(&t_s) {
            return None;
        }
        let behind = self.store.index(t_s.next_up(), 0);
        let number = behind.checked_sub(1)?;
        let at_s = self.store.time(number)?;
        let mut most_s = self.patience_s;
        if self.store.is_break(behind) {
            let before_s = number.checked_sub(1).filter(|_| !self.store.is_break(number));
            let step_s = before_s.and_then(|n| self.store.time(n)).map_or(0.0, |s| at_s - s);
            most_s = most_s.min(1.5 * step_s);
        }
        (t_s - at_s <= most_s).then(|| self.store.value(number))
    }

    /// Numbers of the samples in the span, both ends included; `None` where there is no finite one.
    #[must_use]
    pub fn stats(&self, span: Span) -> Option<Stats> {
        let mut sum = Sum::default();
        self.store.fold(self.numbers(span), &mut sum);
        let Sum { min, max, count, .. } = sum;
        let (mean, rms) = (sum.mean(), sum.rms());
        (count > 0).then_some(Stats { min, max, mean, rms, count })
    }

    /// Writes what each of `columns` equal parts of the span shows to `out`, parts without samples left out.
    ///
    /// Every sample of the span counts in exactly one part, so that a spike of one sample is never lost. Parts of at most 256 samples hold
    /// exactly those of their time; longer ones begin where a group of 32 does, at most 16 samples away. The ends of the span are exact.
    pub fn envelope(&self, span: Span, columns: usize, out: &mut Vec<Bucket>) {
        out.clear();
        let Some(have) = self.span().and_then(|have| have.common(span)) else { return };
        if columns == 0 || span.length_s() <= 0.0 {
            return;
        }
        let width_s = span.length_s() / count(columns);
        let edge = |column: usize| width_s.mul_add(count(column), span.from_s);
        // Columns before the first and behind the last sample are not looked at.
        let first = whole((have.from_s - span.from_s) / width_s).saturating_sub(1);
        let last = whole((have.to_s - span.from_s) / width_s).saturating_add(2).min(columns);
        let loaded_s = self.store.span().map_or(f64::NEG_INFINITY, |(_, last_s)| last_s);
        let mut next = [self.numbers(span).start, self.preview.index(span.from_s, 0)];
        for column in first..last {
            let to_s = if column + 1 == columns { span.to_s.next_up() } else { edge(column + 1) };
            let is_last = column + 1 == columns;
            let mut sum = part(&self.store, &mut next[0], to_s, is_last);
            if self.preview.end() > 0 {
                let preview = part(&self.preview, &mut next[1], to_s, is_last);
                sum = if sum.is_empty() && to_s > loaded_s { preview } else { sum };
            }
            if !sum.is_empty() {
                out.push(bucket(edge(column), edge(column + 1), &sum));
            }
        }
    }

    /// The least and the greatest value that an axis should show in the span: extremes of single readings that no gripper sends (1e30
    /// beside micrometres) are left out. `None` where there is nothing to show.
    #[must_use]
    pub fn robust_range(&self, span: Span) -> Option<(f32, f32)> {
        let mut parts = Vec::new();
        self.envelope(span, 256, &mut parts);
        let ends = parts.iter().flat_map(|part| [part.min, part.max]);
        let mut values: Vec<f32> = ends.filter(|value| value.abs() < HUGE_READING).collect();
        values.sort_by(f32::total_cmp);
        let middle = *values.get(values.len() / 2)?;
        let mut off: Vec<f32> = values.iter().map(|value| (value - middle).abs()).collect();
        off.sort_by(f32::total_cmp);
        let usual = off.get(off.len() * 9 / 10).copied().unwrap_or(0.0);
        let kept = |value: &&f32| usual <= 0.0 || (**value - middle).abs() <= BEYOND * usual;
        Some((*values.iter().find(kept)?, *values.iter().rev().find(kept)?))
    }
}

/// The samples from `next` to before `to_s`.
fn part(store: &Store, next: &mut u64, to_s: f64, exact: bool) -> Sum {
    let from = *next;
    let mut to = store.index(to_s, from);
    if to - from > COARSE && to < store.end() && !exact {
        to = (to + LEAF / 2) / LEAF * LEAF;
    }
    *next = to.min(store.end());
    let mut sum = Sum::default();
    store.fold(from..*next, &mut sum);
    sum
}

fn bucket(from_s: f64, to_s: f64, sum: &Sum) -> Bucket {
    let Sum { min, max, count, broken, .. } = *sum;
    let (min, max) = if count == 0 { (f32::NAN, f32::NAN) } else { (min, max) };
    Bucket { from_s, to_s, min, max, count, broken }
}
