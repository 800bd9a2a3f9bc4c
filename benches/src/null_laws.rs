//! Noise of several laws without slip, and slips on it in; false alarms of the fast trigger and of the certified alarm,
//! and both delays, out.

use grip_eval::calibrate::{Calibrated, CalibrationError, calibrate};
use grip_record::{Channel, ChannelSet, Notes, Recording, StylusKind};
use grip_session::{HostConfig, replay};
use grip_sim::disturbance::Disturbance;
use rand_chacha::ChaCha8Rng;
use rand_core::SeedableRng;
use rand_distr::{Distribution, Exp1, StandardNormal, StandardUniform, StudentT};
use slip_core::{
    ConfigError, Phase, Pipeline, PipelineConfig, Sample, Signal, SlipReport,
    units::{Hertz, Micros},
};

/// Samples per second (Hz).
pub const RATE_HZ: f64 = 2000.0;
/// Length of a burst (s), and their share of the time.
const BURST_S: f64 = 0.005;
const BURST_SHARE: f64 = 0.02;
const BURST_ENERGY: f64 = 20.0;
/// Mean time with and without hum (s), its size (noise rms) and frequency (Hz).
const HUM_ON_S: f64 = 2.0;
const HUM_OFF_S: f64 = 4.0;
const HUM_RMS: f64 = 1.5;
const HUM_HZ: f64 = 50.0;
/// Time in which the energy drifts four times up and back (s).
const DRIFT_S: f64 = 120.0;
const DRIFT_ENERGY: f64 = 4.0;
/// What a coloured reading keeps of the one before.
const COLOUR: f64 = 0.95;
/// Size of a spike (noise rms): from the first to the second, a factor at random; one a second on average.
const SPIKE_RMS: [f64; 2] = [8.0, 64.0];
/// Sensor noise of the robot (m, rms).
const ROBOT_NOISE_M: f64 = 1e-7;
/// A slip, and the mean pause before it (s).
const SLIP_S: f64 = 0.3;
const PAUSE_S: f64 = 1.0;

slip_msg::named! {
    /// A law of the noise.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Law {
        fn name: "Its name.";
    }
    Gaussian: "White and Gaussian.", "Gaussian";
    StudentT3: "White, of Student's distribution with 3 degrees of freedom: energies are squares of it.", "squared t3";
    Bursts: "Gaussian with spells of 5 ms, 2 % of the time, that have 20 times the energy.", "2 % bursts x 20";
    Hum: "Gaussian, and mains hum with its third harmonic that comes for 2 s and goes for 4 s on average.", "hum that comes and goes";
    Drift: "Gaussian, with an energy that drifts four times up and back in two minutes.", "drift x 4 in 120 s";
    Coloured: "Gaussian, each reading with 0.95 of the one before.", "coloured, 0.95";
    Spikes: "Gaussian, with one wrong reading a second of 8 to 64 deviations.", "isolated spikes";
    Robot: "Gaussian, on a robot that moves half of the time, with a motion reference and a tap in 5 s; another robot with each seed.",
        "robot that moves by turns";
}

/// A signal of one law, with or without a slip.
#[derive(Debug)]
pub struct Noise {
    law: Law,
    random: ChaCha8Rng,
    student: Option<StudentT<f64>>,
    robot: Disturbance,
    /// Samples until the state changes, and whether it is loud.
    left: u64,
    loud: bool,
    phase: f64,
    count: u64,
    /// The coloured reading before.
    before: f64,
}

