//! A recording of work without any slip in; the noise floor, the motion gate and the slack for a wanted false-alarm
//! interval out.
//!
//! 1. Floor: mean energy of each band while the reference shows no motion (all of it, where there is no reference).
//!    Where that changes, only what is as quiet as its quietest quarter counts (`quiet`); the slack covers the rest.
//! 2. Gate: mean energy of each band in motion, floor taken off, over that of the reference, times one half.
//! 3. Slack: with the two in force, the blocks that the detector decides on, cut into stretches. The least slack of
//!    each component and scene at which its own sum keeps the wanted interval, from every other stretch; then one
//!    factor on all of them, by the stretches between (`slack`).
//! 4. Replay of the recording with that: while a slip remains, the factor rises. What remains at last is stated.
//! 5. Certificate: limits and chances of the alarm whose interval holds for every law of the noise
//!    ([`certify`](crate::certify)).

mod quiet;
mod slack;

use crate::{
    certify::{NotCertified, Stretch, certify},
    taxels,
};
use grip_record::{Channel, Recording, StylusKind};
use grip_session::{
    calibration::{
        ArrayCalibration, Calibration, Certified, Evidence, StylusCalibration, TaxelRest,
    },
    config::HostConfig,
    model::default_estimator,
    replay::{self, Replay},
};
use slack::DecidedBlocks;
use slip_core::{
    ConfigError, Pipeline, PipelineConfig, Sample, Step,
    detector::{BANDS, Certificate, RestMeter, SlipDetector},
    health::{self, SensorHealth},
    isolated::Guard,
    sample::Vector,
};

/// Times the mean ratio of motion at stylus and reference that the gate takes for granted; the slack stands on top
/// of it.
const MARGIN: f32 = 0.5;
/// Rest that is needed (s).
const REST_S: f64 = 5.0;
/// Motion that is needed to set the gate (s).
pub const MOTION_S: f64 = 5.0;
/// Parts of the rest whose energies are compared: their number at least, and their length at most (s).
const PARTS: usize = 8;
const PART_S: f64 = 2.0;
/// Largest over smallest energy of the parts of steady noise, at most.
pub const STEADY: f32 = 3.0;
/// Quiet rest (s) that is needed for a floor of its own.
const QUIET_S: f64 = 1.0;
/// Share of a recording in which the sensor may show nothing.
const MOST_LOST: f64 = 0.5;
/// Times the factor on the slack is raised while slips remain.
const RAISES: usize = 12;
type Bare = Pipeline<&'static [f32]>;

/// A calibration, and why it certifies nothing where it does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibrated {
    /// What is written to the file.
    pub calibration: Calibration,
    /// Whether it has a certificate.
    pub certified: Result<(), NotCertified>,
}

/// Why a recording does not give a calibration.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// There is neither a stylus nor a taxel array.
    #[error("no stylus, vibration or taxels to calibrate")]
    NoSensor,
    /// Nobody knows when the fingers close on a taxel array that is alone.
    #[error(
        "taxels alone need `force_n`, which shows fingers that close from an object that is held; without it `gripctl score` prints noise and range of labelled rest, for pressure.known_rms and pressure.known_range"
    )]
    NoForce,
    /// The taxels show too little of a grip force that stands, or always the same.
    #[error(
        "{held_s:.1} s in which the grip force stands and nothing moves, with a noise of {rms} (rms) of the taxels; record at least {REST_S} s of an object that is held, with taxels that are alive"
    )]
    ShortArray {
        /// Time (s) in which the force stands and nothing moves.
        held_s: f64,
        /// Noise of the taxels in it (their unit, rms).
        rms: f32,
    },
    /// Too little rest.
    #[error(
        "{rest_s:.3} s of stillness is too short for a floor; record at least {REST_S} s without slip and without motion"
    )]
    Short {
        /// Rest found (s).
        rest_s: f64,
    },
    /// The stylus showed nothing for most of the recording.
    #[error(
        "the stylus is not healthy: {lost} of {samples} readings show nothing, health `{health}`"
    )]
    Unhealthy {
        /// Readings without a number, saturated or frozen.
        lost: u64,
        /// All readings.
        samples: u64,
        /// The last such state.
        health: &'static str,
    },
    /// The wanted interval makes no sense.
    #[error("--interval {0}: expected 1 to 1e9 seconds")]
    Interval(f64),
    /// The settings do not fit the recording.
    #[error(transparent)]
    Config(#[from] ConfigError),
}

