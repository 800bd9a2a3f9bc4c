//! Bands, thresholds and times of the detector.

use super::reference::GateConfig;
use crate::{alarm::TAIL_RANGE, settings::settings};

/// Bands of the detector: shear, vibration and the four that part a slip from motion.
pub const BANDS: usize = 6;

/// Place of the vibration band.
pub(super) const VIBRATION: usize = 1;
/// Place of the first of the four bands that do not overlap.
pub(super) const FIRST_OCTAVE: usize = 2;

/// Bands whose energy decides in a still scene: shear, vibration, and the two highest octaves, which a hum of the mains leaves free. While the
/// robot moves every band decides.
pub const STILL_BANDS: [bool; BANDS] = [true, true, false, false, true, true];

/// One band with its threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct BandThreshold {
    /// Lower corner (Hz).
    pub low_hz: f32,
    /// Upper corner (Hz), lowered to 0.4 of the sample rate where it lies above.
    pub high_hz: f32,
    /// Energy over the noise floor that is a slip.
    pub threshold: f32,
}

/// Which sequential test decides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "lowercase")
)]
pub enum TestKind {
    /// The energy of each band, or the cumulative sum over the four bands: the first to alarm.
    #[default]
    Fused,
    /// The energy of each band.
    Energy,
    /// The cumulative sum over the four bands.
    Cusum,
    /// The windowed generalised likelihood ratio over the four bands.
    Glrt,
}

const fn band(low_hz: f32, high_hz: f32, threshold: f32) -> BandThreshold {
    BandThreshold { low_hz, high_hz, threshold }
}

const OCTAVES: [BandThreshold; 4] = [
    band(30.0, 90.0, 35.0),
    band(90.0, 250.0, 17.0),
    band(250.0, 700.0, 14.0),
    band(700.0, 3000.0, 10.0),
];

settings! {
    /// Bands, thresholds and times of the detector.
    pub struct DetectorConfig as c in "detector" {
        test: TestKind = TestKind::Fused => "Which test decides.";
        shear: BandThreshold = band(20.0, 400.0, 25.0) =>
            "The band of elastic shear and first movement. At sample rates below 500 Hz this one and the next are"
            "moved to the two highest octaves that the rate can carry, where they lie above.";
        vibration: BandThreshold = band(100.0, 800.0, 12.0) => "The band of the texture.";
        octaves: [BandThreshold; 4] = OCTAVES =>
            "Bands that do not overlap, lowest first; one that does not fit under 0.4 of the sample rate is left"
            "out.";
        gross: f32 = 25.0, 1.5..=1e9 =>
            "Energy of the vibration band, or of one of the two highest octaves, over its floor at which a slip is"
            "gross.";
        envelope_ms: f32 = 5.0, 0.5..=1000.0 => "Time constant of the energy (ms).";
        cusum_threshold: f32 = 22.0, 1.0..=1e9 => "Log-likelihood ratio at which the cumulative sum is a slip.";
        cusum_ratio: f32 = 6.0, 1.1..=1e6 => "Rise of the energy over the floor that the cumulative sum looks for.";
        glrt_threshold: f32 = 25.0, 1.0..=1e9 =>
            "Log-likelihood ratio at which the generalised likelihood ratio is a slip.";
        tail: f32 = 4.0, TAIL_RANGE.0..=TAIL_RANGE.1 =>
            "How fast false alarms get rarer above the thresholds: their rate falls as statistic^-tail."
            "Only the confidence of an event depends on it.";
        release: f32 = 0.25, 0.01..=1.0 =>
            "Fraction of the thresholds below which the statistic must stay for the slip to end.";
        release_ms: f32 = 50.0, 1.0..=10_000.0 => "How long it must stay there (ms).";
        [gate]: GateConfig = GateConfig::default() => "How the motion of the robot is distinguished from slip.";
    }
}

impl DetectorConfig {
    /// Every band in its place.
    #[must_use]
    pub fn bands(&self) -> [BandThreshold; BANDS] {
        let [a, b, c, d] = self.octaves;
        [self.shear, self.vibration, a, b, c, d]
    }
}
