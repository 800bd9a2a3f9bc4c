//! The slip detector: bands, floor, gate and the sum joined.
//!
//! ```text
//! stylus -> bands -> scaled by the quiet floor -> [gate, while the robot moves] -> blocks of 0.5 ms -> sum -> state
//! ```
//!
//! The shear band (20-400 Hz) sees the first elastic movement; the vibration band (100-800 Hz) and the two highest
//! octaves (250-3000 Hz) the texture passing under the stylus, also where the mains hum below; above `gross` times the
//! floor there, the object slides. Four bands that do not overlap separate a slip from motion that fills only some of
//! them. A rate that carries none of them is left with the level
//! (`level`).

use super::{
    config::{BANDS, DetectorConfig, VIBRATION},
    coupling::{Correlation, Coupling, Highest, Knocks, Relation, WEAK},
    envelope::Envelope,
    evidence::{Certificate, Decision, Evidence, Scores},
    lanes::{Axes, LANES, Lanes, Pending, PrimedBank, of_bands, padded},
    level::Level,
    reference::{Delay, Gate, Reference},
    rest::{Doubt, FloorHealth},
    sum::{AlarmSum, Block, COMPONENTS},
};
use crate::{
    alarm::{Cause, Causes},
    error::ConfigError,
    floor::{Floor, FloorConfig},
    health::SensorHealth,
    sample::{Resolution, Sample},
};

/// What the detector sees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum SlipState {
    /// Nothing above the noise.
    #[default]
    Quiet,
    /// Movement without sliding, or before it.
    Incipient,
    /// The object slides.
    Gross,
}

/// Floors that are known before the first sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KnownFloors {
    /// Energy of each band (signal unit squared).
    pub stylus: Option<[f32; BANDS]>,
    /// Energies of the reference and of its slow part (unit squared).
    pub reference: Option<[f32; 2]>,
}

/// What decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// Mean energy of each band over its floor; 1 at rest.
    pub energy: [f32; BANDS],
    /// Evidence of each component of the sum (s).
    pub evidence_s: [f32; COMPONENTS],
    /// Evidence of all over the interval: 1 and above is a slip.
    pub statistic: f32,
}

/// Filter bank, floor, gate and sum with their memory.
#[derive(Clone, Copy, Debug)]
pub struct SlipDetector {
    bank: PrimedBank,
    /// The further axes of the sensor.
    axes: Axes,
    floor: Floor<BANDS>,
    /// Reciprocal rms of the floor; 1 while it is unknown.
    scale: [f32; LANES],
    learning: bool,
    /// While the floor is learned.
    resolution: Resolution,
    reference: Reference,
    gate: Gate,
    coupling: Coupling,
    correlation: Correlation,
    knocks: Knocks,
    /// Blocks of the stylus that wait for a late reference, or of an early one that wait for the stylus.
    delay: Delay,
    blind_margin: f32,
    per_gross: f32,
    moving: bool,
    no_skip: bool,
    rate_hz: f32,
    block_len: usize,
    per_sample: f32,
    /// The block that is being filled: its filters run together when it is full.
    pending: Pending,
    envelope: Envelope,
    sum: AlarmSum,
    /// Where the rate carries no band above motion.
    level: Option<Level>,
    /// The block that was decided on last.
    decided: Option<Block>,
    decisions: u32,
    decision: Decision,
    evidence: Option<Evidence>,
    /// Floors that the evidence is for.
    certified_floor: [f32; BANDS],
    doubt: Doubt,
}

