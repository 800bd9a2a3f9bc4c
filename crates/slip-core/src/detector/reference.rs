//! Motion reference: whether the robot moves, and what that may add to the floor of each band, from its readings and commanded motion.
//!
//! While the robot stands still each reading costs two comparisons: its distance from the running mean (10 ms), and the mean of
//! this distance over 1.5 ms, each against `motion_sigmas` times its noise. The second sees slow motion that the noise of
//! single readings hides, but that the shear band of the stylus would not. The bands run only in motion.

use super::{
    config::{BANDS, FIRST_OCTAVE},
    lanes::{LANES, Lanes, Pending, ReferenceAxes, of_bands, padded, samples},
};
use crate::{
    error::ConfigError,
    filter::FilterBank,
    floor::{Floor, FloorConfig},
    health::SensorHealth,
    sample::Sample,
    settings::settings,
};

/// Time constant of the mean from which a reading's distance counts (s).
const MEAN_S: f32 = 0.01;
/// Time constant of the mean distance (s).
const SLOW_S: f32 = 1.5e-3;
/// Noise is white within this factor. A quiet level with more energy at low frequencies was learned in motion.
const COLOURED: f32 = 4.0;
/// Time without another reading after which the reference cannot be believed (ms): coarse converters repeat a value for some time.
const DEAD_MS: f32 = 250.0;
/// Time for which the reference does not show a motion that goes on, at most (ms).
const PAUSE_MS: f32 = 20.0;
/// Blocks in a part of its floor: the median of fewer readings lies far below their mean.
const PART_BLOCKS: u32 = 4;
/// Smallest noise of a reference that is believed (own unit, rms): one that stands still at rest, to the last bit,
/// shows motion by any change.
const MIN_RMS: f32 = 1e-18;

#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    sigmas2: f32,
    bank: FilterBank<LANES>,
    /// Its further axes.
    axes: ReferenceAxes,
    mean: Option<f32>,
    mean_share: f32,
    slow: f32,
    slow_share: f32,
    /// Energy of the distance from the mean, and of its mean, within this block.
    sums: [f32; 2],
    floor: Floor<2>,
    limits2: [f32; 2],
    /// What was learned as noise looks like motion: it is taken for motion until a quieter second comes.
    doubtful: bool,
    hold_len: u32,
    hold: u32,
    /// What the command states of the motion, and samples for which its end is not long ago.
    commanded: bool,
    stopped: u32,
    pause_len: u32,
    live: bool,
    last: f32,
    /// Samples since the reading last changed, and since there was one.
    unchanged: u32,
    absent: u32,
    dead_len: u32,
    health: SensorHealth,
}

impl Reference {
    /// A reference that learns its noise at rest, or has the `known` energies (unit squared).
    pub(super) fn new(
        gate: &GateConfig,
        floor: FloorConfig,
        known: Option<[f32; 2]>,
        lanes: &Lanes,
        rate_hz: f32,
    ) -> Result<Self, ConfigError> {
        let config = FloorConfig { min_rms: MIN_RMS, ..floor };
        let sigmas2 = gate.motion_sigmas * gate.motion_sigmas;
        Ok(Self {
            sigmas2,
            bank: lanes.bank(rate_hz)?,
            axes: ReferenceAxes::new(lanes, rate_hz)?,
            mean: None,
            mean_share: -libm::expm1f(-1.0 / (MEAN_S * rate_hz)),
            slow: 0.0,
            slow_share: -libm::expm1f(-1.0 / (SLOW_S * rate_hz)),
            sums: [0.0; 2],
            floor: known.map_or_else(
                || Floor::learn(config, 1.0 / lanes.block_s).with_parts_of(PART_BLOCKS),
                |energy| Floor::known(config, energy),
            ),
            limits2: known.map_or([f32::INFINITY; 2], |energy| energy.map(|e| sigmas2 * e)),
            doubtful: false,
            hold_len: samples(gate.hold_ms, rate_hz),
            hold: 0,
            commanded: false,
            stopped: 0,
            pause_len: samples(PAUSE_MS, rate_hz),
            live: false,
            last: 0.0,
            unchanged: 0,
            absent: 0,
            dead_len: samples(DEAD_MS, rate_hz),
            health: SensorHealth::Good,
        })
    }

