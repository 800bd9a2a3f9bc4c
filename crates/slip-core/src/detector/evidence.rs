//! The evidence that noise as in the calibration does not explain the scores of blocks, and the slip state from the statistic.
//!
//! An e-detector (Shin, Ramdas, Rinaldo, arXiv 2203.03532, NEJSDS 2024) in its Shiryaev-Roberts form. The score s of a
//! band in a block of T_b seconds is its mean energy over its floor. The calibration knows limits t_1 < .. < t_J that
//! noise passes with a chance of at most p_1 > .. > p_J ([`ScoreLaw`]). In every block
//!
//! ```text
//! L = (1 - g) + g/J sum over j of 1{s > t_j} / p_j        M <- L (M + T_b)        certified when the mean of M over the bands >= A
//! ```
//!
//! with g = 1/2. Without slip E[L] <= 1 given all that was before, so E[M] grows by at most T_b with each block and a
//! stop at M >= A comes after A seconds on average or later (optional stopping): the mean time between false alarms is
//! at least A whatever the law of the scores. The mean over bands keeps that without their being independent. M is a
//! time in seconds, so bands may have blocks of different length.
//!
//! What it needs: that the chances hold given the past, for which the calibration looks at how scores follow each
//! other, and that noise and motion are as they were then. Each stretch of rest and of motion has a law of its own.
//! Tests: `agrees_with_the_formula`, `the_interval_is_kept`.

use super::{
    config::{BANDS, DetectorConfig},
    lanes::samples,
    slip::SlipState,
    sum::{Block, GONE},
};
use crate::error::ConfigError;

/// Limits of a band.
pub const LIMITS: usize = 8;
/// Length of the shortest block (s).
const BASE_S: f32 = 5e-3;
/// Share of the bet.
const BET: f32 = 0.5;
/// Evidence over the interval of a certified slip: enough for the mean over the methods.
const CERTIFIED: f32 = 2.0;
/// The largest evidence (s): a product of two stays finite.
const MOST_S: f32 = 1e18;

/// How the scores of the bands are distributed without slip.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct ScoreLaw {
    /// Base blocks (5 ms, or one decision where that is longer) in a block of each band; 0 for a band that takes no part.
    pub blocks: [u32; BANDS],
    /// Limits of the score of each band, rising.
    pub limits: [[f32; LIMITS]; BANDS],
    /// Upper bounds of the chance that a block passes each limit, above 0 and at most 1.
    pub chances: [[f32; LIMITS]; BANDS],
}

/// A false-alarm interval and what it stands on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Certificate {
    /// The mean time between certified false alarms is at least this (s), 1 to 1e9.
    pub interval_s: f32,
    /// Scores at rest; without it nothing is certified there.
    pub rest: Option<ScoreLaw>,
    /// Scores while the robot moves.
    pub motion: Option<ScoreLaw>,
}

impl Certificate {
    /// # Errors
    /// The first value outside its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        ConfigError::within("certificate.interval_s", self.interval_s, 1.0, 1e9)?;
        for law in [self.rest, self.motion].into_iter().flatten() {
            for b in (0..BANDS).filter(|b| law.blocks[*b] > 0) {
                ConfigError::within("certificate.blocks", law.blocks[b] as f32, 1.0, 1e4)?;
                for (limit, chance) in law.limits[b].into_iter().zip(law.chances[b]) {
                    ConfigError::within("certificate.limits", limit, 0.0, f32::MAX)?;
                    ConfigError::within("certificate.chances", chance, 1e-12, 1.0)?;
                }
            }
        }
        Ok(())
    }
}

/// The factors L of a law.
#[derive(Clone, Copy, Debug)]
struct Bets {
    blocks: [u32; BANDS],
    limits: [[f32; LIMITS]; BANDS],
    /// By the number of limits that were passed.
    factors: [[f32; LIMITS + 1]; BANDS],
}

impl Bets {
    fn new(law: &ScoreLaw) -> Self {
        let share = BET / LIMITS as f32;
        let factors = law.chances.map(|chances| {
            let mut factors = [1.0 - BET; LIMITS + 1];
            for (j, chance) in chances.into_iter().enumerate() {
                factors[j + 1] = factors[j] + share / chance;
            }
            factors
        });
        Self { blocks: law.blocks, limits: law.limits, factors }
    }
}

/// Scores of base blocks, one after the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scores {
    /// Number of the base block.
    pub number: u64,
    /// Mean energy of each band over its floor.
    pub scores: [f32; BANDS],
    /// Whether the robot moved.
    pub moving: bool,
}

/// The evidence of all bands.
#[derive(Clone, Copy, Debug)]
pub struct Evidence {
    interval_s: f32,
    rest: Option<Bets>,
    motion: Option<Bets>,
    /// Reciprocal of the number of bands.
    share: f32,
    base_len: u32,
    /// Length of a base block (s).
    base_s: f32,
    /// Floors in force over those that the certificate is for.
    lowered: [f32; BANDS],
    /// Sums of the base block.
    filled: u32,
    energy: [f32; BANDS],
    floor: [f32; BANDS],
    /// Sums of scores of the blocks, with their number.
    sums: [(f32, u32); BANDS],
    evidence_s: [f32; BANDS],
    last: Option<Scores>,
    certified: bool,
}

