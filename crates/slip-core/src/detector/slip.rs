//! Bands, floor, gate and tests joined: a reading of stylus and motion in, the slip state out.
//!
//! ```text
//! stylus -> bands -> scaled by the quiet floor -> [gate, while the robot moves] -> blocks of 0.5 ms -> tests -> state
//! ```
//!
//! The shear band (20-400 Hz) sees the first elastic movement, the vibration band (100-800 Hz) the
//! texture passing under the stylus; above `gross` times the floor there, the object slides. Four bands that do not overlap
//! tell a slip from motion that fills only some of them.

use super::{
    config::{BANDS, DetectorConfig, TestKind, VIBRATION},
    cusum::Cusum,
    gate::Gate,
    glrt::Glrt,
    lanes::{LANES, Lanes, of_bands, padded, samples},
    primed::PrimedBank,
    reference::{MotionInput, Reference},
    test::{Block, EnergyTest, SequentialTest},
};
use crate::{
    config::ConfigError,
    floor::{Floor, FloorConfig},
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

/// Below this fraction of its recent peak the statistic is the fading memory of a slip that has stopped.
const FRESH: f32 = 0.5;

/// Floors that are known before the first sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KnownFloors {
    /// Energy of each band (signal unit squared).
    pub stylus: Option<[f32; BANDS]>,
    /// Energies of the reference and of its slow part (unit squared).
    pub reference: Option<[f32; 2]>,
}

/// What the tests see, each before its threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// Mean energy of each band over its floor; 1 at rest.
    pub energy: [f32; BANDS],
    /// The cumulative sum (log-likelihood ratio).
    pub cusum: f32,
    /// The statistic that decides, over its threshold.
    pub statistic: f32,
}