    /// Takes the further axes of a sample that nobody asks about.
    #[inline]
    pub(super) fn pass_axes(&mut self, sample: &Sample) {
        self.axes.next(sample.reference_axes);
    }

    /// Takes the further axes of this step into the block, where the reading is `live`.
    #[inline]
    pub(super) fn put_by(&mut self, live: bool) {
        self.axes.put_by(live);
    }

    /// Whether the robot moves. Takes the next readings; `None`: no reference, or an unusable reading.
    #[inline]
    pub(super) fn watch(&mut self, sample: &Sample) -> bool {
        self.axes.next(sample.reference_axes);
        self.judge(sample.reference);
        self.live = sample.reference.is_some() && self.health == SensorHealth::Good;
        if let Some(r) = sample.reference {
            let mean = *self.mean.get_or_insert(r);
            let distance = r - mean;
            self.mean = Some(mean + self.mean_share * distance);
            self.slow += self.slow_share * (distance - self.slow);
            let mut energy = [distance * distance, self.slow * self.slow];
            self.axes.add_distance(&mut energy, self.mean_share, self.slow_share);
            self.sums = [self.sums[0] + energy[0], self.sums[1] + energy[1]];
            if energy[0] > self.limits2[0] || energy[1] > self.limits2[1] {
                self.hold = self.hold_len;
            }
        }
        if sample.commands_motion() {
            self.hold = self.hold_len;
        }
        self.hold = self.hold.saturating_sub(1);
        self.hold > 0 || (self.doubtful && self.health == SensorHealth::Good)
    }

    /// Whether the channel still states anything, once its noise is known.
    #[inline]
    fn judge(&mut self, reading: Option<f32>) {
        if self.limits2[0] == f32::INFINITY {
            return;
        }
        match reading {
            Some(r) if r.to_bits() == self.last.to_bits() && !self.axes.has_changed() => {
                self.unchanged = self.unchanged.saturating_add(1);
                self.absent = 0;
            }
            Some(r) => (self.last, self.unchanged, self.absent) = (r, 0, 0),
            None => self.absent = self.absent.saturating_add(1),
        }
        self.health = if self.absent > self.dead_len {
            SensorHealth::Lost
        } else if self.unchanged > self.dead_len {
            SensorHealth::Frozen
        } else {
            SensorHealth::Good
        };
    }

    /// State of the channel.
    #[inline]
    pub(super) fn health(&self) -> SensorHealth {
        self.health
    }

    /// Takes the commanded motion while the robot moves.
    #[inline]
    pub(super) fn follow_command(&mut self, commanded: bool) {
        self.commanded = commanded;
        self.stopped = if commanded { self.hold_len } else { self.stopped.saturating_sub(1) };
    }

    /// Whether motion is commanded, or was not long ago.
    #[inline]
    pub(super) fn is_commanded(&self) -> bool {
        self.stopped > 0
    }

    /// Whether a motion goes on that has not just stopped; `None` where that is not known.
    pub(super) fn is_going_on(&self, command_known: bool) -> Option<bool> {
        let quiet_for = self.hold_len.saturating_sub(self.hold);
        if self.commanded {
            Some(true)
        } else if self.stopped > 0 || (self.hold > 0 && quiet_for > self.pause_len) {
            Some(false)
        } else {
            command_known.then_some(true)
        }
    }

    /// Whether its noise is known, it can be believed and the last sample had a usable reading.
    pub(super) fn is_sound(&self) -> bool {
        self.live && self.floor.energy().is_some() && !self.doubtful
    }

    /// Whether the last sample had a usable reading.
    #[inline]
    pub(super) fn is_live(&self) -> bool {
        self.live
    }

    /// Energies at rest of the distance from the mean and of its mean, once they are known (unit squared).
    pub(super) fn quiet(&self) -> Option<[f32; 2]> {
        self.floor.energy()
    }

    /// Whether the level learned as noise looks like motion.
    #[inline]
    pub(super) fn is_doubtful(&self) -> bool {
        self.doubtful
    }

    /// Starts the bands as if the reference had always been at its mean.
    pub(super) fn start(&mut self) {
        self.bank.prime(0.0);
        self.axes.start();
    }

