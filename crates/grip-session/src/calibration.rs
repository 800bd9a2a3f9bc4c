//! The file of a calibration: a noise floor, a motion gate and slack, what they stand on, and what they change in the settings.

use serde::{Deserialize, Serialize};
use slip_core::{
    PipelineConfig,
    detector::{BANDS, COMPONENTS, Certificate},
    units::Hertz,
};

/// What `gripctl calibrate` writes and `--calibration` reads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[expect(clippy::large_enum_variant, reason = "there is one of it")]
pub enum Calibration {
    /// Of a stylus or vibration, and of taxels where there are any.
    Stylus(StylusCalibration),
    /// Of a taxel array alone.
    Array(ArrayCalibration),
}

/// What a recording without slip shows of a taxel array alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArrayCalibration {
    /// Samples per second it holds for.
    pub sample_rate_hz: f32,
    /// What the taxels show while an object is held.
    pub taxels: TaxelRest,
}

/// What a recording without slip shows of a stylus or vibration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StylusCalibration {
    /// Samples per second it holds for.
    pub sample_rate_hz: f32,
    /// Whether the stylus was uncalibrated vibration, not displacement.
    pub vibration: bool,
    /// Quiet energy of each band (signal unit squared).
    pub floor: [f32; BANDS],
    /// Quiet energy of the reference and of its slow part (unit squared).
    pub reference_floor: Option<[f32; 2]>,
    /// What motion adds to the floor of each band; absent where the recording had too little motion.
    pub gain: Option<[f32; BANDS]>,
    /// Slack of each component of the sum, robot still and moving: shear, vibration, the octaves, the octaves together.
    pub slack_still: [f32; COMPONENTS],
    /// While the robot moves.
    pub slack_moving: [f32; COMPONENTS],
    /// What it was made from.
    pub evidence: Evidence,
    /// Limits and chances of the certified alarm, and what they stand on. Absent where the recording does not carry the
    /// interval, and in files of older versions: nothing is certified then.
    #[serde(default)]
    pub certificate: Option<Certificate>,
    /// What the certificate stands on.
    #[serde(default)]
    pub certified: Option<Certified>,
    /// What the taxels show while an object is held. Absent without an array or a grip force, and in files of older
    /// versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub taxels: Option<TaxelRest>,
}

/// What the taxels show at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaxelRest {
    /// Noise (unit of the taxels, rms).
    pub rms: f32,
    /// Largest mean range of a taxel beside the shape (unit of the taxels); absent where no stretch lasted for 2 s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<f32>,
}

/// What a calibration stands on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Evidence {
    /// Wanted mean time between false alarms (s).
    pub wanted_interval_s: f64,
    /// Rest (s).
    pub rest_s: f64,
    /// Rest that was louder than the rest of it though the reference shows no motion (s): a knock, a slip or other work.
    /// It does not count for the floor. Absent in files of older versions.
    #[serde(default)]
    pub unexplained_s: f64,
    /// Where the longest stretch of it begins (s) and how long it lasts (s).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unexplained_longest: Option<[f64; 2]>,
    /// Motion (s).
    pub motion_s: f64,
    /// Largest over smallest energy of the eighths of the rest, in the band where they differ most: 1 for steady noise.
    pub unsteady: f32,
    /// Alarms that a replay of the recording with this calibration shows.
    pub seen: u64,
    /// Signal (s) whose alarms the slack was judged by, after it was found from the rest of the recording.
    pub judged_s: f64,
    /// Seconds of it with evidence beyond the interval.
    pub alarms: u64,
    /// Lower bound (95 %) of the mean time between false alarms (s), if what comes is like what was judged. Nothing beyond it is claimed.
    pub interval_low_s: f64,
    /// The smallest vibration (signal unit, rms) that is a slip within [`Evidence::WITHIN_S`] at rest ...
    #[serde(default)]
    pub smallest_rest: Option<f32>,
    /// ... and in motion as it was on average; absent where the recording had too little motion.
    #[serde(default)]
    pub smallest_motion: Option<f32>,
}

impl Evidence {
    /// Time in which the smallest vibration has to be found (s).
    pub const WITHIN_S: f32 = 0.02;
}

/// What a certificate stands on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certified {
    /// Signal that was judged by limits from the other half of it (s).
    pub judged_s: f64,
    /// Certified alarms in it.
    pub alarms: u64,
    /// Lower bound (95 %) of the mean time between them (s).
    pub interval_low_s: f64,
    /// Upper bound (95 %); absent where there was no alarm.
    pub interval_high_s: Option<f64>,
    /// At rest; absent where that was too short.
    pub rest: Option<LawEvidence>,
    /// In motion; absent where there was too little.
    pub motion: Option<LawEvidence>,
}