/// Checks a wanted mean time between false alarms (s) before anything is measured for it.
///
/// # Errors
/// [`CalibrationError::Interval`] outside of 1 to 1e9 s.
pub fn check_interval(interval_s: f64) -> Result<(), CalibrationError> {
    if (1.0..=1e9).contains(&interval_s) {
        return Ok(());
    }
    Err(CalibrationError::Interval(interval_s))
}

/// Calibrates the detector of `config` on a recording that holds no slip.
///
/// # Errors
/// Where the floor cannot be trusted.
pub fn calibrate(
    recording: &Recording,
    config: &HostConfig,
    interval_s: f64,
) -> Result<Calibrated, CalibrationError> {
    check_interval(interval_s)?;
    // What an earlier calibration states is measured anew.
    let config = HostConfig { calibrated: None, ..config.clone() };
    let pipeline = replay::pipeline_config(recording, &config, true);
    let scenes = scenes(recording, pipeline)?;
    if recording.channels.stylus == StylusKind::Absent {
        let array = ArrayCalibration {
            sample_rate_hz: pipeline.sample_rate.0,
            taxels: taxels_alone(recording, &pipeline, &scenes.moving)?,
        };
        return Ok(Calibrated {
            calibration: Calibration::Array(array),
            certified: Err(NotCertified::Array),
        });
    }
    let rest = rest_floor(recording, &pipeline, &scenes)?;
    let Motion { gain, seconds: motion_s, reference } =
        gate(recording, pipeline, &scenes.moving, &rest.floor)?;
    let left_out = rest.unexplained.iter().filter(|u| **u).count() as u64;
    let mut calibration = StylusCalibration {
        sample_rate_hz: pipeline.sample_rate.0,
        vibration: recording.channels.stylus == StylusKind::Vibration,
        floor: rest.floor,
        reference_floor: scenes.reference_floor,
        gain,
        slack_still: pipeline.detector.slack_still,
        slack_moving: pipeline.detector.slack_moving,
        evidence: Evidence {
            wanted_interval_s: interval_s,
            rest_s: rest.seconds,
            unexplained_s: seconds_of(left_out, &pipeline),
            unexplained_longest: longest(recording, &rest.unexplained),
            motion_s,
            unsteady: rest.unsteady,
            seen: 0,
            judged_s: 0.0,
            alarms: 0,
            interval_low_s: 0.0,
            smallest_rest: None,
            smallest_motion: None,
        },
        certificate: None,
        certified: None,
        taxels: taxels::at_rest(recording, &pipeline.pressure, &scenes.moving),
    };
    let (blocks, certified) = listen(recording, &calibration, pipeline)?;
    (calibration.certificate, calibration.certified) = certified.as_ref().ok().copied().unzip();
    set_slack(&mut calibration, &blocks, recording, &config)?;
    blocks.judge(&mut calibration);
    let sum = blocks.sum(&calibration);
    let [still, moving] = [false, true].map(|moving| sum.smallest(moving, Evidence::WITHIN_S));
    calibration.set_smallest(&still, &moving, &reference);
    let calibration = Calibration::Stylus(calibration);
    Ok(Calibrated { calibration, certified: certified.map(|_| ()) })
}

/// What the taxels show where they are the only sensor, whose calibration is this alone.
fn taxels_alone(
    recording: &Recording,
    config: &PipelineConfig,
    moving: &[bool],
) -> Result<TaxelRest, CalibrationError> {
    if recording.taxels.is_none() {
        return Err(CalibrationError::NoSensor);
    }
    let held = taxels::held(recording, &config.pressure, moving);
    let (taxels, samples) = held.ok_or(CalibrationError::NoForce)?;
    let held_s = seconds_of(samples, config);
    if held_s < REST_S || taxels.rms <= 0.0 {
        return Err(CalibrationError::ShortArray { held_s, rms: taxels.rms });
    }
    Ok(taxels)
}

