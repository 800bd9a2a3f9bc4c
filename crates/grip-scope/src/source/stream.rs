//! Samples in; blocks of rows, and what the observer derives from them, out.

use super::reported::Blocks;
use crate::derive::Observer;
use crate::feed::{DerivedBlock, Feed, Level, NoticeLine};
use core::fmt::Display;
use grip_session::HostEstimator;
use slip_core::{PipelineConfig, Sample, Step};

/// Samples on their way to the model.
#[derive(Default)]
pub(super) struct Stream {
    blocks: Blocks,
    observer: Option<Observer>,
    done: Vec<Feed>,
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
        let rate_hz = config.sample_rate.0;
        match observer {
            Ok(observer) => {
                self.begin(observer);
                None
            }
            Err(error) => Some(self.spectra_only(rate_hz, &error)),
        }
    }

    /// Makes spectra and nothing else from now on; a line that says why.
    pub(super) fn spectra_only(&mut self, rate_hz: f32, why: &str) -> Feed {
        self.begin(Observer::spectra_only(rate_hz));
        let text = format!("at {rate_hz:.0} Hz only spectra are derived from the samples: {why}");
        Feed::Notice(NoticeLine { level: Level::Warning, text })
    }

    fn begin(&mut self, mut observer: Observer) {
        self.flush();
        observer.interrupt();
        self.observer = Some(observer);
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