/// What one law stands on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LawEvidence {
    /// Length of the signal (s).
    pub seconds: f64,
    /// Shortest and longest block of a band (ms).
    pub blocks_ms: [f64; 2],
    /// Times the chances were raised because high blocks follow each other, in the worst band; 1 for independent blocks, up to chance.
    pub clusters: f64,
    /// A slip above all of the calibration in every band is certified within this time (ms) and one block.
    pub soonest_ms: f64,
}

impl Calibration {
    /// From the text of its file. One that has `taxels` and no `floor` is that of an array alone.
    ///
    /// # Errors
    /// Where the text is no TOML, or a key is missing, unknown or of another type; where it has thresholds, as before there was one sum.
    pub fn parse(text: &str) -> Result<Self, toml::de::Error> {
        let keys: toml::Table = toml::from_str(text)?;
        if keys.contains_key("thresholds") {
            return Err(serde::de::Error::custom(
                "made by an older version, for a detector with thresholds: calibrate again with `gripctl calibrate`",
            ));
        }
        if keys.contains_key("taxels") && !keys.contains_key("floor") {
            return toml::from_str(text).map(Self::Array);
        }
        toml::from_str(text).map(Self::Stylus)
    }

    /// The settings with this calibration in force.
    #[must_use]
    pub fn apply(&self, config: PipelineConfig) -> PipelineConfig {
        let (config, taxels) = match self {
            Self::Stylus(stylus) => (stylus.apply(config), stylus.taxels),
            Self::Array(array) => (config, Some(array.taxels)),
        };
        let mut pressure = config.pressure;
        pressure.known_rms = pressure.known_rms.or(taxels.map(|taxels| taxels.rms));
        pressure.known_range = pressure.known_range.or(taxels.and_then(|taxels| taxels.range));
        PipelineConfig { pressure, ..config }
    }

    /// What it knows of a stylus.
    #[must_use]
    pub fn stylus(&self) -> Option<&StylusCalibration> {
        match self {
            Self::Stylus(stylus) => Some(stylus),
            Self::Array(_) => None,
        }
    }

    /// Samples per second it holds for.
    #[must_use]
    pub fn sample_rate(&self) -> Hertz {
        Hertz(match self {
            Self::Stylus(stylus) => stylus.sample_rate_hz,
            Self::Array(array) => array.sample_rate_hz,
        })
    }

    /// Whether it was made at `rate` (within 1 %) and, where it knows a stylus, for the same kind.
    #[must_use]
    pub fn fits(&self, rate: Hertz, vibration: bool) -> bool {
        (rate.0 / self.sample_rate().0 - 1.0).abs() < 0.01
            && self.stylus().is_none_or(|stylus| stylus.vibration == vibration)
    }
}

impl StylusCalibration {
    fn apply(&self, config: PipelineConfig) -> PipelineConfig {
        let mut detector = config.detector;
        #[expect(clippy::cast_possible_truncation, reason = "at most 1e9")]
        let interval_s = self.evidence.wanted_interval_s as f32;
        detector.interval_s = interval_s;
        (detector.slack_still, detector.slack_moving) = (self.slack_still, self.slack_moving);
        detector.gate.gain = self.gain.unwrap_or(detector.gate.gain);
        PipelineConfig {
            detector,
            known_floor: Some(self.floor),
            known_reference: self.reference_floor,
            certificate: self.certificate,
            ..config
        }
    }

    /// States what is still found: energies over the floors that are slips, of shear and vibration, at rest and in motion with these mean energies
    /// of the reference.
    pub fn set_smallest(
        &mut self,
        still: &[f32; BANDS],
        moving: &[f32; BANDS],
        reference: &[f32; BANDS],
    ) {
        let smallest = |over: &[f32; BANDS], motion: &[f32; BANDS]| {
            let energy = |b: usize| over[b] * (self.floor[b] + motion[b]);
            energy(0).min(energy(1)).sqrt()
        };
        let rest = smallest(still, &[0.0; BANDS]);
        let motion = self
            .gain
            .map(|gain| smallest(moving, &core::array::from_fn(|b| gain[b] * reference[b])));
        (self.evidence.smallest_rest, self.evidence.smallest_motion) = (Some(rest), motion);
    }
}