impl Noise {
    /// A signal from its beginning.
    #[must_use]
    pub fn new(law: Law, seed: u64) -> Self {
        let student = StudentT::new(3.0).ok();
        let random = ChaCha8Rng::seed_from_u64(seed);
        let robot = Disturbance::new(1.0, 0.2, RATE_HZ, seed);
        Self {
            law,
            random,
            student,
            robot,
            left: 0,
            loud: false,
            phase: 0.0,
            count: 0,
            before: 0.0,
        }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some seconds")]
    fn spell(&mut self, mean_s: f64) -> u64 {
        let length: f64 = Exp1.sample(&mut self.random);
        (length * mean_s * RATE_HZ).ceil() as u64
    }

    /// The next sample, with a slip of `slip` times the mean energy of the noise (of the robot: at rest).
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a signal in f32")]
    pub fn sample(&mut self, slip: f64) -> Sample {
        if self.left == 0 {
            self.loud = !self.loud;
            self.left = match (self.law, self.loud) {
                (Law::Bursts, true) => (BURST_S * RATE_HZ) as u64,
                (Law::Bursts, false) => self.spell(BURST_S * (1.0 - BURST_SHARE) / BURST_SHARE),
                (_, true) => self.spell(HUM_ON_S),
                (_, false) => self.spell(HUM_OFF_S),
            };
        }
        self.left = self.left.saturating_sub(1);
        let (noise, energy) = match (self.law, self.student) {
            // The variance of Student's t is 3 with 3 degrees of freedom.
            (Law::StudentT3, Some(student)) => (student.sample(&mut self.random), 3.0),
            (Law::Bursts, _) => {
                let size = if self.loud { BURST_ENERGY.sqrt() } else { 1.0 };
                (size * self.normal(), 1.0 + BURST_SHARE * (BURST_ENERGY - 1.0))
            }
            (Law::Hum, _) => (self.normal() + self.hum(), 1.0),
            (Law::Drift, _) => {
                let turn = core::f64::consts::TAU * self.count as f64 / (DRIFT_S * RATE_HZ);
                (DRIFT_ENERGY.powf(0.25 * (1.0 - turn.cos())) * self.normal(), 1.0)
            }
            (Law::Coloured, _) => {
                self.before = COLOUR * self.before + self.normal();
                (self.before, 1.0 / (1.0 - COLOUR * COLOUR))
            }
            (Law::Spikes, _) => (self.normal() + self.spike(), 1.0),
            _ => (self.normal(), 1.0),
        };
        let moved = if slip > 0.0 { (slip * energy).sqrt() * self.normal() } else { 0.0 };
        self.count += 1;
        let t = Micros((self.count as f64 * 1e6 / RATE_HZ) as u64);
        let sample = Sample::stylus(t, (noise + moved) as f32);
        if self.law != Law::Robot {
            return sample;
        }
        // In units of its sensor noise.
        let motion = self.robot.next_sample();
        let [stylus, reference] = [motion.stylus_m, motion.reference_m].map(|m| m / ROBOT_NOISE_M);
        let stylus = (noise + moved + stylus) as f32;
        Sample { stylus, reference: Some(reference as f32), ..sample }
    }

    fn spike(&mut self) -> f64 {
        let [chance, size, sign]: [f64; 3] =
            core::array::from_fn(|_| StandardUniform.sample(&mut self.random));
        if chance * RATE_HZ > 1.0 {
            return 0.0;
        }
        let [least, most] = SPIKE_RMS;
        (least * (most / least).powf(size)).copysign(sign - 0.5)
    }

    fn hum(&mut self) -> f64 {
        self.phase = (self.phase + HUM_HZ / RATE_HZ).fract();
        let at = core::f64::consts::TAU * self.phase;
        let hum = core::f64::consts::SQRT_2 * HUM_RMS * (at.sin() + 0.3 * (3.0 * at).sin());
        if self.loud { hum } else { 0.0 }
    }
}

/// A calibration from the next `seconds` of `noise`, and the pipeline with it.
///
/// # Errors
/// Where the noise gives none.
pub fn calibrated(
    noise: &mut Noise,
    seconds: f64,
    interval_s: f64,
) -> Result<(Calibrated, PipelineConfig), CalibrationError> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an hour or so")]
    let count = (seconds * RATE_HZ) as u64;
    let mut channels = ChannelSet::new(StylusKind::Vibration);
    if noise.law == Law::Robot {
        let reference = Channel::Reference;
        channels.optional.insert(reference, reference.column().to_owned());
    }
    #[expect(clippy::cast_possible_truncation, reason = "2000")]
    let recording = Recording {
        name: noise.law.name().to_owned(),
        channels,
        samples: (0..count).map(|_| noise.sample(0.0)).collect(),
        taxels: None,
        rate_hz: RATE_HZ as f32,
        notes: Notes::default(),
    };
    let host = HostConfig::default();
    let made = calibrate(&recording, &host, interval_s)?;
    let host = HostConfig { calibrated: Some(made.calibration), ..host };
    Ok((made, replay::pipeline_config(&recording, &host, true)))
}

/// The shipped settings for such noise.
#[must_use]
pub fn shipped() -> PipelineConfig {
    #[expect(clippy::cast_possible_truncation, reason = "2000")]
    PipelineConfig::observing(Signal::Vibration, Hertz(RATE_HZ as f32))
}

/// False alarms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Alarms {
    /// Signal (h).
    pub hours: f64,
    /// Of the fast trigger.
    pub fast: u64,
    /// Certified.
    pub certified: u64,
}

/// Whether a step begins an alarm of the fast trigger, and whether it certifies one.
fn alarms_of(event: Option<SlipReport>, statistic: f32) -> (bool, bool) {
    match event {
        Some(SlipReport { first, phase, certified_s, .. }) if phase != Phase::Ended => {
            // A certified slip has the evidence of every method.
            (first && statistic > 1.0 && certified_s.is_none(), certified_s.is_some())
        }
        _ => (false, false),
    }
}

