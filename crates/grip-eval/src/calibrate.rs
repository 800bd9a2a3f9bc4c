//! A recording without any slip in; the noise floor, the motion gate and the thresholds for a wanted false-alarm interval out.
//!
//! 1. Floor: mean energy of each band while the reference shows no motion (all of it, where there is no reference).
//!    Where that is not stationary, the edges of motions and what is loud are left out (`quiet`); what is loud counts
//!    as unexplained, for the thresholds too, and may be a tenth of the rest at most; none of it that is longer than a
//!    knock may go on in motion, where it cannot be distinguished from motion.
//! 2. Gate: mean energy of each band in motion, floor taken off, over that of the reference, times one half.
//! 3. Thresholds: with the two in force, the highest level of each test in each second. The tail above its 90 % quantile is
//!    continued to the wanted interval ([`tail`](crate::tail)). Each test gets an equal share of the alarms.
//! 4. What was achieved: thresholds from one half of the seconds, alarms counted on the other half, both ways. The rate is
//!    quoted with its Poisson interval and never beyond the length of the recording.
//! 5. Certificate: limits and chances of the alarm whose interval holds for every law of the noise ([`certify`](crate::certify)).

mod quiet;

use crate::{
    certify::{NotCertified, Stretch, certify},
    poisson,
    tail::Tail,
    taxels,
};
use grip_record::{Channel, Recording, StylusKind};
use grip_session::{
    calibration::{
        ArrayCalibration, Calibration, Certified, Evidence, StylusCalibration, TaxelRest,
    },
    config::HostConfig,
    replay,
};
use slip_core::{
    ConfigError, Pipeline, PipelineConfig, Sample,
    alarm::TAIL_RANGE,
    detector::{BANDS, Certificate, DetectorConfig, RestMeter, SlipDetector},
    health::SensorHealth,
    isolated::Guard,
    sample::Vector,
};