impl SlipDetector {
    /// A detector for samples at `rate_hz` that learns its floors, or takes those that are `known`.
    ///
    /// # Errors
    /// Where a band does not fit the sample rate.
    pub fn new(
        config: &DetectorConfig,
        floor: FloorConfig,
        known: KnownFloors,
        rate_hz: f32,
    ) -> Result<Self, ConfigError> {
        let lanes = Lanes::new(config, rate_hz)?;
        let blocks_hz = 1.0 / lanes.block_s;
        let reference = Reference::new(&config.gate, floor, known.reference, &lanes, rate_hz)?;
        let floor = known.stylus.map_or_else(
            || Floor::learn(floor, blocks_hz).with_parts_of(lanes.part_blocks()),
            |e| Floor::known(floor, e),
        );
        let per_sample = 1.0 / lanes.block_len as f32;
        let mut gate = Gate::new(config.gate, lanes.block_s);
        if let Some(energy) = floor.energy() {
            gate.rescale(&energy);
        }
        Ok(Self {
            bank: PrimedBank::new(&lanes, rate_hz)?,
            axes: Axes::new(&lanes, rate_hz)?,
            scale: floor.energy().map_or([1.0; LANES], reciprocal_rms),
            learning: floor.energy().is_none(),
            // What was calibrated needs no resolution.
            resolution: if floor.energy().is_some() {
                Resolution::settled()
            } else {
                Resolution::default()
            },
            floor,
            reference,
            gate,
            coupling: Coupling::new(config.release_ms, lanes.block_s),
            correlation: Correlation::new(lanes.block_s),
            knocks: Knocks::new(lanes.block_s),
            delay: Delay::new(),
            blind_margin: config.gate.blind_margin,
            per_gross: 1.0 / config.gross,
            moving: false,
            no_skip: false,
            rate_hz,
            block_len: lanes.block_len,
            per_sample,
            pending: Pending::default(),
            envelope: Envelope::new(
                lanes.envelopes_s(1e-3 * config.envelope_ms),
                lanes.block_s,
                lanes.carried(),
            ),
            sum: AlarmSum::new(config, &lanes.readings, lanes.block_s),
            level: (!lanes.above_motion).then(|| Level::new(lanes.block_s)),
            decided: None,
            decisions: 0,
            decision: Decision::new(config, blocks_hz),
            evidence: None,
            certified_floor: [1.0; BANDS],
            doubt: Doubt::new(&lanes.readings),
        })
    }

    /// Certifies slips as well, where the floors are known that `certificate` was made with.
    #[must_use]
    pub fn with_certificate(self, certificate: Option<&Certificate>) -> Self {
        let Some((certificate, floor)) = certificate.zip(self.floor.energy()) else { return self };
        let block_s = self.block_len as f32 / self.rate_hz;
        let evidence = Some(Evidence::new(certificate, block_s));
        Self { evidence, certified_floor: floor, ..self }
    }

    /// Runs the bands of the reference in every scene; the decisions are the same.
    #[must_use]
    pub fn with_no_skip(self, no_skip: bool) -> Self {
        Self { no_skip, ..self }
    }

    /// Whether the noise floor is still being learned.
    #[must_use]
    #[inline]
    pub fn is_learning(&self) -> bool {
        self.learning
    }

    /// Noise energy of the bands (signal unit squared), once it is known.
    #[must_use]
    pub fn floor(&self) -> Option<[f32; BANDS]> {
        self.floor.energy()
    }

    /// Whether the noise floor was learned at rest, as far as is known; at rates without a band above motion, whether
    /// enough motion was seen.
    #[must_use]
    #[inline]
    pub fn floor_health(&self) -> FloorHealth {
        match &self.level {
            Some(level) if level.is_learning() => FloorHealth::Doubtful,
            Some(_) => FloorHealth::Good,
            None => self.doubt.health(),
        }
    }

    /// What was seen so far of a floor that is not known yet is no rest.
    pub fn forget_floor(&mut self) {
        if self.learning {
            self.floor.interrupt();
        }
    }

    /// Energies of the motion reference at rest and of its slow part (unit squared), once they are known.
    #[must_use]
    pub fn reference_floor(&self) -> Option<[f32; 2]> {
        self.reference.quiet()
    }

    /// How often a quieter second has lowered the floor.
    #[must_use]
    pub fn floor_lowered(&self) -> u32 {
        self.floor.lowered()
    }

    /// State of the motion reference. One that is frozen, lost or uncoupled counts as none: only a command states that the
    /// robot moves, and then the floor of every band is raised by `blind_margin`.
    #[must_use]
    #[inline]
    pub fn reference_health(&self) -> SensorHealth {
        match (self.reference.health(), self.correlation.relation()) {
            (SensorHealth::Good, Relation::Shifted) => SensorHealth::Late,
            (SensorHealth::Good, Relation::None) => SensorHealth::Uncoupled,
            (health, _) => health,
        }
    }

    /// How long decisions wait for a motion reference that is late (s); 0 for one in time. It is late by 2.5 ms less.
    #[must_use]
    pub fn waits_s(&self) -> f32 {
        let block_s = self.block_len as f32 / self.rate_hz;
        f32::from(self.delay.blocks().max(0)) * block_s
    }

