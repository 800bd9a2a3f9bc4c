//! What the tests show while the robot moves and nothing slips in; what motion leaves in each band over what the gate assumes, out.
//!
//! How strongly the stylus shows motion that the reference shows differs from robot to robot and from band to band. Where motion alone comes near
//! a threshold the gain of that band is raised, so that the same motion reaches [`NEAR`] of it. A stretch without an alarm counts when the next
//! one is over without an alarm too. An alarm counts as motion when it is short, weak and followed by no other within a second, since what slides
//! lasts longer; or when a dozen follow each other and all are weak, since what slides becomes fast. What was learned fades over minutes of motion.

use super::{
    config::{BANDS, FIRST_OCTAVE},
    lanes::samples,
    slip::SlipState,
};

/// Share of a threshold that motion without slip may reach.
const NEAR: f32 = 0.75;
const NEAR_SUM: f32 = 0.95;
/// Energy over floor from which a band has part in a sum that rises.
const PART: f32 = 3.0;
/// The largest factor on a gain.
const MOST: f32 = 4.0;
/// Length of a stretch (ms).
const STRETCH_MS: f32 = 150.0;
/// An alarm of at most this length (ms, without the time of its release) and this statistic is no slip.
const SHORT_MS: f32 = 60.0;
pub(super) const WEAK: f32 = 2.5;
/// So many weak alarms in a row are motion, however long they last: what slides becomes fast.
const MANY: u32 = 12;
/// After an alarm nothing is learned for this long (ms).
const PAUSE_MS: f32 = 1000.0;
/// Motion in which what was learned fades by e (s).
const FADES_S: f32 = 600.0;

/// Highest levels of a stretch: energy of each band over floor and threshold, and the sum over its threshold.
#[derive(Clone, Copy, Debug, Default)]
struct Highest {
    energy: [f32; BANDS],
    sum: f32,
    statistic: f32,
}

impl Highest {
    fn with(&self, other: &Self) -> Self {
        Self {
            energy: core::array::from_fn(|b| self.energy[b].max(other.energy[b])),
            sum: self.sum.max(other.sum),
            statistic: self.statistic.max(other.statistic),
        }
    }
}

/// The gains that were learned, and what they are learned from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coupling {
    factors: [f32; BANDS],
    thresholds: [f32; BANDS],
    fading: f32,
    stretch_len: u32,
    short_len: u32,
    pause_len: u32,
    pause: u32,
    /// Blocks of this stretch, or of the alarm.
    blocks: u32,
    alarmed: bool,
    now: Highest,
    before: Highest,
    /// Weak alarms in a row.
    weak: u32,
    /// A short and weak alarm, which no other has followed yet.
    alone: Option<Highest>,
}

impl Coupling {
    /// Nothing is learned yet. Alarms end `release_ms` after what they saw.
    pub(super) fn new(thresholds: [f32; BANDS], release_ms: f32, block_s: f32) -> Self {
        let blocks_hz = 1.0 / block_s;
        Self {
            factors: [1.0; BANDS],
            thresholds,
            fading: block_s / FADES_S,
            stretch_len: samples(STRETCH_MS, blocks_hz),
            short_len: samples(SHORT_MS + release_ms, blocks_hz),
            pause_len: samples(PAUSE_MS, blocks_hz),
            pause: 0,
            blocks: 0,
            alarmed: false,
            now: Highest::default(),
            before: Highest::default(),
            weak: 0,
            alone: None,
        }
    }

    /// Nothing is learned yet.
    pub(super) fn forget(&mut self) {
        self.factors = [1.0; BANDS];
        (self.weak, self.alone) = (0, None);
        self.start();
    }

    /// Factors on the gains of the bands, 1 and above.
    #[inline]
    pub(super) fn factors(&self) -> &[f32; BANDS] {
        &self.factors
    }

    /// The stretch starts afresh.
    pub(super) fn start(&mut self) {
        (self.blocks, self.alarmed) = (0, false);
        (self.now, self.before) = (Highest::default(), Highest::default());
    }

    /// Takes a block of motion: energy of each band over its floor, the sum over its threshold, and what the detector made of both.
    #[inline]
    pub(super) fn step(&mut self, energy: &[f32; BANDS], sum: f32, decided: (f32, SlipState)) {
        let (statistic, state) = decided;
        let energy = core::array::from_fn(|b| energy[b] / self.thresholds[b]);
        self.now = self.now.with(&Highest { energy, sum, statistic });
        self.blocks = self.blocks.saturating_add(1);
        if state != SlipState::Quiet {
            if !self.alarmed {
                (self.alarmed, self.blocks) = (true, 0);
            }
            return;
        }
        if self.alarmed {
            let highest = self.now.with(&self.before);
            let weak = highest.statistic < WEAK;
            let alone = weak && self.blocks <= self.short_len && self.pause == 0;
            self.alone = Some(highest).filter(|_| alone);
            self.weak = if weak { self.weak.saturating_add(1) } else { 0 };
            if self.weak >= MANY {
                self.learn(&highest);
            }
            self.pause = self.pause_len;
            self.start();
        } else if self.pause > 0 {
            self.pause -= 1;
            self.start();
            if self.pause == 0 {
                self.weak = self.weak.saturating_sub(1);
                if let Some(highest) = self.alone.take() {
                    self.learn(&highest);
                }
            }
        } else if self.blocks >= self.stretch_len {
            let highest = core::mem::replace(&mut self.before, self.now);
            self.learn(&highest);
            self.blocks = 0;
            self.now = Highest::default();
        }
    }

    #[cold]
    fn learn(&mut self, highest: &Highest) {
        let faded = self.stretch_len as f32 * self.fading;
        for b in 0..BANDS {
            let factor = &mut self.factors[b];
            *factor += faded * (1.0 - *factor);
            let has_part = b >= FIRST_OCTAVE && highest.energy[b] * self.thresholds[b] > PART;
            let by_sum = if has_part { 1.0 + (highest.sum - NEAR_SUM).max(0.0) } else { 1.0 };
            let raised = (highest.energy[b] / NEAR).max(by_sum).max(1.0);
            *factor = (*factor * raised).min(MOST);
        }
    }
}