/// A sample as of a held object, whatever is between the fingers: an open hand has the same noise, and a detector does
/// not listen to it otherwise.
fn received(sample: &Sample) -> Sample {
    Sample { normal_force_n: None, ..*sample }
}

/// What goes on in a recording.
struct Scenes {
    /// Which samples lie in motion.
    moving: Vec<bool>,
    /// Which samples show nothing of the noise: the sensor is silent, or they come after a gap.
    lost: Vec<bool>,
    /// Energies of the reference at rest (unit squared).
    reference_floor: Option<[f32; 2]>,
}

/// Finds motion, checks that the stylus is alive, where there is one, and measures the reference at rest.
fn scenes(recording: &Recording, config: PipelineConfig) -> Result<Scenes, CalibrationError> {
    let mut pipeline = Bare::new(config, None)?;
    let mut reference_floor = None;
    if recording.channels.has(Channel::Reference) {
        // Known at the end, it shows motion from the first sample on.
        for sample in &recording.samples {
            pipeline.handle(&received(sample));
        }
        reference_floor = pipeline.detector().reference_floor();
        let known_reference = reference_floor;
        pipeline = Bare::new(PipelineConfig { known_reference, ..config }, None)?;
    }
    let gap_s = health::gap(config.sample_rate).as_seconds();
    let mut found = Scenes { moving: Vec::new(), lost: Vec::new(), reference_floor };
    let (mut silent, mut health) = (0_u64, SensorHealth::Good);
    let mut last_s = f64::INFINITY;
    for sample in &recording.samples {
        let now = pipeline.handle(&received(sample)).sensors[0];
        let is_silent =
            matches!(now, SensorHealth::Failed | SensorHealth::Saturated | SensorHealth::Frozen)
                || !sample.stylus.is_finite();
        if is_silent {
            (silent, health) = (silent + 1, now);
        }
        let t_s = sample.t.as_seconds();
        found.lost.push(is_silent || t_s - last_s > gap_s);
        found.moving.push(pipeline.detector().is_moving());
        last_s = t_s;
    }
    let samples = recording.samples.len() as u64;
    let stylus = recording.channels.stylus != StylusKind::Absent;
    if stylus && silent as f64 > MOST_LOST * samples as f64 {
        return Err(CalibrationError::Unhealthy { lost: silent, samples, health: health.name() });
    }
    Ok(found)
}

#[expect(clippy::cast_precision_loss, reason = "a count of samples")]
fn seconds_of(samples: u64, config: &PipelineConfig) -> f64 {
    samples as f64 / f64::from(config.sample_rate.0)
}

/// Energy of the bands over the samples that are wanted, the filters started afresh after each that is not; `each` sees it
/// after every sample.
fn measure(
    config: &PipelineConfig,
    samples: impl Iterator<Item = (Vector, bool)>,
    mut each: impl FnMut(&mut RestMeter),
) -> Result<RestMeter, ConfigError> {
    let mut meter = RestMeter::new(&config.detector, config.sample_rate.0)?;
    let mut within = false;
    for (value, wanted) in samples {
        if wanted && !within {
            meter.start();
        }
        within = wanted;
        if wanted {
            meter.push_vector(value);
            each(&mut meter);
        }
    }
    Ok(meter)
}

/// The readings of the stylus without isolated wrong ones, as the detector gets them.
fn guarded(recording: &Recording, config: &PipelineConfig) -> impl Iterator<Item = Vector> {
    let mut guard = Guard::new(config.sample_rate);
    recording.samples.iter().map(move |sample| {
        let reading = sample.vibration();
        guard.step(reading).unwrap_or(reading)
    })
}

/// What the rest shows.
struct Rest {
    floor: [f32; BANDS],
    /// How much of it the floor stands on (s).
    seconds: f64,
    unsteady: f32,
    /// Samples of the rest that are left out.
    unexplained: Vec<bool>,
}