    /// Whether the robot moves, by command or by its reference.
    #[must_use]
    #[inline]
    pub fn is_moving(&self) -> bool {
        self.moving
    }

    /// Whether a block is being filled: only its end can change the state.
    #[must_use]
    #[inline]
    pub fn in_block(&self) -> bool {
        !self.pending.stylus().is_empty()
    }

    /// What decides now.
    #[must_use]
    pub fn levels(&self) -> Levels {
        Levels {
            energy: self.envelope.over_floor(),
            evidence_s: self.sum.evidence_s(),
            statistic: self.decision.statistic,
        }
    }

    /// The interval (s) that the last decision has certified a slip with: false alarms of that kind are at least so far
    /// apart on average. `None` where it has not, or nothing is calibrated.
    #[must_use]
    #[inline]
    pub fn certified_s(&self) -> Option<f32> {
        self.evidence.as_ref().filter(|e| e.is_certified()).map(Evidence::interval_s)
    }

    /// Whether the sample rate carries each band.
    #[must_use]
    pub fn has_bands(&self) -> [bool; BANDS] {
        self.envelope.carried()
    }

    /// Adds to `causes` what is known of knock, motion and stop of the arm at an alarm, which the stylus `feels` or another method, and which is
    /// `certified`; `command_known` states whether motion is commanded. Motion is ruled out that would have to be several times as strong as the
    /// reference shows it.
    #[must_use]
    pub(crate) fn add_causes(
        &self,
        causes: Causes,
        feels: bool,
        certified: bool,
        command_known: bool,
    ) -> Causes {
        let in_time = self.delay.blocks() != 0 || self.correlation.relation() == Relation::Near;
        let sound = self.reference.is_sound() && in_time;
        let knock = sound.then_some(!(self.moving && self.gate.rings()));
        let motion = match self.moving {
            false => Some(true),
            true => {
                let strong = || self.sum.strength(&self.envelope.over_floor()) >= WEAK;
                Some((sound && feels && strong()) || certified)
            }
        };
        let stop = if self.moving { self.reference.is_going_on(command_known) } else { Some(true) };
        let known = sound || command_known;
        causes
            .with(Cause::Knock, knock)
            .with(Cause::Motion, motion.filter(|_| known))
            .with(Cause::ArmStop, stop.filter(|_| known))
    }

    /// Length of the base blocks of the evidence (s); `None` without a certificate.
    #[must_use]
    pub fn base_block_s(&self) -> Option<f32> {
        self.evidence.as_ref().map(Evidence::base_s)
    }

    /// Scores of the last base block of the evidence; `None` before the first and without a certificate.
    #[must_use]
    pub fn scores(&self) -> Option<&Scores> {
        self.evidence.as_ref()?.scores()
    }

    /// The least vibration (signal unit, rms) that is a slip now, where the rate carries no band above motion; infinite while nothing is
    /// known of that.
    #[must_use]
    pub fn smallest_over_motion(&self) -> Option<f32> {
        self.level.map(|level| libm::sqrtf(level.smallest()))
    }

    /// Deviation of the noise in the vibration band (signal unit, rms); 0 while the floor is unknown.
    #[must_use]
    pub fn noise_rms(&self) -> f32 {
        self.floor.energy().map_or(0.0, |energy| libm::sqrtf(energy[VIBRATION]))
    }

    /// Whether the evidence of the last block is that of a slip, and its energy that of now.
    #[must_use]
    #[inline]
    pub fn is_fresh(&self) -> bool {
        self.decision.statistic >= 1.0 && self.envelope.is_fresh()
    }

    /// How strong the slip is that the stylus shows now: the energy of the bands that slide over half of that of a gross slip, at least 1; 0 where
    /// the evidence of the last block is none.
    #[must_use]
    #[inline]
    pub fn loudness(&self) -> f32 {
        let loud = 2.0 * self.envelope.sliding() * self.per_gross;
        if self.is_fresh() { loud.max(1.0) } else { 0.0 }
    }

    /// The block that the last decision was made from; `None` before the first.
    #[must_use]
    pub fn block(&self) -> Option<&Block> {
        self.decided.as_ref()
    }

    /// Decisions so far, modulo 2^32: each is made from one block.
    #[must_use]
    pub fn decisions(&self) -> u32 {
        self.decisions
    }

