//! Samples of one channel in; the samples and figures of any stretch of them out.

use super::chunk::NODE;
use super::node::{Light, Sum};
use super::store::{Place, Store};
use crate::{channel::Channel, span::Span};
use grip_record::HUGE_READING;

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
    /// Mean of the samples.
    pub mean: f32,
    /// Finite samples.
    pub count: u64,
    /// Whether samples are missing in it or right before it.
    pub broken: bool,
}

/// Figures of a stretch of a channel.
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
    /// Whether samples are missing.
    pub broken: bool,
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
    store: Store,
    /// What is known of a recording beyond the part that is loaded.
    preview: Store,
    /// Points further apart than this (s) have a gap between them.
    patience_s: f64,
    last: Option<(f64, f32)>,
    misplaced: u64,
    huge: u64,
    nan: u64,
}

impl Series {
    pub(super) fn new(channel: Channel) -> Self {
        // Rows are numbered, so that their gaps are known; anything else comes at least every 10 ms while samples do.
        let patience_s = if channel.is_row() { f64::INFINITY } else { 0.5 };
        Self {
            channel,
            store: Store::default(),
            preview: Store::default(),
            patience_s,
            last: None,
            misplaced: 0,
            huge: 0,
            nan: 0,
        }
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

    pub(super) const fn preview(&self) -> &Store {
        &self.preview
    }

    pub(super) fn forget_preview(&mut self) {
        self.preview = Store::default();
    }

    pub(super) const fn store(&self) -> &Store {
        &self.store
    }

    pub(super) const fn store_mut(&mut self) -> &mut Store {
        &mut self.store
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

    /// Samples that came before the last one and were left out.
    #[must_use]
    pub const fn misplaced(&self) -> u64 {
        self.misplaced
    }

    /// Finite samples beyond [`HUGE_READING`]: no reading of a gripper.
    #[must_use]
    pub const fn huge(&self) -> u64 {
        self.huge
    }

    /// Samples that are no number.
    #[must_use]
    pub const fn nan(&self) -> u64 {
        self.nan
    }

    /// Time before which only extremes and means of 32 samples are kept.
    #[must_use]
    pub fn thin_before_s(&self) -> Option<f64> {
        self.store.thin_before_s()
    }

    /// Writes the samples of the span to `out` where they are at most `most`, with the ones right before and behind it; a NaN stands where
    /// samples are missing. `false`, and an empty `out`, where they are more, or thinned out.
    pub fn points(&self, span: Span, most: usize, out: &mut Vec<[f64; 2]>) -> bool {
        out.clear();
        let (from, to) = self.places(span);
        let before = self.before(from);
        let store = &self.store;
        if self.is_more_than(most, from, to) {
            return false;
        }
        let mut number = before.chunk;
        while let Some(chunk) = store.chunk(number).filter(|_| number <= to.chunk) {
            let start = if number == before.chunk { before.index } else { 0 };
            // One more than the span holds, so that a line leaves the plot.
            let end =
                if number == to.chunk { (to.index + 1).min(chunk.len()) } else { chunk.len() };
            if chunk.is_thin() {
                out.clear();
                return false;
            }
            if chunk.broken && start == 0 && !out.is_empty() {
                out.push([chunk.time(0), f64::NAN]);
            }
            out.extend((start..end).map(|k| [chunk.time(k), f64::from(chunk.value(k))]));
            number += 1;
        }
        true
    }

    /// Whether more than so many samples lie between two places.
    fn is_more_than(&self, most: usize, from: Place, to: Place) -> bool {
        let (mut count, mut number) = (0, from.chunk);
        while let Some(chunk) = self.store.chunk(number).filter(|_| number < to.chunk) {
            count += chunk.len();
            if count > most + from.index {
                return true;
            }
            number += 1;
        }
        count + to.index > most + from.index
    }

    /// Copies the samples of the span, both ends included, to `out`; a NaN stands before each that does not join the one before it.
    /// `false`, and an empty `out`, where some are thinned out.
    pub fn copy(&self, span: Span, out: &mut Vec<[f64; 2]>) -> bool {
        out.clear();
        let (mut place, to) = self.places(span);
        while let Some(chunk) = self.store.chunk(place.chunk).filter(|_| place < to) {
            let end = if place.chunk == to.chunk { to.index } else { chunk.len() };
            if chunk.is_thin() && place.index < end {
                out.clear();
                return false;
            }
            if chunk.broken && place.index == 0 && end > 0 {
                out.push([chunk.time(0), f64::NAN]);
            }
            out.extend((place.index..end).map(|k| [chunk.time(k), f64::from(chunk.value(k))]));
            place = Place { chunk: place.chunk + 1, index: 0 };
        }
        true
    }

    /// The time (s) of the sample that is `count` behind the first one not before `from_s`; `None` where there are not so many.
    #[must_use]
    pub fn time_of(&self, from_s: f64, count: usize) -> Option<f64> {
        let mut place = self.store.place(from_s, 0);
        let mut left = count;
        while let Some(chunk) = self.store.chunk(place.chunk) {
            let here = chunk.len().saturating_sub(place.index);
            if left < here {
                return Some(chunk.time(place.index + left));
            }
            left -= here;
            place = Place { chunk: place.chunk + 1, index: 0 };
        }
        None
    }

    /// The last sample at or before `t_s`; the mean of 32 where samples are thinned out. `None` before the first one, beyond the last, and
    /// in gaps.
    #[must_use]
    pub fn at(&self, t_s: f64) -> Option<f32> {
        let (from_s, to_s) = self.store.span()?;
        if !(from_s..=to_s).contains(&t_s) {
            return None;
        }
        let behind = self.store.place(t_s.next_up(), 0);
        let place = self.before(behind);
        let chunk = self.store.chunk(place.chunk)?;
        let ends = place.index + 1 == chunk.len();
        let in_gap = ends && self.store.chunk(place.chunk + 1).is_some_and(|next| next.broken);
        let age_s = t_s - chunk.time(place.index);
        let most_s =
            if in_gap { self.patience_s.min(1.5 * chunk.step_s()) } else { self.patience_s };
        (age_s <= most_s).then(|| chunk.value(place.index))
    }

    /// Figures of the samples in the span, both ends included; `None` where there is no finite one.
    #[must_use]
    pub fn stats(&self, span: Span) -> Option<Stats> {
        let (from, to) = self.places(span);
        let mut sum = Sum::default();
        self.store.fold(from, to, &mut sum);
        let Light { min, max, count, broken, .. } = sum.light;
        let (mean, rms) = (sum.light.mean(), sum.rms());
        (count > 0).then_some(Stats { min, max, mean, rms, count, broken })
    }

    /// The least and the greatest value that an axis should show in the span: extremes of single readings that no gripper sends (1e30
    /// beside micrometres) are left out. `None` where there is nothing to show.
    #[must_use]
    pub fn robust_range(&self, span: Span) -> Option<(f32, f32)> {
        let mut parts = Vec::new();
        self.envelope(span, 256, &mut parts);
        super::range::robust(&parts)
    }

    /// Places of the first sample in the span and of the first behind it.
    pub(super) fn places(&self, span: Span) -> (Place, Place) {
        let from = self.store.place(span.from_s, 0);
        (from, self.store.place(span.to_s.next_up(), from.chunk))
    }

    /// The place of the sample before; the same where there is none.
    pub(super) fn before(&self, place: Place) -> Place {
        if place.index > 0 {
            return Place { index: place.index - 1, ..place };
        }
        let Some(chunk) = place.chunk.checked_sub(1).filter(|n| *n >= self.store.first()) else {
            return place;
        };
        let len = self.store.chunk(chunk).map_or(0, super::chunk::Chunk::len);
        Place { chunk, index: len.saturating_sub(1) }
    }

    /// Samples of the finest part that is kept of thinned-out stretches.
    #[must_use]
    pub const fn finest() -> usize {
        NODE
    }
}