impl Evidence {
    /// No evidence yet; decisions come every `block_s` (s).
    #[must_use]
    pub fn new(certificate: &Certificate, block_s: f32) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "1 to 100; the cast saturates"
        )]
        let base_len = (libm::ceilf(0.999 * BASE_S / block_s) as u32).max(1);
        let [rest, motion] =
            [&certificate.rest, &certificate.motion].map(|law| law.as_ref().map(Bets::new));
        let bands = |bets: &Option<Bets>| {
            bets.as_ref().map_or(0, |bets| bets.blocks.iter().filter(|n| **n > 0).count())
        };
        let (count, base) = (bands(&rest).max(bands(&motion)).max(1) as f32, base_len as f32);
        Self {
            interval_s: certificate.interval_s,
            rest,
            motion,
            share: 1.0 / count,
            base_len,
            base_s: base * block_s,
            lowered: [1.0; BANDS],
            filled: 0,
            energy: [0.0; BANDS],
            floor: [0.0; BANDS],
            sums: [(0.0, 0); BANDS],
            evidence_s: [0.0; BANDS],
            last: None,
            certified: false,
        }
    }

    /// The floors in force are `factors` times those of the certificate, at most 1.
    pub(super) fn rescale(&mut self, factors: [f32; BANDS]) {
        self.lowered = factors;
        self.restart();
    }

    /// The interval that is certified (s).
    pub(super) fn interval_s(&self) -> f32 {
        self.interval_s
    }

    /// Whether the last decision certified a slip.
    #[inline]
    pub(super) fn is_certified(&self) -> bool {
        self.certified
    }

    /// Length of a base block (s).
    pub(super) fn base_s(&self) -> f32 {
        self.base_s
    }

    /// The scores of the last base block.
    pub(super) fn scores(&self) -> Option<&Scores> {
        self.last.as_ref()
    }

    /// Begins another stretch of rest or of motion without evidence: how its first blocks follow the last ones of
    /// another is in no calibration.
    pub fn restart(&mut self) {
        self.filled = 0;
        self.energy = [0.0; BANDS];
        self.floor = [0.0; BANDS];
        self.sums = [(0.0, 0); BANDS];
        self.evidence_s = [0.0; BANDS];
        self.certified = false;
    }

    /// Takes what a decision is made from; whether that certifies a slip.
    #[inline]
    pub(super) fn step(&mut self, block: &Block) -> bool {
        for b in 0..BANDS {
            self.energy[b] += block.energy[b];
            self.floor[b] += block.floor[b];
        }
        self.filled += 1;
        self.certified = self.filled >= self.base_len && self.end_base_block(block.moving);
        self.certified
    }

    #[inline(never)]
    fn end_base_block(&mut self, moving: bool) -> bool {
        let filled = self.filled as f32;
        // In units of the floors of the certificate: the quiet part of the floor is 1 there.
        let scores = core::array::from_fn(|b| {
            let lowered = self.lowered[b];
            self.energy[b] * lowered / (filled + (self.floor[b] - filled) * lowered)
        });
        let number = self.last.map_or(0, |last| last.number + 1);
        self.last = Some(Scores { number, scores, moving });
        self.filled = 0;
        self.energy = [0.0; BANDS];
        self.floor = [0.0; BANDS];
        self.bet(&scores, moving)
    }

    /// Takes the scores of the next base block; whether they certify a slip.
    pub fn bet(&mut self, scores: &[f32; BANDS], moving: bool) -> bool {
        let Some(bets) = (if moving { &self.motion } else { &self.rest }) else { return false };
        let mut mean_s = 0.0;
        for (b, score) in scores.iter().enumerate() {
            let (sum, count) = &mut self.sums[b];
            *sum += score;
            *count = count.saturating_add(1);
            if *count == bets.blocks[b] {
                let count = *count as f32;
                let score = *sum / count;
                let passed = bets.limits[b].iter().filter(|limit| score > **limit).count();
                let evidence_s = self.evidence_s[b] + count * self.base_s;
                self.evidence_s[b] =
                    (bets.factors[b].get(passed).copied().unwrap_or(0.0) * evidence_s).min(MOST_S);
                self.sums[b] = (0.0, 0);
            }
            mean_s += self.share * self.evidence_s[b];
        }
        let certified = mean_s >= self.interval_s;
        if certified {
            self.evidence_s = [0.0; BANDS];
        }
        certified
    }
}

// From the evidence to the slip state.

/// The slip state: hysteresis and release.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decision {
    gross: f32,
    release_len: u32,
    quiet_run: u32,
    pub(super) state: SlipState,
    /// Evidence over the interval: 1 and above is a slip.
    pub(super) statistic: f32,
}

impl Decision {
    pub(super) fn new(config: &DetectorConfig, blocks_hz: f32) -> Self {
        Self {
            gross: config.gross,
            release_len: samples(config.release_ms, blocks_hz),
            quiet_run: 0,
            state: SlipState::Quiet,
            statistic: 0.0,
        }
    }

    pub(super) fn reset(&mut self) {
        (self.quiet_run, self.state, self.statistic) = (0, SlipState::Quiet, 0.0);
    }

    /// Takes the evidence of a block over the interval, and the energy over floor of the bands that slide.
    #[inline]
    pub(super) fn step(&mut self, statistic: f32, sliding: f32) {
        self.statistic = statistic;
        if statistic >= 1.0 {
            self.quiet_run = 0;
            if sliding > self.gross {
                self.state = SlipState::Gross;
            } else if self.state == SlipState::Quiet {
                self.state = SlipState::Incipient;
            }
        } else if statistic >= GONE {
            self.quiet_run = 0;
        } else {
            self.quiet_run = self.quiet_run.saturating_add(1);
            if self.quiet_run >= self.release_len {
                self.state = SlipState::Quiet;
            }
        }
    }

    /// The evidence of the certificate shows a slip, whatever the sum.
    #[cold]
    pub(super) fn certify(&mut self) {
        self.quiet_run = 0;
        self.statistic = self.statistic.max(CERTIFIED);
        self.state = self.state.max(SlipState::Incipient);
    }
}

#[cfg(test)]
mod tests;