    /// Starts the filters afresh with the next samples; the floors stay.
    pub fn prime(&mut self) {
        self.bank.start();
        self.axes.start();
        self.envelope.reset();
        self.sum.reset();
        if let Some(level) = &mut self.level {
            level.start();
        }
        self.reference.restart();
        self.moving = false;
        self.gate.start();
        self.coupling.start();
        self.correlation.interrupt();
        self.delay.clear();
        self.pending.clear();
        self.decision.reset();
        self.restart_evidence();
        self.floor.interrupt();
    }

    /// Takes stylus and motion reference, all axes of both (finite), and the commanded motion of the next sample.
    /// Gives the statistic, 1 and above being a slip, and the slip state;
    /// `None` while the filters start and while the floor is unknown.
    #[inline]
    pub fn step(&mut self, sample: &Sample) -> Option<(f32, SlipState)> {
        let x = sample.stylus;
        self.axes.next(sample.stylus_axes);
        let moving = self.reference.watch(sample);
        if self.bank.is_starting() {
            self.bank.start_with(x);
            self.axes.take();
            return None;
        }
        if moving != self.moving {
            self.turn(moving);
        }
        if self.moving {
            self.reference.follow_command(sample.commands_motion());
        }
        let gated = self.moving || self.no_skip;
        let u = if gated { self.reference.off_mean(sample.reference) } else { 0.0 };
        self.reference.put_by(gated && sample.reference.is_some());
        self.axes.take();
        if self.pending.push(x, u) >= self.block_len {
            self.end_block();
        }
        (!self.learning).then_some((self.decision.statistic, self.decision.state))
    }

    /// Takes a reading that nobody asks about, at the cost of one that is decided on. [`SlipDetector::prime`] forgets it.
    #[inline]
    pub fn step_ignored(&mut self, sample: &Sample) {
        let x = sample.stylus;
        self.axes.next(sample.stylus_axes);
        self.reference.pass_axes(sample);
        self.axes.take();
        if self.bank.is_starting() {
            self.bank.start_with(x);
            return;
        }
        self.reference.put_by(sample.reference.is_some());
        if self.pending.push(x, self.reference.off_mean(sample.reference)) >= self.block_len {
            let energy = self.block_energy();
            let floor = self.gate.block(
                &self.reference.energy(&self.pending),
                self.per_sample,
                self.coupling.factors(),
            );
            self.pending.clear();
            let block = Block { energy, floor, moving: true };
            self.envelope.step(&block);
            self.sum.step(&block);
        }
    }

    /// The robot starts or stops: the block and the gate start afresh.
    #[cold]
    fn turn(&mut self, moving: bool) {
        self.moving = moving;
        self.block_energy();
        self.pending.clear();
        self.gate.start();
        self.delay.turn();
        self.coupling.start();
        self.correlation.interrupt();
        self.reference.start();
        self.restart_evidence();
    }

    fn restart_evidence(&mut self) {
        if let Some(evidence) = &mut self.evidence {
            evidence.restart();
        }
    }

    fn end_block(&mut self) {
        if self.learning || !self.resolution.is_known() {
            self.resolve();
        }
        let now = self.block_energy();
        let waited = self.delay.stylus(now);
        let energy = waited.unwrap_or(now);
        let mut block = Block { energy, floor: [1.0; BANDS], moving: self.moving };
        if self.moving || self.no_skip {
            let sums = self.reference.energy(&self.pending);
            let learned = self.coupling.factors();
            let floor = self.gate.block(&self.delay.reference(sums), self.per_sample, learned);
            if self.moving {
                let instant = self.gate.instant(&sums, self.per_sample, learned);
                self.gate_block(&mut block, floor, &now, &instant);
            }
        }
        self.pending.clear();
        if waited.is_none() {
            self.reference.end_block(self.per_sample);
            return;
        }
        if !self.learning {
            self.decide(&block);
        }
        self.reference.end_block(self.per_sample);
        let rests = !self.moving || self.reference.is_doubtful();
        if !rests {
            return;
        }
        if self.decision.state != SlipState::Quiet {
            self.doubt.disturb();
        }
        if self.floor.push(&self.unscaled(&block.energy)) {
            self.rescale();
        }
        if let Some(stretch) = self.floor.take_stretch() {
            self.doubt.judge(&stretch);
        }
    }

