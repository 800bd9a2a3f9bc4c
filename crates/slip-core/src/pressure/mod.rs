//! Slip detector of a taxel array: slip, reported by a change of the pressure pattern.
//!
//! With p the frame and p' = p - mean(p):
//!
//! ```text
//! r = p' - (p'.u / u.u) u          E = 1/n sum min((r_i / sigma)^2, 36)          slip when E > threshold
//! u <- u + a (p'/|p'| - u),        a = 1 - exp(-dt / follow)
//! ```
//!
//! u is the shape of the pattern. Removing the mean and the projection on u removes whatever all taxels share: an offset
//! (temperature) and a factor (grip force, vibration of hand or arm), so only a change of the *distribution* is left, that is
//! |p'| sin of the angle between p' and u. u follows slowly, so that creep of the pads is not called slip. A
//! single broken taxel is limited to 36/n. sigma is learned at rest or given. A second, fast u shows whether the pattern
//! still changes: the slip ends when it no longer does, and the pattern found then becomes u.
//!
//! A slow slip hardly leaves the shape that follows it. Where the range at rest is known, a second statistic (`range`) takes
//! its way instead of its place: the mean over taxels of the range of r in the last seconds, over that at rest.
//!
//! Frames may come more slowly than samples; a frame that repeats the one before bit by bit is nothing new.

mod frames;

pub use frames::{PatternRest, Standing};

use crate::{
    detector::SlipState,
    error::ConfigError,
    health::SensorHealth,
    sample::{ANY, Resolution},
    settings::settings,
    units::Micros,
};
use frames::{Range, Shape, Spread, Widest};

/// Most taxels of an array: 256 with the feature `wide-arrays`, which recordings have, else what one channel of the link can
/// carry.
pub const MAX_TAXELS: usize = if cfg!(feature = "wide-arrays") { 256 } else { 64 };

settings! {
    /// Thresholds and times of the pressure-distribution method.
    pub struct PressureConfig as c in "pressure" {
        threshold: f32 = 6.0, 1.5..=frames::CLIP => "Energy of the change over the noise that is a slip.";
        gross: f32 = 18.0, c.threshold..=frames::CLIP => "The same at which the slip is gross.";
        follow_ms: f32 = 1000.0, 10.0..=1e6 => "Time constant with which the shape follows creep (ms).";
        release_ms: f32 = 100.0, 1.0..=10_000.0 => "How long the pattern must stand for the slip to end (ms).";
        learn_frames: u16 = 20, 4.0..=10_000.0 => "Frames of rest from which the noise is learned.";
        min_rms: f32 = 0.0, 0.0..=1e12 =>
            "Smallest noise that is believed (unit of the taxels, rms): their resolution. 0: what their readings"
            "show, the smallest step between two of them over sqrt(12).";
        known_rms: Option<f32> = None, 1e-12..=1e12 => "Noise that is known already (unit of the taxels, rms).";
        known_range: Option<f32> = None, 1e-12..=1e12 =>
            "Mean range of a taxel beside the shape (unit of the taxels) that an object held still does not exceed,"
            "where it is known: `gripctl score` prints that of the labelled rest, `gripctl calibrate` writes it. A"
            "larger one is a slip. Else it is 1.5 times the largest of the first 10 s that an object is held"
            "without a slip, in stretches of 2 s and more.";
        frozen_ms: f32 = 1000.0, 1.0..=1e6 =>
            "The array counts as frozen when not one bit changed for this long (ms), if it had been noisy before.";
    }
}

/// Time constant of the fast shape (ms).
const FAST_MS: f32 = 50.0;
/// Rest from which the range is learned, and times the largest that was seen which is a slip then: the largest range of
/// 15 grasps of one gripper is 1.2 times their median, of 28 touches of a hand on 7 objects 1.5 times.
const RANGED: Micros = Micros(10_000_000);
const RANGE_MARGIN: f32 = 1.5;
/// A pattern without a new frame for this long is gone, and one that repeats its frame for so long stands.
pub(crate) const PATTERN_GONE: Micros = Micros(200_000);
/// Fraction of the threshold below which the change against the fast shape is none.
const STANDING: f32 = 0.5;