/// Filter bank, floor, gate and tests with their memory.
#[derive(Clone, Copy, Debug)]
pub struct SlipDetector {
    bank: PrimedBank,
    floor: Floor<BANDS>,
    /// Reciprocal rms of the floor, once it is known.
    scale: Option<[f32; LANES]>,
    reference: Reference,
    gate: Gate,
    blind_margin: f32,
    moving: bool,
    no_skip: bool,
    block_len: u32,
    per_sample: f32,
    in_block: u32,
    sums: [f32; LANES],
    kind: TestKind,
    energy: EnergyTest,
    cusum: Cusum,
    glrt: Glrt,
    decision: Decision,
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
        let reference = Reference::new(&config.gate, floor, known.reference, (&lanes, rate_hz))?;
        let floor =
            known.stylus.map_or_else(|| Floor::learn(floor, blocks_hz), |e| Floor::known(floor, e));
        #[expect(clippy::cast_precision_loss, reason = "at most 25")]
        let per_sample = 1.0 / lanes.block_len as f32;
        let mut gate = Gate::new(config.gate, lanes.block_s);
        if let Some(energy) = floor.energy() {
            gate.rescale(&energy);
        }
        let cusum = Cusum::new(config.cusum_ratio, config.cusum_threshold, lanes.readings);
        Ok(Self {
            bank: PrimedBank::new(&lanes, rate_hz)?,
            scale: floor.energy().map(reciprocal_rms),
            floor,
            reference,
            gate,
            blind_margin: config.gate.blind_margin,
            moving: false,
            no_skip: false,
            block_len: lanes.block_len,
            per_sample,
            in_block: 0,
            sums: [0.0; LANES],
            kind: config.test,
            energy: EnergyTest::new(1e-3 * config.envelope_ms, lanes.block_s, lanes.thresholds),
            cusum: if config.test == TestKind::Cusum { cusum.in_every_scene() } else { cusum },
            glrt: Glrt::new(config.glrt_threshold, lanes.readings),
            decision: Decision::new(config, lanes.block_s, blocks_hz),
        })
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
        self.scale.is_none()
    }

    /// Noise energy of the bands (signal unit squared), once it is known.
    #[must_use]
    pub fn floor(&self) -> Option<[f32; BANDS]> {
        self.floor.energy()
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

    /// Whether the robot moves, by command or by its reference.
    #[must_use]
    #[inline]
    pub fn is_moving(&self) -> bool {
        self.moving
    }

    /// What the tests see now, each before its threshold.
    #[must_use]
    pub fn levels(&self) -> Levels {
        Levels {
            energy: self.energy.over_floor(),
            cusum: self.cusum.sum(),
            statistic: self.decision.statistic,
        }
    }

    /// Deviation of the noise in the vibration band (signal unit, rms); 0 while the floor is unknown.
    #[must_use]
    pub fn noise_rms(&self) -> f32 {
        self.floor.energy().map_or(0.0, |energy| libm::sqrtf(energy[VIBRATION]))
    }

    /// Whether the signal is above its threshold now, and not only the mean of the last milliseconds.
    #[must_use]
    #[inline]
    pub fn is_fresh(&self) -> bool {
        let Decision { statistic, recent_peak, .. } = self.decision;
        statistic > 1.0 && statistic >= FRESH * recent_peak
    }

    /// Starts the filters afresh with the next samples; the floors stay.
    pub fn prime(&mut self) {
        self.bank.start();
        self.energy.reset();
        self.cusum.reset();
        self.glrt.reset();
        self.reference.restart();
        self.moving = false;
        self.gate.start();
        self.start_block();
        self.decision.reset();
        self.floor.interrupt();
    }

    /// Takes the next reading (finite). Gives the statistic, 1 and above being a slip, and the slip state;
    /// `None` while the filters start and while the floor is unknown.
    #[inline]
    pub fn step(&mut self, x: f32, motion: &MotionInput) -> Option<(f32, SlipState)> {
        let moving = self.reference.watch(motion);
        let y = self.bank.step(x)?;
        if moving != self.moving {
            self.turn(moving);
        }
        match self.scale {
            Some(scale) => self.sample(&scaled(&y, &scale), motion.reference),
            None => self.sample(&y, motion.reference),
        }
        self.in_block += 1;
        if self.in_block >= self.block_len {
            self.end_block();
        }
        self.scale.is_some().then_some((self.decision.statistic, self.decision.state))
    }

    /// Takes a reading that nobody asks about, at the cost of one that is decided on. [`SlipDetector::prime`] forgets it.
    #[inline]
    pub fn step_unheard(&mut self, x: f32, motion: &MotionInput) {
        let Some(y) = self.bank.step(x) else { return };
        for (sum, y) in self.sums.iter_mut().zip(y) {
            *sum += y * y;
        }
        self.gate.sample(&self.reference.bands(motion.reference));
        self.in_block += 1;
        if self.in_block >= self.block_len {
            self.in_block = 0;
            self.bank.flush_tiny();
            self.reference.flush_tiny();
            let energy = self.block_energy();
            let block = Block { energy, floor: self.gate.block(self.per_sample), moving: true };
            self.energy.step(&block);
            self.cusum.step(&block);
        }
    }

    /// The robot starts or stops: the gate starts afresh.
    #[cold]
    fn turn(&mut self, moving: bool) {
        self.moving = moving;
        self.gate.start();
        self.reference.start();
        self.start_block();
    }

    fn start_block(&mut self) {
        self.in_block = 0;
        self.sums = [0.0; LANES];
    }

    #[inline]
    fn sample(&mut self, y: &[f32; LANES], reference: Option<f32>) {
        for (sum, y) in self.sums.iter_mut().zip(y) {
            *sum += y * y;
        }
        if self.moving || self.no_skip {
            self.gate.sample(&self.reference.bands(reference));
        }
    }

    #[inline]
    fn end_block(&mut self) {
        self.bank.flush_tiny();
        self.in_block = 0;
        let mut block = Block {
            energy: self.block_energy(),
            floor: [1.0; BANDS],
            moving: self.moving,
        };
        if self.moving && self.reference.is_live() {
            self.reference.flush_tiny();
            block.floor = self.gate.block(self.per_sample);
        } else if self.moving {
            block.floor = [self.blind_margin; BANDS];
        }
        if self.scale.is_some() {
            self.decide(&block);
        }
        self.reference.end_block(self.per_sample);
        let rests = !self.moving || self.reference.is_doubtful();
        if rests && self.floor.push(&self.unscaled(&block.energy)) {
            self.rescale();
        }
    }

    /// Mean energy of each band in the block that ends.
    #[inline]
    fn block_energy(&mut self) -> [f32; BANDS] {
        let energy = of_bands(&self.sums).map(|sum| sum * self.per_sample);
        self.sums = [0.0; LANES];
        energy
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
        self.scale = Some(reciprocal_rms(floor));
        self.gate.rescale(&floor);
    }

    #[inline]
    fn decide(&mut self, block: &Block) {
        let statistic = match self.kind {
            TestKind::Fused => self.energy.step(block).max(self.cusum.step(block)),
            TestKind::Energy => self.energy.step(block),
            TestKind::Cusum => {
                self.energy.step(block);
                self.cusum.step(block)
            }
            TestKind::Glrt => {
                self.energy.step(block);
                self.glrt.step(block)
            }
        };
        let vibration = self.energy.over_floor()[VIBRATION];
        self.decision.step(statistic, vibration);
    }
}

/// From the statistic to the slip state: thresholds, hysteresis, release.
#[derive(Clone, Copy, Debug)]
struct Decision {
    gross: f32,
    release: f32,
    release_len: u32,
    quiet_run: u32,
    state: SlipState,
    /// The lower one of the last two blocks: the front of a tap may reach the stylus a block before the reference.
    statistic: f32,
    before: f32,
    /// The highest statistic of the last milliseconds, decaying half as fast as the energy does at rest.
    recent_peak: f32,
    peak_decay: f32,
}