    /// Takes a decision into the evidence.
    #[inline(never)]
    fn weigh(&mut self, block: &Block) {
        // Without its reference motion is not what the calibration saw.
        let health = self.reference_health();
        let unseen = !matches!(health, SensorHealth::Good | SensorHealth::Late)
            || (block.moving && !self.reference.is_live());
        let Some(evidence) = &mut self.evidence else { return };
        if unseen {
            evidence.restart();
        } else if evidence.step(block) {
            self.decision.certify();
        }
    }

    /// Raises the floor of a block of motion by what is known of that: the reference, the command, or nothing. `energy`
    /// and `instant` are those of the block that does not wait, and the floor that the reference gives it.
    #[inline]
    fn gate_block(
        &mut self,
        block: &mut Block,
        floor: [f32; BANDS],
        energy: &[f32; BANDS],
        instant: &[f32; BANDS],
    ) {
        let live = self.reference.is_live();
        let coupled = self.correlation.relation() != Relation::None;
        if live && !self.learning {
            self.correlation.step(energy, instant);
            let wait = match self.correlation.wait() {
                0 if self.correlation.relation() == Relation::Near => self.knocks.wait(),
                blocks => blocks,
            };
            if wait != self.delay.blocks() {
                self.delay.set(wait);
                // What was learned of fronts that the reference showed too late is no gain.
                self.coupling.forget();
            }
        }
        let misses_one = !live && self.reference.health() == SensorHealth::Good;
        if live && coupled {
            block.floor = floor;
        } else if self.reference.is_commanded() || misses_one {
            block.floor = [self.blind_margin; BANDS];
        } else {
            block.moving = false;
        }
    }

    #[cold]
    fn resolve(&mut self) {
        for x in self.pending.stylus() {
            self.resolution.push(*x);
        }
        let coarse = self.resolution.is_coarse();
        // The readings of a coarse sensor may all be the same until something moves.
        if self.floor.resolve(self.axes.resolution(self.resolution.rms()), coarse) {
            self.rescale();
        }
    }

    /// Runs the bands over the block: the mean energy of each, over all axes.
    #[inline]
    fn block_energy(&mut self) -> [f32; BANDS] {
        let mut sums = self.bank.energy(&self.pending, &self.scale);
        self.axes.add_energy(&mut sums, &self.scale);
        of_bands(&sums).map(|sum| sum * self.per_sample)
    }

    fn unscaled(&self, energy: &[f32; BANDS]) -> [f32; BANDS] {
        match self.floor.energy() {
            Some(floor) => core::array::from_fn(|b| energy[b] * floor[b]),
            None => *energy,
        }
    }

    /// A floor is new: everything is in units of the floors.
    #[cold]
    fn rescale(&mut self) {
        let Some(floor) = self.floor.energy() else { return };
        let before = of_bands(&core::mem::replace(&mut self.scale, reciprocal_rms(floor)));
        let now = of_bands(&self.scale);
        self.delay.rescale(core::array::from_fn(|b| (now[b] / before[b]) * (now[b] / before[b])));
        self.learning = false;
        self.gate.rescale(&floor);
        if let Some(evidence) = &mut self.evidence {
            evidence.rescale(core::array::from_fn(|b| floor[b] / self.certified_floor[b]));
        }
    }

    #[inline]
    fn decide(&mut self, block: &Block) {
        self.envelope.step(block);
        self.decided = Some(*block);
        self.decisions = self.decisions.wrapping_add(1);
        let statistic = match (&mut self.level, self.floor.energy()) {
            (Some(level), Some(floor)) => level.step(block.energy[VIBRATION], floor[VIBRATION]),
            _ => self.sum.step(block),
        };
        self.decision.step(statistic, self.envelope.sliding());
        let alarmed = self.decision.state != SlipState::Quiet;
        self.knocks.step(alarmed, self.moving && self.gate.rings());
        if self.evidence.is_some() {
            self.weigh(block);
        }
        if block.moving && self.reference.is_live() && !self.gate.rings() {
            let energy = self.envelope.over_floor();
            // What is asked of in an alarm, and near one.
            let strength = if alarmed { self.sum.strength(&energy) } else { 0.0 };
            let factors =
                if self.sum.is_near() { self.sum.unexplained() } else { [1.0; COMPONENTS] };
            let seen = Highest { energy, strength, factors };
            self.coupling.step(&seen, self.decision.state);
        }
    }
}

fn reciprocal_rms(energy: [f32; BANDS]) -> [f32; LANES] {
    padded(energy.map(|e| 1.0 / libm::sqrtf(e)), 0.0)
}

#[cfg(test)]
mod tests;