/// Times the mean ratio of motion at stylus and reference that the gate takes for granted; the thresholds stand on top of it.
const MARGIN: f32 = 0.5;
/// Rest that is needed (s).
const REST_S: f64 = 5.0;
/// Motion that is needed to set the gate (s).
const MOTION_S: f64 = 5.0;
/// Parts of the rest that have to agree in energy, and the factor within which they have to.
const PARTS: usize = 8;
const STATIONARY: f32 = 3.0;
/// What follows an unexplained stretch within this time (s) belongs to it.
const AFTER_S: f64 = 1.0;
/// Largest share of the rest that may be left out as unexplained.
const MOST_UNEXPLAINED: f64 = 0.1;
/// Share of unusable readings above which a stylus is not healthy.
const UNUSABLE: f64 = 1e-3;
/// Start in which the floor is learned to distinguish rest from motion (s).
const START_S: f64 = 1.5;
/// Tests that have a threshold: the energy of each band and the cumulative sum.
const TESTS: usize = BANDS + 1;
/// No threshold is set below this; where the recording had too little motion, none below its default, since motion may do what rest
/// does not.
const LEAST: f32 = 4.0;
/// No interval is claimed beyond the length of the signal over this: -ln 0.05.
const CLAIMED: f64 = 3.0;

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
        "{rest_s:.1} s of rest is too short for a floor; record at least {REST_S} s without slip and without motion"
    )]
    Short {
        /// Rest found (s).
        rest_s: f64,
    },
    /// The stylus failed, or too many readings were unusable.
    #[error(
        "the stylus is not healthy: {unusable} of {samples} readings unusable, health `{health}`"
    )]
    Unhealthy {
        /// Unusable readings.
        unusable: u64,
        /// All readings.
        samples: u64,
        /// The worst state seen.
        health: &'static str,
    },
    /// The noise changes while it is measured.
    #[error(
        "the noise is not stationary: in band {band} (0 shear, 1 vibration) one eighth of the rest has {ratio:.1} times the energy of another, and {unexplained_s:.1} s of it are loud without motion of the reference. Something moved or slipped, or the sensor is unsound"
    )]
    Unsteady {
        /// The band.
        band: usize,
        /// Largest over smallest energy.
        ratio: f32,
        /// Rest that is loud (s): more than a tenth of it, or it goes on in motion, or is not all that is wrong.
        unexplained_s: f64,
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
    let pipeline = replay::pipeline_config(recording, config, true);
    let moving = motion(recording, pipeline)?;
    if recording.channels.stylus == StylusKind::Absent {
        let array = ArrayCalibration {
            sample_rate_hz: pipeline.sample_rate.0,
            taxels: taxels_alone(recording, &pipeline, &moving)?,
        };
        return Ok(Calibrated {
            calibration: Calibration::Array(array),
            certified: Err(NotCertified::Array),
        });
    }
    let Rest { floor, rest_s, unexplained } = rest_floor(recording, pipeline, &moving)?;
    let Motion { gain, seconds: motion_s, reference } = gate(recording, pipeline, &moving, &floor)?;
    let mut calibration = StylusCalibration {
        sample_rate_hz: pipeline.sample_rate.0,
        vibration: recording.channels.stylus == StylusKind::Vibration,
        floor,
        reference_floor: recording
            .channels
            .has(Channel::Reference)
            .then(|| reference_floor(recording, pipeline))
            .transpose()?
            .flatten(),
        gain,
        thresholds: [1e9; BANDS],
        cusum_threshold: 1e9,
        tail: None,
        evidence: Evidence {
            wanted_interval_s: interval_s,
            rest_s,
            unexplained_s: seconds_of(unexplained.iter().filter(|u| **u).count() as u64, &pipeline),
            unexplained_longest: longest(recording, &unexplained),
            motion_s,
            judged_s: 0.0,
            alarms: 0,
            interval_low_s: 0.0,
            interval_high_s: None,
            extrapolation: 0.0,
            claimed_s: None,
            smallest_rest: None,
            smallest_motion: None,
        },
        certificate: None,
        certified: None,
        taxels: taxels::at_rest(recording, &pipeline.pressure, &moving),
    };
    let known = Calibration::Stylus(calibration).apply(pipeline);
    let received = listen(recording, known, interval_s, &unexplained)?;
    let seconds = received.seconds;
    let defaults = thresholds_of(&pipeline.detector);
    set_thresholds(&mut calibration, &seconds, &defaults);
    calibration.set_smallest(&reference);
    let certified = received.certified;
    (calibration.certificate, calibration.certified) = certified.as_ref().ok().copied().unzip();
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

/// A sample as of a held object, whatever is between the fingers: an open hand has the same noise, and a detector does not listen to
/// it otherwise.
fn received(sample: &Sample) -> Sample {
    Sample { normal_force_n: None, ..*sample }
}

/// Which samples lie in motion. Checks the health of the stylus, where there is one, on the way.
fn motion(recording: &Recording, config: PipelineConfig) -> Result<Vec<bool>, CalibrationError> {
    let mut pipeline = Bare::new(config, None)?;
    let mut worst = SensorHealth::Good;
    let moving = recording
        .samples
        .iter()
        .map(|sample| {
            let step = pipeline.handle(&received(sample));
            if step.sensors[0] != SensorHealth::Good {
                worst = step.sensors[0];
            }
            pipeline.detector().is_moving()
        })
        .collect();
    let counters = pipeline.health_counters();
    let samples = recording.samples.len() as u64;
    #[expect(clippy::cast_precision_loss, reason = "a count")]
    let share = counters.unusable() as f64 / samples.max(1) as f64;
    let stylus = recording.channels.stylus != StylusKind::Absent;
    if stylus && (worst != SensorHealth::Good || share > UNUSABLE) {
        let unusable = counters.unusable();
        return Err(CalibrationError::Unhealthy { unusable, samples, health: worst.name() });
    }
    Ok(moving)
}

#[expect(clippy::cast_precision_loss, reason = "a count of samples")]
fn seconds_of(samples: u64, config: &PipelineConfig) -> f64 {
    samples as f64 / f64::from(config.sample_rate.0)
}

/// Energy of the bands of `value` over the samples that `wanted` picks; restarted at every gap.
fn measure<'a>(
    config: &PipelineConfig,
    samples: impl Iterator<Item = (Vector, bool)> + 'a,
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
    rest_s: f64,
    /// Samples of the rest that are left out.
    unexplained: Vec<bool>,
}

