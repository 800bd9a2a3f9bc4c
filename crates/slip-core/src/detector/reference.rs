//! Readings of the motion reference and commanded motion in; whether the robot moves, and the bands of the reference, out.
//!
//! While the robot stands still each reading costs two comparisons: its distance from the running mean (10 ms), and the mean of
//! this distance over 1.5 ms, each against `motion_sigmas` times its noise. The second sees slow motion that the noise of
//! single readings hides, but that the shear band of the stylus would not. The bands run only in motion.

use super::{
    axes::ReferenceAxes,
    gate::GateConfig,
    lanes::{LANES, Lanes, samples},
    pending::Pending,
};
use crate::{
    error::ConfigError,
    filter::FilterBank,
    floor::{Floor, FloorConfig},
    health::SensorHealth,
    sample::FURTHER_AXES,
};

/// What is known of the robot's motion at a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionInput {
    /// The motion reference (own unit); `None` where there is none, or its reading is unusable.
    pub reference: Option<f32>,
    /// Arm or fingers were told to move.
    pub commanded: bool,
}

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
    /// What the command says of the motion, and samples for which its end is not long ago.
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
        (lanes, rate_hz): (&Lanes, f32),
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

    /// Takes the further axes of the next reading.
    #[inline]
    pub(super) fn beside(&mut self, axes: [f32; FURTHER_AXES]) {
        self.axes.next(axes);
    }

    /// Takes the further axes of this step into the block, where the reading is `live`.
    #[inline]
    pub(super) fn put_by(&mut self, live: bool) {
        self.axes.put_by(live);
    }

    /// Whether the robot moves. Takes the next readings.
    #[inline]
    pub(super) fn watch(&mut self, motion: &MotionInput) -> bool {
        self.judge(motion.reference);
        self.live = motion.reference.is_some() && self.health == SensorHealth::Good;
        if let Some(r) = motion.reference {
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
        if motion.commanded {
            self.hold = self.hold_len;
        }
        self.hold = self.hold.saturating_sub(1);
        self.hold > 0 || (self.doubtful && self.health == SensorHealth::Good)
    }

    /// Whether the channel still says anything, once its noise is known.
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

    /// Whether a motion goes on that has not just stopped; `None` where that cannot be told.
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