/// Counts the alarms in the next `hours` of `noise`, without slip.
///
/// # Errors
/// Where the settings are refused.
pub fn null_run(
    noise: &mut Noise,
    hours: f64,
    config: PipelineConfig,
) -> Result<Alarms, ConfigError> {
    let mut pipeline: Pipeline<&'static [f32]> = Pipeline::new(config, None)?;
    let mut alarms = Alarms { hours, ..Alarms::default() };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some hours")]
    let count = (hours * 3600.0 * RATE_HZ) as u64;
    let mut certified = false;
    for _ in 0..count {
        let step = pipeline.handle(&noise.sample(0.0));
        let (fast, now) = alarms_of(step.event, step.statistic);
        alarms.fast += u64::from(fast);
        // A slip that has been certified turns gross: one alarm.
        alarms.certified += u64::from(now && !certified);
        certified = match step.event {
            Some(SlipReport { phase: Phase::Ended, .. }) => false,
            _ => certified || now,
        };
    }
    Ok(alarms)
}

/// Delays of the two alarms (ms); `None` where there was none within the slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delays {
    /// Of the fast trigger.
    pub fast_ms: Option<f64>,
    /// Of the certified alarm.
    pub certified_ms: Option<f64>,
}

/// Slips on the next of `noise`, of `slip` times the mean energy of the noise, each of 0.3 s; those that begin under an alarm are left out.
///
/// # Errors
/// Where the settings are refused.
pub fn slips(
    noise: &mut Noise,
    count: usize,
    slip: f64,
    config: PipelineConfig,
) -> Result<Vec<Delays>, ConfigError> {
    let mut pipeline: Pipeline<&'static [f32]> = Pipeline::new(config, None)?;
    let mut delays = Vec::new();
    let mut under_alarm = false;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a second or so")]
    for _ in 0..count {
        let jitter: f64 = StandardUniform.sample(&mut noise.random);
        for _ in 0..(PAUSE_S * (0.5 + jitter) * RATE_HZ) as u64 {
            under_alarm = match pipeline.handle(&noise.sample(0.0)).event {
                Some(SlipReport { phase, .. }) => phase != Phase::Ended,
                None => under_alarm,
            };
        }
        let mut seen = Delays { fast_ms: None, certified_ms: None };
        let free = !under_alarm;
        for i in 1..=(SLIP_S * RATE_HZ) as u64 {
            let step = pipeline.handle(&noise.sample(slip));
            let at_ms = 1e3 * i as f64 / RATE_HZ;
            let (_, certified) = alarms_of(step.event, step.statistic);
            if step.statistic > 1.0 && !certified {
                seen.fast_ms = seen.fast_ms.or(Some(at_ms));
            }
            if certified {
                seen.certified_ms = seen.certified_ms.or(Some(at_ms));
            }
            under_alarm = match step.event {
                Some(SlipReport { phase, .. }) => phase != Phase::Ended,
                None => under_alarm,
            };
        }
        if free {
            delays.push(seen);
        }
    }
    Ok(delays)
}

#[cfg(test)]
mod tests {
    use super::{Law, Noise, calibrated, null_run, slips};

    /// Mean energies are those that the slips are measured by.
    #[test]
    fn laws_have_their_energy() {
        for (law, wanted, within) in [
            (Law::Gaussian, 1.0, 0.02),
            (Law::StudentT3, 3.0, 0.4),
            (Law::Bursts, 1.38, 0.05),
            (Law::Hum, 1.0 + 2.45 / 3.0, 0.4),
        ] {
            let mut noise = Noise::new(law, 5);
            let count = 400_000;
            let sum: f64 = (0..count).map(|_| f64::from(noise.sample(0.0).stylus).powi(2)).sum();
            let energy = sum / f64::from(count);
            assert!((energy - wanted).abs() < within, "{law:?}: {energy}");
            let sum: f64 = (0..count).map(|_| f64::from(noise.sample(9.0).stylus).powi(2)).sum();
            assert!(sum / f64::from(count) > 8.0, "{law:?}");
        }
    }

    #[test]
    fn a_clear_slip_is_certified_and_noise_is_not() {
        let mut noise = Noise::new(Law::Gaussian, 1);
        let (made, config) = calibrated(&mut noise, 60.0, 60.0).unwrap();
        assert_eq!(made.certified, Ok(()));
        let alarms = null_run(&mut noise, 0.05, config).unwrap();
        assert!(alarms.certified <= 8, "three minutes at one a minute: {alarms:?}");
        let delays = slips(&mut noise, 20, 100.0, config).unwrap();
        let found = delays.iter().filter(|d| d.certified_ms.is_some_and(|ms| ms < 60.0)).count();
        assert!(delays.len() >= 18 && found == delays.len(), "{delays:?}");
    }
}
