//! What a scene states of the gripper's sensors: which there are, their noise and their errors of scale.

use super::{Draw, table::settings};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Which optional sensors the gripper has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ChannelConfig {
    /// Normal force of one finger.
    pub force: bool,
    /// Moved distance of the object.
    pub travel: bool,
    /// Motion reference: a second stylus that touches nothing (m).
    pub reference: bool,
    /// Tangential force of one finger.
    pub tangential: bool,
}

impl Default for ChannelConfig {
    fn default() -> Self {
        Self { force: true, travel: true, reference: false, tangential: false }
    }
}

settings! {
    /// White Gaussian noise of each sensor, rms.
    pub struct NoiseConfig in "noise" {
        stylus_um: f64 = 0.1, 0.0 to 1000.0 => "Stylus (um)";
        force_mn: f64 = 5.0, 0.0 to 1000.0 => "Normal force (mN)";
        travel_um: f64 = 0.3, 0.0 to 1000.0 => "Moved distance (um), before quantisation";
        travel_step_um: f64 = 1.0, 0.001 to 1000.0 => "Resolution of the moved distance (um)";
        tangential_mn: f64 = 5.0, 0.0 to 1000.0 => "Tangential force (mN)";
    }
}

/// Span of a stylus (m): pre-load and the highest asperities of Ra 50 um.
pub(crate) const STYLUS_SPAN_M: f64 = 1e-3;

/// Span of an accelerometer (m/s^2): 16 g.
pub(crate) const ACCELERATION_SPAN_M_S2: f64 = 160.0;

settings! {
    /// When and in which steps the sensors are read; 0 everywhere is ideal. Between two readings a sensor shows the last one.
    pub struct ReadingConfig in "reading" {
        travel_hz: f64 = 0.0, 0.0 to 20_000.0 => "Readings of the moved distance a second (0: at each sample)";
        travel_delay_ms: f64 = 0.0, 0.0 to 1000.0 => "How old they are (ms)";
        force_hz: f64 = 0.0, 0.0 to 20_000.0 => "Readings of the normal and the tangential force a second (0: at each sample)";
        force_drift_mn_s: f64 = 0.0, -1000.0 to 1000.0 => "Drift of the normal force from the start on (mN/s)";
        adc_bits: u8 = 0, 0.0 to 24.0 =>
            "Bits of the converter of stylus (+-1 mm), accelerometer (+-160 m/s^2) and forces (+-1.25 times the largest), exact at 0";
        batch_ms: f64 = 0.0, 0.0 to 100.0 =>
            "The line delivers what the gripper sends only each so many ms, as a serial converter at USB does (0: at once); in `gripctl grasp` only";
    }
}

impl ReadingConfig {
    /// Step of the converter of a sensor that shows -`span` to `span`; 0 where it is exact.
    pub(crate) fn adc_step(&self, span: f64) -> f64 {
        if self.adc_bits == 0 { 0.0 } else { 2.0 * span / f64::from(self.adc_bits).exp2() }
    }
}

settings! {
    /// An accelerometer in the finger instead of a stylus: sliding excites modes of the finger, in shares that are drawn for each object.
    pub struct VibrationConfig in "vibration" {
        level: Draw = Draw::LogUniform { log_uniform: [5.0, 50.0] }, 0.1 to 10_000.0 =>
            "Vibration over noise (rms) where the object slides with 0.1 m/s";
        exponent: Draw = Draw::Uniform { uniform: [0.7, 1.3] }, 0.1 to 3.0 => "Power of the speed that the vibration grows with";
        noise_m_s2: f64 = 0.05, 0.0 to 1000.0 => "White Gaussian noise (m/s^2, rms)";
    }
}

settings! {
    /// What a sensor shows over what there is: an error of calibration that stays the same during a grasp.
    pub struct GainConfig in "gain" {
        stylus: Draw = Draw::Fixed(1.0), 0.1 to 10.0 => "Both styli and the motion reference";
        force: Draw = Draw::Fixed(1.0), 0.1 to 10.0 => "Normal force";
        travel: Draw = Draw::Fixed(1.0), 0.1 to 10.0 => "Moved distance";
        tangential: Draw = Draw::Fixed(1.0), 0.1 to 10.0 => "Tangential force";
    }
}

/// The drawn gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gains {
    pub(crate) stylus: f64,
    pub(crate) force: f64,
    pub(crate) travel: f64,
    pub(crate) tangential: f64,
}

impl Gains {
    pub(super) fn draw(config: &GainConfig, rng: &mut ChaCha8Rng) -> Self {
        Self {
            stylus: config.stylus.sample(rng),
            force: config.force.sample(rng),
            travel: config.travel.sample(rng),
            tangential: config.tangential.sample(rng),
        }
    }
}
