//! Bands, thresholds and times of the detector.

use super::reference::GateConfig;

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

/// Bands, thresholds and times of the detector.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct DetectorConfig {
    /// Which test decides.
    pub test: TestKind,
    /// The band of elastic shear and first movement. At sample rates below 500 Hz this one and the next are moved to the two highest
    /// octaves that the rate can carry, where they lie above.
    pub shear: BandThreshold,
    /// The band of the texture.
    pub vibration: BandThreshold,
    /// Bands that do not overlap, lowest first; one that does not fit under 0.4 of the sample rate is left out.
    pub octaves: [BandThreshold; 4],
    /// Energy of the vibration band, or of one of the two highest octaves, over its floor at which a slip is gross.
    pub gross: f32,
    /// Time constant of the energy (ms).
    pub envelope_ms: f32,
    /// Log-likelihood ratio at which the cumulative sum is a slip.
    pub cusum_threshold: f32,
    /// Rise of the energy over the floor that the cumulative sum looks for.
    pub cusum_ratio: f32,
    /// Log-likelihood ratio at which the generalised likelihood ratio is a slip.
    pub glrt_threshold: f32,
    /// How fast false alarms get rarer above the thresholds: their rate falls as statistic^-tail; 1 to 50. Only the confidence of an
    /// event depends on it.
    pub tail: f32,
    /// Fraction of the thresholds below which the statistic must stay for the slip to end.
    pub release: f32,
    /// How long it must stay there (ms).
    pub release_ms: f32,
    /// How the motion of the robot is distinguished from slip.
    pub gate: GateConfig,
}

impl Default for DetectorConfig {
    fn default() -> Self {
        let band = |low_hz, high_hz, threshold| BandThreshold { low_hz, high_hz, threshold };
        Self {
            test: TestKind::Fused,
            shear: band(20.0, 400.0, 25.0),
            vibration: band(100.0, 800.0, 12.0),
            octaves: [
                band(30.0, 90.0, 35.0),
                band(90.0, 250.0, 17.0),
                band(250.0, 700.0, 14.0),
                band(700.0, 3000.0, 10.0),
            ],
            gross: 25.0,
            envelope_ms: 5.0,
            cusum_threshold: 22.0,
            cusum_ratio: 6.0,
            glrt_threshold: 25.0,
            tail: 4.0,
            release: 0.25,
            release_ms: 50.0,
            gate: GateConfig::default(),
        }
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
