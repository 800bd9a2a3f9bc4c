//! A statistic and the level of the vibration band in, the slip state out.

use super::{config::DetectorConfig, lanes::samples, slip::SlipState};

/// Below this fraction of its recent peak the statistic is the fading memory of a slip that has stopped.
const FRESH: f32 = 0.5;

/// From the statistic to the slip state: thresholds, hysteresis, release.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decision {
    gross: f32,
    release: f32,
    release_len: u32,
    quiet_run: u32,
    pub(super) state: SlipState,
    /// The lower one of the last two blocks: the front of a tap may reach the stylus a block before the reference.
    pub(super) statistic: f32,
    before: f32,
    /// The highest statistic of the last milliseconds, decaying half as fast as the energy does at rest.
    recent_peak: f32,
    peak_decay: f32,
}

impl Decision {
    pub(super) fn new(config: &DetectorConfig, block_s: f32, blocks_hz: f32) -> Self {
        Self {
            gross: config.gross,
            release: config.release,
            release_len: samples(config.release_ms, blocks_hz),
            quiet_run: 0,
            state: SlipState::Quiet,
            statistic: 0.0,
            before: 0.0,
            recent_peak: 0.0,
            peak_decay: libm::expf(-block_s / (2e-3 * config.envelope_ms)),
        }
    }

    pub(super) fn reset(&mut self) {
        self.quiet_run = 0;
        self.state = SlipState::Quiet;
        self.statistic = 0.0;
        self.before = 0.0;
        self.recent_peak = 0.0;
    }

    /// Takes the statistic of a block and the energy over floor of the vibration band.
    #[inline]
    pub(super) fn step(&mut self, now: f32, vibration: f32) {
        let statistic = now.min(self.before);
        self.before = now;
        self.statistic = statistic;
        self.recent_peak = statistic.max(self.recent_peak * self.peak_decay);
        if statistic > 1.0 {
            self.quiet_run = 0;
            if vibration > self.gross {
                self.state = SlipState::Gross;
            } else if self.state == SlipState::Quiet {
                self.state = SlipState::Incipient;
            }
        } else if statistic >= self.release {
            self.quiet_run = 0;
        } else {
            self.quiet_run = self.quiet_run.saturating_add(1);
            if self.quiet_run >= self.release_len {
                self.state = SlipState::Quiet;
            }
        }
    }

    /// The evidence of the blocks shows a slip, whatever the statistic.
    #[cold]
    pub(super) fn certify(&mut self) {
        self.quiet_run = 0;
        self.state = self.state.max(SlipState::Incipient);
    }

    /// Whether the signal is above its threshold now, and not only the mean of the last milliseconds.
    #[inline]
    pub(super) fn is_fresh(&self) -> bool {
        self.statistic > 1.0 && self.statistic >= FRESH * self.recent_peak
    }
}
