//! Stretches of rest in, the noise of the taxels out.
//!
//! For recordings whose rest is known beforehand; a running gripper learns the noise in the first grasp.

use super::{
    range::{Range, Widest},
    shape::Shape,
};
use crate::units::Micros;

/// Pools the noise of several stretches of at most `N` taxels.
#[derive(Clone, Copy, Debug)]
pub struct PatternRest<const N: usize> {
    follow_ms: f32,
    shape: Shape<N>,
    range: Range<N>,
    widest: Widest,
    last_t: Option<Micros>,
    sum: f64,
    /// Largest mean square of the residuals over all taxels.
    largest: f32,
    frames: u64,
}

impl<const N: usize> PatternRest<N> {
    /// A meter for a method that follows creep with `follow_ms`.
    #[must_use]
    pub fn new(follow_ms: f32) -> Self {
        Self {
            follow_ms,
            shape: Shape::new(),
            range: Range::new(),
            widest: Widest::default(),
            last_t: None,
            sum: 0.0,
            largest: 0.0,
            frames: 0,
        }
    }

    /// Begins another stretch of rest.
    pub fn start(&mut self) {
        self.shape = Shape::new();
        self.range = Range::new();
        self.widest.start();
        self.last_t = None;
    }

    /// Takes the next frame; one with anything but numbers is left out.
    pub fn push(&mut self, t: Micros, frame: &[f32]) {
        if frame.is_empty() || frame.iter().any(|value| !value.is_finite()) {
            return;
        }
        let mut values = [0.0; N];
        for (value, taxel) in values.iter_mut().zip(frame) {
            *value = *taxel;
        }
        #[expect(clippy::cast_possible_truncation, reason = "a step of time")]
        let dt_ms = self.last_t.map_or(0.0, |last| t.since(last).as_seconds() * 1e3) as f32;
        self.last_t = Some(t);
        let seen = self.shape.step(&values, frame.len().min(N), dt_ms / self.follow_ms);
        if let Some(departure) = seen {
            self.sum += f64::from(departure.mean_square());
            self.largest = self.largest.max(departure.over_all());
            self.range.step(departure.residual(), dt_ms);
            let range = self.range.mean(frame.len().min(N), f32::INFINITY);
            self.widest.push(t, range);
            self.frames += 1;
        }
    }

    /// Frames that were used.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Noise of a taxel (rms) with which nothing of that rest is a slip at `threshold`: a hand that creeps shows more than noise.
    /// `None` before the second frame.
    #[must_use]
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        reason = "a mean in f32"
    )]
    pub fn rms(&self, threshold: f32) -> Option<f32> {
        let variance = (self.sum / self.frames as f64) as f32;
        (self.frames > 0).then(|| libm::sqrtf(variance.max(self.largest / threshold)))
    }

    /// Largest mean range of a taxel (unit of the taxels), with which nothing of that rest is a slip. `None` where no stretch
    /// lasted for half the time constant of the range, or nothing changed.
    #[must_use]
    pub fn range(&self) -> Option<f32> {
        self.widest.largest()
    }
}