/// The pressure-distribution method for arrays of at most `N` taxels.
#[derive(Clone, Copy, Debug)]
pub struct PressurePattern<const N: usize> {
    config: PressureConfig,
    release: Micros,
    frozen: Micros,
    last: [f32; N],
    len: usize,
    last_t: Option<Micros>,
    slow: Shape<N>,
    fast: Shape<N>,
    range: Range<N>,
    /// The range that an object held still does not exceed, once it is known, and what it is learned from.
    known_range: Option<f32>,
    widest: Widest,
    /// The mean range over the known one, as of the last frame.
    ranged: f32,
    spread: Spread,
    resolution: Resolution,
    /// Noise (rms), once it is known.
    rms: Option<f32>,
    changing_at: Micros,
    state: SlipState,
    statistic: f32,
    frozen_now: bool,
    failed: bool,
}

impl<const N: usize> PressurePattern<N> {
    /// A method that has seen nothing yet.
    ///
    /// # Errors
    /// Where a value of the configuration is outside its range.
    pub fn new(config: PressureConfig) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self {
            config,
            release: Micros::from_ms(config.release_ms),
            frozen: Micros::from_ms(config.frozen_ms),
            last: [0.0; N],
            len: 0,
            last_t: None,
            slow: Shape::new(),
            fast: Shape::new(),
            range: Range::new(),
            known_range: config.known_range,
            widest: Widest::default(),
            ranged: 0.0,
            spread: Spread::default(),
            resolution: Resolution::default(),
            rms: config.known_rms,
            changing_at: Micros(0),
            state: SlipState::Quiet,
            statistic: 0.0,
            frozen_now: false,
            failed: false,
        })
    }

    /// Starts afresh with the next frame; the noise stays.
    pub fn prime(&mut self) {
        self.last_t = None;
        self.slow = Shape::new();
        self.fast = Shape::new();
        self.range = Range::new();
        self.widest.start();
        self.stand();
        self.frozen_now = false;
        self.failed = false;
        if self.rms.is_none() {
            self.spread = Spread::default();
            // Frames that came while nothing was held do not count, looked at or not.
            self.resolution = Resolution::default();
        }
    }

    /// The grip force changes, so that the pattern shows nothing: where no slip goes on, it starts afresh when the force stands.
    pub fn wait(&mut self) {
        if self.state == SlipState::Quiet {
            self.prime();
        }
    }

    /// State of the array.
    #[must_use]
    #[inline]
    pub fn health(&self) -> SensorHealth {
        if self.failed {
            SensorHealth::Failed
        } else if self.frozen_now {
            SensorHealth::Frozen
        } else {
            SensorHealth::Good
        }
    }

    /// Whether the object slips, as of the last frame.
    #[must_use]
    #[inline]
    pub fn state(&self) -> SlipState {
        self.state
    }

    /// Energy of the change over the threshold: above 1 is a slip. 0 while the noise is unknown.
    #[must_use]
    #[inline]
    pub fn statistic(&self) -> f32 {
        self.statistic
    }

    /// Mean range of the taxels (their unit) that an object held still does not exceed, once it is known.
    #[must_use]
    pub fn known_range(&self) -> Option<f32> {
        self.known_range
    }

    /// Noise of the taxels (rms), once it is known.
    #[must_use]
    pub fn rms(&self) -> Option<f32> {
        self.rms
    }

    /// Whether there was a frame since the object was taken.
    #[must_use]
    #[inline]
    pub fn has_begun(&self) -> bool {
        self.last_t.is_some()
    }

    /// Log-likelihood ratio of a rise to six times the noise that a change at the threshold has.
    #[must_use]
    pub fn log_at_limit(&self) -> f32 {
        let taxels = self.len as f32;
        0.5 * taxels * self.config.threshold * (1.0 - 1.0 / 6.0)
    }

    /// Whether there was a new frame within `within` before `t`.
    #[must_use]
    pub fn is_live(&self, t: Micros, within: Micros) -> bool {
        self.last_t.is_some_and(|last| t.since(last) < within)
    }

    /// Whether the pattern still changed within `within` before `t`.
    #[must_use]
    pub fn changing(&self, t: Micros, within: Micros) -> bool {
        self.state != SlipState::Quiet && t.since(self.changing_at) < within
    }

    /// Takes the next frame, at most `N` taxels; more are left out. `learning` states whether the object is at rest in the grasp, so
    /// that the noise may be learned where it is not known: no slip goes on, whose answer changes the force.
    pub fn step(&mut self, t: Micros, frame: &[f32], learning: bool) {
        let frame = frame.get(..N).unwrap_or(frame);
        if frame.is_empty() || self.repeated(t, frame) {
            return;
        }
        let Some(frame) = self.completed(frame) else { return };
        #[expect(clippy::cast_possible_truncation, reason = "a step of time")]
        let dt_ms = self.last_t.map_or(0.0, |last| t.since(last).as_seconds() * 1e3) as f32;
        self.last_t = Some(t);
        let seen = self.slow.step(&frame, self.len, dt_ms / self.config.follow_ms);
        let seen_fast = self.fast.step(&frame, self.len, dt_ms / FAST_MS);
        let (Some(change), Some(now)) = (seen, seen_fast) else { return };
        let Some(rms) = self.rms else {
            if learning {
                self.learn(change.mean_square());
            }
            return;
        };
        let per_variance = 1.0 / (rms * rms);
        let widens = self.widen(t, change.residual(), dt_ms, learning);
        self.decide(t, change.energy(per_variance), now.energy(per_variance), widens);
    }

    /// Follows the range; whether it is beyond that of an object held still and does not shrink.
    fn widen(&mut self, t: Micros, residual: &[f32], dt_ms: f32, learning: bool) -> bool {
        self.range.step(residual, dt_ms);
        let Some(known) = self.known_range else {
            if !learning || self.state != SlipState::Quiet {
                self.widest.start();
                return false;
            }
            self.widest.push(t, self.range.mean(self.len, f32::INFINITY));
            if self.widest.rest() >= RANGED {
                self.known_range = self.widest.largest().map(|range| RANGE_MARGIN * range);
            }
            return false;
        };
        let before = self.ranged;
        self.ranged = self.range.mean(self.len, frames::RANGE_CLIP * known) / known;
        self.ranged > before.max(1.0)
    }

    /// Whether the frame shows nothing new; follows whether the array is alive.
    fn repeated(&mut self, t: Micros, frame: &[f32]) -> bool {
        let Some(last_t) = self.last_t else { return false };
        let same = frame.len() == self.len
            && frame.iter().zip(&self.last).all(|(a, b)| a.to_bits() == b.to_bits());
        let noisy = self.rms.is_some_and(|rms| rms > self.least_rms());
        let standing = t.since(last_t);
        self.frozen_now = same && noisy && standing > self.frozen;
        if same && standing > self.release.max(PATTERN_GONE) || self.frozen_now {
            self.stand();
        }
        same
    }

    /// The frame with taxels that send no number held at their last value; `None` where too many do.
    fn completed(&mut self, frame: &[f32]) -> Option<[f32; N]> {
        let (first, learning) = (self.last_t.is_none(), self.rms.is_none());
        let resolution = &mut self.resolution;
        let mut out = [0.0; N];
        let mut bad = 0;
        for ((out, &value), last) in out.iter_mut().zip(frame).zip(&mut self.last) {
            // NaN fails the comparison.
            if value.abs() <= ANY {
                if learning && !first {
                    resolution.compare(value, *last);
                }
                *last = value;
            } else {
                bad += 1;
            }
            *out = *last;
        }
        self.failed = 4 * bad > frame.len() || (first && bad > 0);
        if self.failed || (!first && frame.len() != self.len) {
            self.failed = true;
            self.stand();
            return None;
        }
        self.len = frame.len();
        Some(out)
    }

    #[cold]
    fn learn(&mut self, mean_square: f32) {
        self.spread.push(mean_square);
        self.rms = self
            .spread
            .mean(self.config.learn_frames)
            .map(|variance| libm::sqrtf(variance).max(self.least_rms()))
            .filter(|rms| *rms > 0.0);
    }

    /// Smallest noise that is believed (rms).
    fn least_rms(&self) -> f32 {
        if self.config.min_rms > 0.0 { self.config.min_rms } else { self.resolution.rms() }
    }

    fn decide(&mut self, t: Micros, energy: f32, now: f32, widens: bool) {
        self.statistic = (energy / self.config.threshold).max(self.ranged);
        let changes = widens || now > STANDING * self.config.threshold;
        if changes || self.state == SlipState::Quiet {
            self.changing_at = t;
        }
        if self.state != SlipState::Quiet && t.since(self.changing_at) > self.release {
            // What the pattern has become is the new rest; the end of the slip is reported.
            self.slow = self.fast;
            self.range = Range::new();
            self.stand();
        } else if energy > self.config.gross {
            self.state = SlipState::Gross;
        } else if self.statistic > 1.0 && self.state == SlipState::Quiet {
            self.state = SlipState::Incipient;
        }
    }

    fn stand(&mut self) {
        self.state = SlipState::Quiet;
        self.statistic = 0.0;
        self.ranged = 0.0;
    }
}

#[cfg(test)]
mod tests;