impl Decision {
    fn new(config: &DetectorConfig, block_s: f32, blocks_hz: f32) -> Self {
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

    fn reset(&mut self) {
        self.quiet_run = 0;
        self.state = SlipState::Quiet;
        self.statistic = 0.0;
        self.before = 0.0;
        self.recent_peak = 0.0;
    }

    #[inline]
    fn step(&mut self, now: f32, vibration: f32) {
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
}

#[inline]
fn scaled(y: &[f32; LANES], scale: &[f32; LANES]) -> [f32; LANES] {
    core::array::from_fn(|b| y[b] * scale[b])
}

fn reciprocal_rms(energy: [f32; BANDS]) -> [f32; LANES] {
    padded(energy.map(|e| 1.0 / libm::sqrtf(e)), 0.0)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{DetectorConfig, KnownFloors, MotionInput, SlipDetector, SlipState, TestKind};
    use crate::floor::FloorConfig;

    /// Uniform noise of deviation 0.1 um, seeded.
    fn noise(seed: u32) -> impl FnMut() -> f32 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let unit = f64::from(state) / f64::from(u32::MAX) - 0.5;
            #[expect(clippy::cast_possible_truncation, reason = "test signal")]
            let x = (unit * 3.4641e-7) as f32;
            x
        }
    }

    fn detector(rate_hz: f32) -> SlipDetector {
        let known = KnownFloors::default();
        SlipDetector::new(&DetectorConfig::default(), FloorConfig::default(), known, rate_hz)
            .unwrap()
    }

    #[test]
    fn rest_is_quiet_and_a_texture_is_gross_slip_within_milliseconds() {
        for rate in [1000_u16, 2200, 10_000, 20_000] {
            let mut detector = detector(f32::from(rate));
            let mut noise = noise(7);
            for _ in 0..20 * u32::from(rate) {
                if let Some((_, state)) = detector.step(1e-3 + noise(), &MotionInput::default()) {
                    assert_eq!(state, SlipState::Quiet, "at {rate} Hz");
                }
            }
            assert!(!detector.is_learning());
            let mut found = None;
            for i in 0..rate {
                let phase = core::f32::consts::TAU * 250.0 * f32::from(i) / f32::from(rate);
                let verdict = detector
                    .step(1e-3 + 3e-6 * libm::sinf(phase) + noise(), &MotionInput::default());
                if verdict.is_some_and(|(_, state)| state == SlipState::Gross) {
                    found = Some(f32::from(i) / f32::from(rate));
                    break;
                }
            }
            assert!(found.unwrap() < 0.006, "at {rate} Hz: {found:?}");
        }
    }

    /// A tone of 5 um on stylus and reference is motion; the same on the stylus alone is a slip.
    #[test]
    fn what_the_reference_shows_too_is_motion() {
        for test in [TestKind::Fused, TestKind::Energy, TestKind::Cusum, TestKind::Glrt] {
            let config = DetectorConfig { test, ..DetectorConfig::default() };
            let known = KnownFloors::default();
            let detector = SlipDetector::new(&config, FloorConfig::default(), known, 1e4).unwrap();
            let (mut detector, mut noise) = (detector, noise(5));
            let mut run = |stylus_m: f32, reference_m: f32| {
                let mut worst = 0.0_f32;
                for i in 0..10_000_u16 {
                    // Swells within 0.1 s, as motion does.
                    let swell = (f32::from(i) / 1000.0).min(1.0);
                    let tone = swell * libm::sinf(0.1 * f32::from(i));
                    let reference = Some(reference_m * tone + 0.5 * noise());
                    let motion = MotionInput { reference, commanded: false };
                    let verdict = detector.step(stylus_m * tone + noise(), &motion);
                    worst = worst.max(verdict.map_or(0.0, |(statistic, _)| statistic));
                }
                (worst, detector.is_moving())
            };
            assert!(run(0.0, 0.0).0 < 1.0, "{test:?}: rest");
            let (motion, moving) = run(5e-6, 5e-6);
            assert!(motion < 1.0 && moving, "{test:?}: motion {motion}");
            run(0.0, 0.0);
            assert!(run(5e-6, 0.0).0 > 1.0, "{test:?}: slip");
        }
    }

    #[test]
    fn a_slip_ends_after_the_release_time() {
        let mut detector = detector(1000.0);
        let mut noise = noise(3);
        for _ in 0..1000 {
            detector.step(noise(), &MotionInput::default());
        }
        for i in 0..100_u16 {
            detector.step(noise() + if i % 4 < 2 { 3e-6 } else { -3e-6 }, &MotionInput::default());
        }
        let mut lasted = 0_u32;
        while detector
            .step(noise(), &MotionInput::default())
            .is_some_and(|(_, state)| state != SlipState::Quiet)
        {
            lasted += 1;
        }
        assert!((50..200).contains(&lasted), "{lasted} ms");
    }

    #[test]
    fn an_offset_does_not_look_like_a_step_when_the_filters_start() {
        let mut detector = detector(20_000.0);
        let mut noise = noise(11);
        for _ in 0..20_000 {
            detector.step(noise(), &MotionInput::default());
        }
        for start in 0..50_u8 {
            detector.prime();
            let offset = 1e-4 * f32::from(start);
            for _ in 0..2000 {
                let verdict = detector.step(offset + noise(), &MotionInput::default());
                assert!(verdict.is_none_or(|(statistic, _)| statistic < 1.0), "start {start}");
            }
        }
    }
}