fn rest_floor(
    recording: &Recording,
    config: PipelineConfig,
    moving: &[bool],
) -> Result<Rest, CalibrationError> {
    let rest: Vec<(Vector, bool)> =
        guarded(recording, &config).zip(moving).map(|(value, moving)| (value, !moving)).collect();
    let unsteady = match steady_floor(&config, &rest) {
        Err(CalibrationError::Unsteady { band, ratio, .. }) => (band, ratio),
        other => {
            let (floor, rest_s) = other?;
            return Ok(Rest { floor, rest_s, unexplained: vec![false; rest.len()] });
        }
    };
    let still = quiet::without_edges(&config, &rest);
    let unexplained = quiet::loud(&config, &still)?;
    let seconds = |mask: &mut dyn Iterator<Item = bool>| {
        seconds_of(mask.filter(|is| *is).count() as u64, &config)
    };
    let unexplained_s = seconds(&mut unexplained.iter().copied());
    let refused = |(band, ratio)| CalibrationError::Unsteady { band, ratio, unexplained_s };
    let much =
        unexplained_s > MOST_UNEXPLAINED * seconds(&mut still.iter().map(|(_, rests)| *rests));
    // A slip that goes on in motion would raise the thresholds there.
    if much || quiet::goes_on(&config, &still, &unexplained) {
        return Err(refused(unsteady));
    }
    let quiet: Vec<(Vector, bool)> = still
        .iter()
        .zip(&unexplained)
        .map(|((value, rests), loud)| (*value, *rests && !loud))
        .collect();
    match steady_floor(&config, &quiet) {
        Err(CalibrationError::Unsteady { band, ratio, .. }) => Err(refused((band, ratio))),
        other => other.map(|(floor, rest_s)| Rest { floor, rest_s, unexplained }),
    }
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

/// Energy of the bands at rest (signal unit squared) and how much of it there is (s), where its eighths agree.
fn steady_floor(
    config: &PipelineConfig,
    rest: &[(Vector, bool)],
) -> Result<([f32; BANDS], f64), CalibrationError> {
    let meter = measure(config, rest.iter().copied())?;
    let rest_s = seconds_of(meter.samples(), config);
    let Some(floor) = meter.floor(config.floor).filter(|_| rest_s >= REST_S) else {
        return Err(CalibrationError::Short { rest_s });
    };
    let mut range = [(f32::INFINITY, 0.0_f32); BANDS];
    for part in rest.chunks(rest.len().div_ceil(PARTS).max(1)) {
        let part = measure(config, part.iter().copied())?;
        // An eighth that is nearly all motion shows nothing about rest.
        if seconds_of(part.samples(), config) < 0.1 * REST_S {
            continue;
        }
        for (range, energy) in range.iter_mut().zip(part.energy().unwrap_or(floor)) {
            *range = (range.0.min(energy), range.1.max(energy));
        }
    }
    let least = meter.least_energy(config.floor);
    for (band, (low, high)) in range.into_iter().enumerate() {
        let ratio = high / low.max(least);
        if ratio > STATIONARY {
            return Err(CalibrationError::Unsteady { band, ratio, unexplained_s: 0.0 });
        }
    }
    Ok((floor, rest_s))
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
    let stylus = measure(&config, guarded(recording, &config).zip(moving.iter().copied()))?;
    let reference = measure(
        &config,
        pairs()
            .map(|(s, m)| (s.reference_vector().unwrap_or_default(), m && s.reference.is_some())),
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

fn reference_floor(
    recording: &Recording,
    config: PipelineConfig,
) -> Result<Option<[f32; 2]>, CalibrationError> {
    let mut pipeline = Bare::new(config, None)?;
    recording.samples.iter().for_each(|sample| {
        pipeline.handle(&received(sample));
    });
    Ok(pipeline.detector().reference_floor())
}

/// What the tests show in a recording without slip.
struct Received {
    /// Highest level of each test in each second.
    seconds: Vec<[f32; TESTS]>,
    certified: Result<(Certificate, Certified), NotCertified>,
}

fn listen(
    recording: &Recording,
    config: PipelineConfig,
    interval_s: f64,
    unexplained: &[bool],
) -> Result<Received, CalibrationError> {
    // Scores are measured, and nothing is certified.
    let nothing = Certificate { interval_s: 1e9, rest: None, motion: None };
    let config = PipelineConfig { certificate: Some(nothing), ..config };
    let mut pipeline = Bare::new(config, None)?;
    let mut seconds: Vec<[f32; TESTS]> = Vec::new();
    let mut scores = ScoreLog::default();
    let first = recording.samples.first().map_or(0.0, |s| s.t.as_seconds());
    let mut unexplained_at = f64::NEG_INFINITY;
    for (sample, unexplained) in recording.samples.iter().zip(unexplained) {
        pipeline.handle(&received(sample));
        let at = sample.t.as_seconds() - first - START_S;
        if *unexplained {
            unexplained_at = at;
        }
        if at < 0.0 || at - unexplained_at < AFTER_S {
            continue;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count of seconds"
        )]
        let place = at as usize;
        seconds.resize(seconds.len().max(place + 1), [0.0; TESTS]);
        scores.push(pipeline.detector(), at);
        let levels = pipeline.detector().levels();
        let moving = pipeline.detector().is_moving();
        let Some(most) = seconds.get_mut(place) else { continue };
        let now = levels.energy.into_iter().chain([levels.cusum]).enumerate();
        for (most, (test, level)) in most.iter_mut().zip(now) {
            if test < 2 || moving {
                *most = most.max(level);
            }
        }
    }
    // Seconds of which nothing counts.
    seconds.retain(|second| second.iter().any(|level| *level > 0.0));
    let detector = pipeline.detector();
    let base_s = detector.base_block_s().map_or(0.0, f64::from);
    let certified = certify(&scores.stretches, base_s, detector.has_bands(), interval_s);
    Ok(Received { seconds, certified })
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

/// The threshold of each test.
fn thresholds_of(detector: &DetectorConfig) -> [f32; TESTS] {
    let [shear, vibration, a, b, c, d] = detector.bands().map(|band| band.threshold);
    [shear, vibration, a, b, c, d, detector.cusum_threshold]
}

fn set_thresholds(
    calibration: &mut StylusCalibration,
    seconds: &[[f32; TESTS]],
    defaults: &[f32; TESTS],
) {
    let interval_s = calibration.evidence.wanted_interval_s;
    let moved = calibration.gain.is_some();
    let thresholds = |seconds: &[[f32; TESTS]]| thresholds(seconds, interval_s, defaults, moved);
    let half = |odd: usize| -> Vec<[f32; TESTS]> {
        seconds.iter().enumerate().filter(|(i, _)| i % 2 == odd).map(|(_, s)| *s).collect()
    };
    let exceeds =
        |s: &&[f32; TESTS], limits: &[f32; TESTS]| s.iter().zip(limits).any(|(x, h)| x > h);
    let mut alarms = 0;
    for (made, judged) in [(half(0), half(1)), (half(1), half(0))] {
        let limits = thresholds(&made);
        alarms += judged.iter().filter(|s| exceeds(s, &limits)).count() as u64;
    }
    let limits = thresholds(seconds);
    calibration.tail = statistic_tail(seconds, &limits);
    if let Some((cusum, bands)) = limits.split_last() {
        calibration.cusum_threshold = *cusum;
        calibration.thresholds.copy_from_slice(bands);
    }
    #[expect(clippy::cast_precision_loss, reason = "a count of seconds")]
    let judged_s = seconds.len() as f64;
    let (low, high) = poisson::interval(alarms, 0.95);
    let evidence = &mut calibration.evidence;
    evidence.judged_s = judged_s;
    evidence.alarms = alarms;
    evidence.interval_low_s = judged_s / high;
    evidence.interval_high_s = (alarms > 0).then(|| judged_s / low);
    evidence.claimed_s = Some(interval_s.min(judged_s / CLAIMED));
    #[expect(clippy::cast_precision_loss, reason = "7")]
    let tests = TESTS as f64;
    evidence.extrapolation = tests * interval_s / judged_s.max(1.0);
}

/// Peaks of a test in rising order, from the seconds in which it was received.
fn peaks(seconds: &[[f32; TESTS]], test: usize) -> Vec<f32> {
    let mut peaks: Vec<f32> =
        seconds.iter().filter_map(|s| s.get(test).copied()).filter(|x| *x > 0.0).collect();
    peaks.sort_by(f32::total_cmp);
    peaks
}

/// The level of each test that the peaks of single seconds exceed once in [`TESTS`] times `interval_s`; where nothing `moved`, at least its
/// default.
fn thresholds(
    seconds: &[[f32; TESTS]],
    interval_s: f64,
    defaults: &[f32; TESTS],
    moved: bool,
) -> [f32; TESTS] {
    #[expect(clippy::cast_precision_loss, reason = "7")]
    let wanted_s = TESTS as f64 * interval_s;
    core::array::from_fn(|test| {
        let peaks = peaks(seconds, test);
        let level = match (tail_of(&peaks, seconds.len()), peaks.last()) {
            (Some(tail), _) => tail.level(wanted_s),
            // Too few for a tail.
            (None, Some(highest)) => 2.0 * highest,
            (None, None) => defaults[test],
        };
        level.max(if moved { LEAST } else { defaults[test] })
    })
}

/// The tail above the 90 % quantile.
fn tail_of(peaks: &[f32], seconds: usize) -> Option<Tail> {
    Tail::of(peaks, peaks.len() / 10, seconds)
}

/// The tail index of what decides, the highest level over its threshold.
fn statistic_tail(seconds: &[[f32; TESTS]], limits: &[f32; TESTS]) -> Option<f32> {
    let statistic = |second: &[f32; TESTS]| {
        second.iter().zip(limits).map(|(level, limit)| level / limit).fold(0.0, f32::max)
    };
    let mut peaks: Vec<f32> = seconds.iter().map(statistic).filter(|x| *x > 0.0).collect();
    peaks.sort_by(f32::total_cmp);
    #[expect(clippy::cast_possible_truncation, reason = "limited to the range of a tail")]
    let index = tail_of(&peaks, seconds.len())?.careful_index() as f32;
    Some(index.clamp(TAIL_RANGE.0, TAIL_RANGE.1))
}

#[cfg(test)]
mod tests;