fn rest_floor(
    recording: &Recording,
    config: &PipelineConfig,
    scenes: &Scenes,
) -> Result<Rest, CalibrationError> {
    let rest: Vec<(Vector, bool)> = guarded(recording, config)
        .zip(scenes.moving.iter().zip(&scenes.lost))
        .map(|(value, (moving, lost))| (value, !moving && !lost))
        .collect();
    let rest = quiet::without_edges(config, &rest);
    let meter = measure(config, rest.iter().copied(), |_| ())?;
    let seconds = seconds_of(meter.samples(), config);
    let Some(floor) = meter.floor(config.floor).filter(|_| seconds >= REST_S) else {
        return Err(CalibrationError::Short { rest_s: seconds });
    };
    let parts = quiet::parts(config, &rest, meter.samples())?;
    let least = meter.least_energy(config.floor);
    let ratio = |sorted: &Vec<f32>| {
        sorted.first().zip(sorted.last()).map_or(1.0, |(low, high)| high / low.max(least))
    };
    let unsteady = parts.iter().map(ratio).fold(1.0, f32::max);
    let mut unexplained = vec![false; rest.len()];
    if unsteady <= STEADY {
        return Ok(Rest { floor, seconds, unsteady, unexplained });
    }
    let usual = parts.map(|sorted| sorted.get(sorted.len() / 4).map_or(least, |e| e.max(least)));
    unexplained = quiet::loud(config, &rest, &usual)?;
    let quiet = rest.iter().zip(&unexplained).map(|((v, rests), loud)| (*v, *rests && !loud));
    let meter = measure(config, quiet, |_| ())?;
    let quiet_s = seconds_of(meter.samples(), config);
    let (floor, seconds) = match meter.floor(config.floor) {
        Some(quiet) if quiet_s >= QUIET_S => (quiet, quiet_s),
        _ => (floor, seconds),
    };
    Ok(Rest { floor, seconds, unsteady, unexplained })
}

/// Begin and length (s) of the longest stretch of `unexplained`.
fn longest(recording: &Recording, unexplained: &[bool]) -> Option<[f64; 2]> {
    let pairs: Vec<(&Sample, &bool)> = recording.samples.iter().zip(unexplained).collect();
    let stretches = pairs.chunk_by(|a, b| a.1 == b.1).filter(|part| part.iter().any(|(_, u)| **u));
    let spans = stretches.filter_map(|part| {
        let (first, last) = (part.first()?.0.t.as_seconds(), part.last()?.0.t.as_seconds());
        Some([first, last - first])
    });
    spans.max_by(|a, b| a[1].total_cmp(&b[1]))
}

/// What the robot's motion shows.
struct Motion {
    gain: Option<[f32; BANDS]>,
    seconds: f64,
    /// Mean energies of the reference (unit squared).
    reference: [f32; BANDS],
}

fn gate(
    recording: &Recording,
    config: PipelineConfig,
    moving: &[bool],
    floor: &[f32; BANDS],
) -> Result<Motion, CalibrationError> {
    let pairs = || recording.samples.iter().zip(moving.iter().copied());
    let values = guarded(recording, &config).zip(moving.iter().copied());
    let stylus = measure(&config, values, |_| ())?;
    let reference = measure(
        &config,
        pairs()
            .map(|(s, m)| (s.reference_vector().unwrap_or_default(), m && s.reference.is_some())),
        |_| (),
    )?;
    let motion_s = seconds_of(reference.samples(), &config);
    let (Some(stylus), Some(reference)) = (stylus.energy(), reference.energy()) else {
        return Ok(Motion { gain: None, seconds: 0.0, reference: [0.0; BANDS] });
    };
    if motion_s < MOTION_S {
        return Ok(Motion { gain: None, seconds: motion_s, reference });
    }
    let gain = core::array::from_fn(|b| {
        MARGIN * (stylus[b] - floor[b]).max(0.1 * floor[b]) / reference[b].max(f32::MIN_POSITIVE)
    });
    Ok(Motion { gain: Some(gain), seconds: motion_s, reference })
}

