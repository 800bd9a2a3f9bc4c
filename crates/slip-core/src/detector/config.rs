//! Bands, slack, times and the wanted false-alarm interval of the detector.

use super::{reference::GateConfig, sum::COMPONENTS};
use crate::{filter::Band, settings::settings};

/// Bands of the detector: shear, vibration and the four octaves, which do not overlap.
pub const BANDS: usize = 6;

/// Place of the vibration band.
pub(super) const VIBRATION: usize = 1;
/// Place of the first of the four bands that do not overlap.
pub(super) const FIRST_OCTAVE: usize = 2;

const fn band(low_hz: f32, high_hz: f32) -> Band {
    Band { low_hz, high_hz }
}

const OCTAVES: [Band; 4] =
    [band(30.0, 90.0), band(90.0, 250.0), band(250.0, 700.0), band(700.0, 3000.0)];

settings! {
    /// Bands, slack and times of the detector.
    pub struct DetectorConfig as c in "detector" {
        interval_s: f32 = 600.0, 1.0..=1e9 =>
            "Wanted mean time between false alarms of a still gripper (s): a slip is reported when its evidence, which is"
            "a time too, reaches this.";
        shear: Band = band(20.0, 400.0) =>
            "The band of elastic shear and first movement (Hz). At sample rates below 500 Hz this one and the next are"
            "moved to the two highest octaves that the rate can carry, where they lie above.";
        vibration: Band = band(100.0, 800.0) => "The band of the texture (Hz).";
        octaves: [Band; 4] = OCTAVES =>
            "Bands that do not overlap, lowest first (Hz); one that does not fit under 0.4 of the sample rate is left"
            "out.";
        gross: f32 = 25.0, 1.5..=1e9 =>
            "Energy of the vibration band, or of one of the two highest octaves, over its floor at which a slip is"
            "gross.";
        envelope_ms: f32 = 5.0, 0.5..=1000.0 => "Time constant of this energy (ms).";
        release_ms: f32 = 50.0, 1.0..=10_000.0 =>
            "How long the evidence must stay below a 400th of the interval for the slip to end (ms).";
        slack_still: [f32; COMPONENTS] = [4.0, 3.0, 8.0, 8.0, 3.0, 3.0, 1.0], 1.0..=1e9 =>
            "Times the noise floor may rise, robot still, without being evidence: of shear, vibration, the octaves, and"
            "the octaves together. Two of the octaves and the last decide in motion only.";
        slack_moving: [f32; COMPONENTS] = [8.0, 3.0, 8.0, 8.0, 3.0, 3.0, 1.0], 1.0..=1e9 =>
            "The same while the robot moves, over what the reference shows of the motion.";
        [gate]: GateConfig = GateConfig::default() => "How the motion of the robot is distinguished from slip.";
    }
}

impl DetectorConfig {
    /// Every band in its place.
    #[must_use]
    pub fn bands(&self) -> [Band; BANDS] {
        let [a, b, c, d] = self.octaves;
        [self.shear, self.vibration, a, b, c, d]
    }
}