    /// Everything but the floor begins with the next reading, after a gap in time.
    pub(super) fn restart(&mut self) {
        self.mean = None;
        self.unchanged = 0;
        self.absent = 0;
        self.health = SensorHealth::Good;
        self.hold = 0;
        (self.commanded, self.stopped) = (false, 0);
        self.slow = 0.0;
        self.sums = [0.0; 2];
        self.floor.interrupt();
        self.axes.restart();
        self.start();
    }

    /// A reading without the mean (unit); an absent one is taken as the mean.
    #[inline]
    pub(super) fn off_mean(&self, reference: Option<f32>) -> f32 {
        let mean = self.mean.unwrap_or(0.0);
        reference.map_or(0.0, |r| r - mean)
    }

    /// Runs the bands over a block: the sum of squares of each band signal (unit squared).
    #[inline]
    pub(super) fn energy(&mut self, block: &Pending) -> [f32; LANES] {
        let mut sums = self.bank.energy(block.reference(), 0.0, &[1.0; LANES]);
        self.axes.add_energy(&mut sums);
        sums
    }

    /// Ends a block of `1 / per_sample` samples.
    #[inline]
    pub(super) fn end_block(&mut self, per_sample: f32) {
        self.axes.end_block();
        let energy = core::mem::take(&mut self.sums).map(|sum| sum * per_sample);
        if self.live && self.floor.push(&energy) {
            let quiet = self.floor.energy().unwrap_or([f32::INFINITY; 2]);
            self.limits2 = quiet.map(|e| self.sigmas2 * e);
            // The mean of white noise with weight a has a / (2 - a) of its energy.
            let white = self.slow_share / (2.0 - self.slow_share);
            self.doubtful = quiet[1] > COLOURED * white * quiet[0];
        }
    }
}

// Motion gate: what the robot's own motion may add to the floor of each band, from band energies of the motion reference.

settings! {
    /// How the motion of the robot is distinguished from slip.
    pub struct GateConfig as c in "detector.gate" {
        gain: [f32; BANDS] = [0.5, 0.5, 0.5, 0.5, 0.5, 0.7], 0.0..=1e30 =>
            "What motion adds to the floor of shear, vibration and the four other bands, over the energy of the"
            "reference (stylus unit squared over reference unit squared). The defaults fit a reference that shows"
            "motion about as the stylus does, within a factor of 1.5 in amplitude; another needs calibration.";
        motion_sigmas: f32 = 6.0, 3.0..=1e3 => "Reference over its noise (rms) that is motion.";
        hold_ms: f32 = 300.0, 10.0..=1e4 => "How long motion is taken to last after the reference has shown it (ms).";
        blind_margin: f32 = 16.0, 1.0..=1e9 =>
            "Times the quiet floor is raised in commanded motion without a reference.";
    }
}

/// Memory of the highest block of the reference (s).
const PEAK_S: f32 = 3e-3;

/// Peak of a band of the reference over its mean that is a knock.
const KNOCK: f32 = 5.0;
/// What a knock may show more at the stylus than motion does (energy).
const KNOCK_GAIN: f32 = 8.0;
/// How long a knock rings (s).
const RINGS_S: f32 = 0.04;
/// Memory of the mean peak (s).
const GATE_MEAN_S: f32 = 0.01;
/// So long after it (s) less than this share of its height is left of a knock; what has more is motion.
const FADED_S: f32 = 0.015;
const LEFT: f32 = 0.3;

/// The gate and its memory.
///
/// ```text
/// floor_b = 1 + gain_b r_b       r_b <- max(energy of the reference in the block, r_b exp(-block / 3 ms))
/// ```
///
/// in units of the quiet floors. `gain` is the energy that motion leaves in a band of the stylus over the energy it leaves in
/// the same band of the reference, times what it takes to keep the alarm threshold above all of it: with a
/// threshold h on energy over floor, motion may show h gain times as strongly at the stylus as at the reference. The peak holds
/// over the time between the peaks of two filters, so that the front of a tap does not slip through.
///
/// A knock reaches stylus and reference by ways of its own, so that the gain of the robot's motion shows nothing of it. It shows as a jump of the
/// reference: for some time after a peak of [`KNOCK`] times its mean, and after motion has begun, the gain is [`KNOCK_GAIN`] times as high.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gate {
    config: GateConfig,
    /// Gain of each band between energies scaled by their quiet floors.
    gain: [f32; BANDS],
    peak: [f32; BANDS],
    peak_decay: f32,
    /// Mean of the peak, its share of a block, and blocks until the last knock no longer rings.
    mean: [f32; BANDS],
    mean_share: f32,
    rings: u32,
    rings_len: u32,
    faded_len: u32,
    /// The highest peak since the knock, in the bands that it shows in.
    struck: f32,
}