/// Runs the detector with what is known over the recording, as of a held object: its blocks, and what they certify.
#[expect(
    clippy::type_complexity,
    reason = "a certificate with what it stands on, or why there is none"
)]
fn listen(
    recording: &Recording,
    calibration: &StylusCalibration,
    config: PipelineConfig,
) -> Result<(DecidedBlocks, Result<(Certificate, Certified), NotCertified>), CalibrationError> {
    // Scores are measured, and nothing is certified.
    let nothing = Certificate { interval_s: 1e9, rest: None, motion: None };
    let known = Calibration::Stylus(*calibration).apply(config);
    let mut pipeline = Bare::new(PipelineConfig { certificate: Some(nothing), ..known }, None)?;
    let mut blocks =
        DecidedBlocks::new(config, seconds_of(recording.samples.len() as u64, &config))?;
    let mut scores = ScoreLog::default();
    for sample in &recording.samples {
        pipeline.handle(&received(sample));
        let at_s = sample.t.as_seconds();
        blocks.push(pipeline.detector(), at_s);
        scores.push(pipeline.detector(), at_s);
    }
    let detector = pipeline.detector();
    let base_s = detector.base_block_s().map_or(0.0, f64::from);
    let interval_s = calibration.evidence.wanted_interval_s;
    let certified = certify(&scores.stretches, base_s, detector.has_bands(), interval_s);
    Ok((blocks, certified))
}

/// Sets the slack, and raises it as long as that leaves fewer slips in a replay of the recording.
fn set_slack(
    calibration: &mut StylusCalibration,
    blocks: &DecidedBlocks,
    recording: &Recording,
    config: &HostConfig,
) -> Result<(), CalibrationError> {
    let raises = if blocks.decides() {
        blocks.fit(calibration);
        RAISES
    } else {
        0
    };
    let mut best: Option<(u64, StylusCalibration)> = None;
    let mut tried = *calibration;
    for _ in 0..=raises {
        let (seen, held) = slips(recording, config, tried)?;
        tried.evidence.seen = seen;
        if best.is_none_or(|(least, _)| seen + held < least) {
            best = Some((seen + held, tried));
        }
        if seen + held == 0 {
            break;
        }
        blocks.raise(&mut tried);
    }
    *calibration = best.map_or(*calibration, |(_, tried)| tried);
    Ok(())
}

/// Slips that a replay of the recording with `calibration` shows, and where it has a grip force those of an object
/// that is held all the time.
fn slips(
    recording: &Recording,
    config: &HostConfig,
    calibration: StylusCalibration,
) -> Result<(u64, u64), CalibrationError> {
    let config =
        HostConfig { calibrated: Some(Calibration::Stylus(calibration)), ..config.clone() };
    let pipeline = replay::pipeline_config(recording, &config, false);
    let begins = |step: &Step| step.event.as_ref().is_some_and(|slip| slip.first);
    let replayed = Replay::new(recording, pipeline, default_estimator().ok())?;
    let seen = replayed.filter(begins).count() as u64;
    if !recording.channels.has(Channel::NormalForce) {
        return Ok((seen, 0));
    }
    let mut held = Bare::new(PipelineConfig { grip: None, ..pipeline }, None)?;
    let steps = recording.samples.iter().map(|sample| held.handle(&received(sample)));
    Ok((seen, steps.filter(begins).count() as u64))
}

/// The base blocks of a recording, by stretch.
#[derive(Debug, Default)]
struct ScoreLog {
    stretches: Vec<Stretch>,
    /// Number and time (s) of the last one.
    last: Option<(u64, f64)>,
}

impl ScoreLog {
    fn push(&mut self, detector: &SlipDetector, at_s: f64) {
        let (Some(new), Some(base_s)) = (detector.scores(), detector.base_block_s()) else {
            return;
        };
        if self.last.is_some_and(|(number, _)| number == new.number) {
            return;
        }
        let soon = self.last.is_some_and(|(_, t_s)| at_s - t_s < 1.5 * f64::from(base_s));
        self.last = Some((new.number, at_s));
        match self.stretches.last_mut().filter(|stretch| soon && stretch.moving == new.moving) {
            Some(stretch) => stretch.scores.push(new.scores),
            None => {
                self.stretches.push(Stretch { moving: new.moving, scores: vec![new.scores] });
            }
        }
    }
}

#[cfg(test)]
mod tests;
