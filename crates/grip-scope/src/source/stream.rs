//! Samples, and what is reported beside them, on their way to the model: blocks of rows with what the observer derives from them first, as
//! states and events are placed by the rows around them.

use super::reported::Blocks;
use crate::derive::Observer;
use crate::feed::{DerivedBlock, EventMark, Feed};
use core::fmt::Display;
use grip_link::device::Truth;
use grip_session::HostEstimator;
use slip_core::{PipelineConfig, PipelineState, Sample, Step, units::Micros};

/// Rows, or other items, of a block.
const BLOCK: usize = 2048;
/// Device time of a block (us).
const BLOCK_US: u64 = 500_000;

/// Items on their way to the model.
#[derive(Default)]
pub(super) struct Stream {
    blocks: Blocks,
    observer: Option<Observer>,
    done: Vec<Feed>,
    /// States and events of the rows that wait.
    updates: Vec<Feed>,
    /// Rows that wait, on both sides of gaps.
    waiting: usize,
    /// Times of the first and of the last of them (us).
    span_us: Option<(u64, u64)>,
    next_index: Option<u32>,
    /// The state that was reported last.
    reported: Option<PipelineState>,
}

impl Stream {
    /// Runs a pipeline with these settings beside the samples from now on. Where none can run only spectra are made, and a line says why.
    pub(super) fn observe(
        &mut self,
        config: PipelineConfig,
        model: Result<HostEstimator, impl Display>,
    ) -> Option<Feed> {
        let model = model.map_err(|error| error.to_string());
        let observer =
            model.and_then(|model| Observer::new(config, model).map_err(|e| e.to_string()));
        match observer {
            Ok(observer) => {
                self.begin(observer);
                None
            }
            Err(error) => Some(self.spectra_only(config.sample_rate.0, &error)),
        }
    }

    /// Makes spectra and nothing else from now on; a line that says why.
    pub(super) fn spectra_only(&mut self, rate_hz: f32, why: &str) -> Feed {
        self.begin(Observer::spectra_only(rate_hz));
        let text = format!("at {rate_hz:.0} Hz only spectra are derived from the samples: {why}");
        Feed::Notice(text)
    }

    fn begin(&mut self, mut observer: Observer) {
        self.flush();
        observer.interrupt();
        self.observer = Some(observer);
    }

    /// Takes a sample and the frame of the array that came with it: what the observer states. What waits goes before it where that is enough,
    /// or where the sample is of another start or far behind: there nothing of before is placed any more.
    pub(super) fn push(&mut self, sample: &Sample, taxels: &[f32]) -> Option<Step> {
        let t_us = sample.t.0;
        let afar = |(first, last)| t_us <= last || t_us - first >= BLOCK_US;
        if self.span_us.is_some_and(afar) || self.waiting.max(self.updates.len()) >= BLOCK {
            self.cut();
        }
        self.span_us = Some((self.span_us.map_or(t_us, |(first, _)| first), t_us));
        self.waiting += 1;
        self.blocks.push(sample, taxels);
        self.observer.as_mut().and_then(|observer| observer.push(sample, taxels))
    }

    /// Takes the number of the next row, which grows by `step` from row to row: where others are missing before it the next row does not join.
    pub(super) fn number(&mut self, index: u32, step: u32) {
        if let Some(expected) = self.next_index.filter(|next| *next != index) {
            // A number that went back belongs to another start of the gripper.
            let ahead = index.wrapping_sub(expected);
            self.broken(if ahead < 1 << 31 { ahead / step.max(1) } else { 0 });
        }
        self.next_index = Some(index.wrapping_add(step));
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

    /// Takes what goes behind the rows so far.
    pub(super) fn update(&mut self, feed: Feed) {
        self.updates.push(feed);
    }

    /// Takes an event.
    pub(super) fn mark(&mut self, mark: EventMark) {
        self.update(Feed::Event(mark));
    }

    /// Takes a state, with what a simulator knows of it, where scene, controller or sensors are others than in the one before, or that is older
    /// than `every_us`.
    pub(super) fn state(&mut self, state: PipelineState, truth: Option<Truth>, every_us: u64) {
        let new = self.reported.is_none_or(|before| {
            let seen = |state: &PipelineState| (state.scene, state.grip, state.sensors);
            seen(&before) != seen(&state) || state.t >= before.t.plus(Micros(every_us))
        });
        if new {
            self.reported = Some(state);
            self.updates.extend(truth.map(Feed::Truth));
            self.update(Feed::State(state));
        }
    }

    /// Rows are numbered anew.
    pub(super) const fn restart(&mut self) {
        self.next_index = None;
    }

    /// Time of the last sample (us), while it waits.
    pub(super) fn last_us(&self) -> Option<u64> {
        self.span_us.map(|(_, last_us)| last_us)
    }

    fn flush(&mut self) {
        self.done.extend(self.blocks.take().map(Feed::Rows));
        let derived = self.observer.as_mut().map(Observer::take);
        let worth =
            |block: &DerivedBlock| block.values.len() + block.turns.len() + block.spectra.len() > 0;
        if let Some(block) = derived.filter(worth) {
            self.done.push(Feed::Derived(Box::new(block)));
        }
    }

    /// What waits is a block.
    fn cut(&mut self) {
        self.flush();
        self.done.append(&mut self.updates);
        (self.waiting, self.span_us) = (0, None);
    }

    /// The blocks that are whole, in order.
    pub(super) fn whole(&mut self) -> Vec<Feed> {
        core::mem::take(&mut self.done)
    }

    /// Everything so far, in order.
    pub(super) fn take(&mut self) -> Vec<Feed> {
        self.cut();
        self.whole()
    }
}