impl Gate {
    /// A gate for blocks of `block_s` (s).
    pub(super) fn new(config: GateConfig, block_s: f32) -> Self {
        Self {
            config,
            gain: [0.0; BANDS],
            peak: [0.0; BANDS],
            peak_decay: libm::expf(-block_s / PEAK_S),
            mean: [0.0; BANDS],
            mean_share: -libm::expm1f(-block_s / GATE_MEAN_S),
            rings: 0,
            rings_len: samples(1e3 * RINGS_S, 1.0 / block_s),
            faded_len: samples(1e3 * (RINGS_S - FADED_S), 1.0 / block_s),
            struck: 0.0,
        }
    }

    /// Takes new quiet floors (unit squared).
    pub(super) fn rescale(&mut self, stylus: &[f32; BANDS]) {
        self.gain = core::array::from_fn(|b| (self.config.gain[b] / stylus[b]).min(1e30));
        self.start();
    }

    /// Begins another stretch of motion.
    pub(super) fn start(&mut self) {
        self.peak = [0.0; BANDS];
        self.mean = [0.0; BANDS];
        (self.rings, self.struck) = (self.rings_len, 0.0);
    }

    /// Whether a knock rings, or motion has just begun.
    #[inline]
    pub(super) fn rings(&self) -> bool {
        self.rings > 0
    }

    /// The floor of each band that a block alone gives, without knock and peak: what is held longer would show the
    /// reference late.
    #[inline]
    pub(super) fn instant(
        &self,
        sums: &[f32; LANES],
        per_sample: f32,
        learned: &[f32; BANDS],
    ) -> [f32; BANDS] {
        core::array::from_fn(|b| 1.0 + learned[b] * self.gain[b] * sums[b] * per_sample)
    }

    /// Takes the sum of squares of each band of the reference (unit squared) over a block of `1 / per_sample` samples: the floor
    /// of each band over its quiet floor.
    #[inline]
    pub(super) fn block(
        &mut self,
        sums: &[f32; LANES],
        per_sample: f32,
        learned: &[f32; BANDS],
    ) -> [f32; BANDS] {
        let (mut knocks, mut level) = (false, 0.0);
        for (b, sum) in sums.iter().enumerate().take(BANDS) {
            let energy = sum * per_sample;
            self.peak[b] = energy.max(self.peak[b] * self.peak_decay);
            if b >= FIRST_OCTAVE + 2 {
                knocks |= self.peak[b] > KNOCK * self.mean[b];
                level += self.peak[b];
            }
            self.mean[b] += self.mean_share * (self.peak[b] - self.mean[b]);
        }
        self.struck = if self.rings > 0 { self.struck.max(level) } else { level };
        self.rings = if knocks { self.rings_len } else { self.rings.saturating_sub(1) };
        if self.rings == self.faded_len && level > LEFT * self.struck {
            self.rings = 0;
        }
        let over = if self.rings > 0 { KNOCK_GAIN } else { 1.0 };
        core::array::from_fn(|b| 1.0 + over * learned[b] * self.gain[b] * self.peak[b])
    }
}

// Delay of energies of blocks by a number of blocks: the stylus waits for a reference that is late, a
// reference that is early for the stylus.

/// Longest delay in blocks: 107.5 ms at 50 kHz and below.
pub(super) const LONGEST_DELAY: u8 = 215;

/// The blocks that wait.
#[derive(Clone, Copy, Debug)]
pub(super) struct Delay {
    past: [[f32; BANDS]; LONGEST_DELAY as usize],
    len: u8,
    /// The reference waits, not the stylus.
    early: bool,
    at: u8,
    filled: u8,
}

impl Delay {
    /// None waits.
    pub(super) const fn new() -> Self {
        Self {
            past: [[0.0; BANDS]; LONGEST_DELAY as usize],
            len: 0,
            early: false,
            at: 0,
            filled: 0,
        }
    }

