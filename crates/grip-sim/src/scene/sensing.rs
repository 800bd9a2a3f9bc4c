//! What a scene says of the gripper's sensors: which there are, their noise and their errors of scale.

use super::Draw;
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

/// White Gaussian noise of each sensor, rms, 0 to 1000 in its unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NoiseConfig {
    /// Stylus (um).
    pub stylus_um: f64,
    /// Normal force (mN).
    pub force_mn: f64,
    /// Moved distance (um), before quantisation.
    pub travel_um: f64,
    /// Resolution of the moved distance (um).
    pub travel_step_um: f64,
    /// Tangential force (mN).
    pub tangential_mn: f64,
}

impl Default for NoiseConfig {
    fn default() -> Self {
        Self {
            stylus_um: 0.1,
            force_mn: 5.0,
            travel_um: 0.3,
            travel_step_um: 1.0,
            tangential_mn: 5.0,
        }
    }
}

/// Span of a stylus (m): pre-load and the highest asperities of Ra 50 um.
pub(crate) const STYLUS_SPAN_M: f64 = 1e-3;

/// Span of an accelerometer (m/s^2): 16 g.
pub(crate) const ACCELERATION_SPAN_M_S2: f64 = 160.0;

/// When and in which steps the sensors are read; 0 everywhere is ideal. Between two readings a sensor shows the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReadingConfig {
    /// Readings of the moved distance a second, 0 (at each sample) to 20000.
    pub travel_hz: f64,
    /// How old they are (ms), 0 to 1000.
    pub travel_delay_ms: f64,
    /// Readings of the normal and the tangential force a second, 0 (at each sample) to 20000.
    pub force_hz: f64,
    /// Drift of the normal force from the start on (mN/s), -1000 to 1000.
    pub force_drift_mn_s: f64,
    /// Bits of the converter of stylus (+-1 mm), accelerometer (+-160 m/s^2) and forces (+-1.25 times the largest), 0 (exact) to 24.
    pub adc_bits: u8,
    /// The line delivers what the gripper sends only each so many ms, as a serial converter at USB does; 0 (at once) to 100.
    pub batch_ms: f64,
}

impl ReadingConfig {
    /// Step of the converter of a sensor that shows -`span` to `span`; 0 where it is exact.
    pub(crate) fn adc_step(&self, span: f64) -> f64 {
        if self.adc_bits == 0 { 0.0 } else { 2.0 * span / f64::from(self.adc_bits).exp2() }
    }
}

/// An accelerometer in the finger instead of a stylus: sliding excites modes of the finger, in shares that are drawn for each object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VibrationConfig {
    /// Vibration over noise (rms) where the object slides with 0.1 m/s, 0.1 to 10000.
    pub level: Draw,
    /// Power of the speed that the vibration grows with, 0.1 to 3.
    pub exponent: Draw,
    /// White Gaussian noise (m/s^2, rms), 0 to 1000.
    pub noise_m_s2: f64,
}

impl Default for VibrationConfig {
    fn default() -> Self {
        let level = Draw::LogUniform { log_uniform: [5.0, 50.0] };
        Self { level, exponent: Draw::Uniform { uniform: [0.7, 1.3] }, noise_m_s2: 0.05 }
    }
}

/// What a sensor shows over what there is: an error of calibration that stays the same during a grasp, 0.1 to 10 each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GainConfig {
    /// Both styli and the motion reference.
    pub stylus: Draw,
    /// Normal force.
    pub force: Draw,
    /// Moved distance.
    pub travel: Draw,
    /// Tangential force.
    pub tangential: Draw,
}

impl Default for GainConfig {
    fn default() -> Self {
        let [stylus, force, travel, tangential] = [Draw::Fixed(1.0); 4];
        Self { stylus, force, travel, tangential }
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