    /// How long the stylus waits (blocks); below 0 the reference.
    #[inline]
    pub(super) fn blocks(&self) -> i16 {
        let len = i16::from(self.len);
        if self.early { -len } else { len }
    }

    /// Another delay (blocks), at most [`LONGEST_DELAY`]; it begins empty.
    pub(super) fn set(&mut self, blocks: i16) {
        self.len =
            u8::try_from(blocks.unsigned_abs()).map_or(LONGEST_DELAY, |len| len.min(LONGEST_DELAY));
        self.early = blocks < 0;
        self.clear();
    }

    /// What waits belongs to nothing that follows.
    pub(super) fn clear(&mut self) {
        (self.at, self.filled) = (0, 0);
    }

    /// The robot starts or stops: what waits of the reference belongs to another stretch of motion.
    pub(super) fn turn(&mut self) {
        if self.early {
            self.clear();
        }
    }

    /// Takes the energies of a block of the stylus; gives those that are decided on, `None` until there are any.
    #[inline]
    pub(super) fn stylus(&mut self, energy: [f32; BANDS]) -> Option<[f32; BANDS]> {
        if self.early { Some(energy) } else { self.pass(energy) }
    }

    /// Takes the energies of a block of the reference; gives those that belong to the block that is decided on.
    #[inline]
    pub(super) fn reference(&mut self, energy: [f32; LANES]) -> [f32; LANES] {
        if self.early {
            padded(self.pass(of_bands(&energy)).unwrap_or_default(), 0.0)
        } else {
            energy
        }
    }

    /// Takes the energies of a block; gives those of the block that far before, `None` until there is one.
    #[inline]
    fn pass(&mut self, energy: [f32; BANDS]) -> Option<[f32; BANDS]> {
        if self.len == 0 {
            return Some(energy);
        }
        let before = core::mem::replace(self.past.get_mut(usize::from(self.at))?, energy);
        self.at = if self.at + 1 < self.len { self.at + 1 } else { 0 };
        if self.filled < self.len {
            self.filled += 1;
            return None;
        }
        Some(before)
    }

    /// The floors that the energies of the stylus are over are `1 / factors` of those before.
    #[cold]
    pub(super) fn rescale(&mut self, factors: [f32; BANDS]) {
        if self.early {
            return;
        }
        for energy in self.past.iter_mut().take(self.filled.into()) {
            energy.iter_mut().zip(factors).for_each(|(e, factor)| *e *= factor);
        }
    }
}

#[cfg(test)]
mod delay_tests {
    use super::{super::config::BANDS, Delay, LANES, LONGEST_DELAY, of_bands};

    #[test]
    fn a_block_comes_out_as_many_blocks_later_in_the_floors_of_then() {
        let energy = |i: u16| [f32::from(i); BANDS];
        let mut delay = Delay::new();
        assert_eq!(delay.pass(energy(7)), Some(energy(7)));
        for blocks in [1_u16, 3, 50] {
            delay.set(i16::try_from(blocks).unwrap());
            for i in 0..200 {
                assert_eq!(delay.pass(energy(i)), i.checked_sub(blocks).map(energy), "{blocks}");
            }
            delay.rescale([2.0; BANDS]);
            assert_eq!(delay.pass(energy(0)), Some(energy(2 * (200 - blocks))));
        }
        delay.set(i16::from(LONGEST_DELAY) + 1);
        assert_eq!(delay.blocks(), i16::from(LONGEST_DELAY));
        assert_eq!(delay.reference([1.0; LANES]), [1.0; LANES]);
    }

    #[test]
    fn a_reference_that_is_early_waits_and_the_stylus_does_not() {
        let mut delay = Delay::new();
        delay.set(-2);
        for (i, wanted) in [0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 5.0].into_iter().enumerate() {
            if i == 4 {
                delay.turn();
            }
            let given = delay.reference([1.0 + i as f32; LANES]);
            assert_eq!(of_bands(&given), [wanted; BANDS], "{i}");
            delay.rescale([9.0; BANDS]);
            assert_eq!(delay.stylus([3.0; BANDS]), Some([3.0; BANDS]));
        }
        assert_eq!(delay.blocks(), -2);
    }
}
