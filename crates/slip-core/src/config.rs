//! The configuration and its check, which names the wrong value.

use crate::{
    Signal,
    alarm::Methods,
    detector::{BANDS, Certificate, DetectorConfig, KnownFloors, SlipDetector},
    distance::DistanceConfig,
    error::ConfigError,
    filter::MAX_CORNER,
    floor::FloorConfig,
    fusion,
    grip::GripConfig,
    health::HealthConfig,
    observation::ObservationConfig,
    pressure::PressureConfig,
    units::Hertz,
    velocity::VelocityConfig,
};

/// Names of the values of a band: shear, vibration, any of the four others.
const BAND_NAMES: [[&str; 2]; 3] = [
    ["detector.shear.low_hz", "detector.shear.high_hz"],
    ["detector.vibration.low_hz", "detector.vibration.high_hz"],
    ["detector.octaves.low_hz", "detector.octaves.high_hz"],
];

/// Everything a pipeline needs to know.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct PipelineConfig {
    /// Samples per second, 20 to 50,000.
    pub sample_rate: Hertz,
    /// What the stylus channel holds.
    pub signal: Signal,
    /// How the noise floor is found.
    pub floor: FloorConfig,
    /// A noise floor that is known already: energy of each band (signal unit squared).
    pub known_floor: Option<[f32; BANDS]>,
    /// Energies of a quiet motion reference and of its slow part, known already (reference unit squared).
    pub known_reference: Option<[f32; 2]>,
    /// A false-alarm interval and what it stands on, for the known noise floor; without it no slip is certified.
    pub certificate: Option<Certificate>,
    /// Bands, slack and interval.
    pub detector: DetectorConfig,
    /// What is believed of the sensors.
    pub health: HealthConfig,
    /// The methods that may show a slip, where the gripper has their channels.
    pub methods: Methods,
    /// The moved-distance method.
    pub travel: DistanceConfig,
    /// The pressure-distribution method.
    pub pressure: PressureConfig,
    /// What is known of the sensors of speed.
    pub velocity: VelocityConfig,
    /// How a slip is measured.
    pub observation: ObservationConfig,
    /// The force controller; without it the pipeline only observes.
    pub grip: Option<GripConfig>,
    /// Runs every stage in every scene. The steps are the same, only slower.
    pub no_skip: bool,
}

/// Sample rates below this carry shear and vibration where they can, and not where the configuration has them (Hz).
const LOWERED_BELOW_HZ: f32 = 500.0;

impl PipelineConfig {
    /// The highest sample rate (Hz).
    pub const HIGHEST_RATE_HZ: f32 = 50_000.0;

    /// The defaults for a stylus that measures `signal` at `sample_rate`, observing only.
    #[must_use]
    pub fn observing(signal: Signal, sample_rate: Hertz) -> Self {
        let (floor, health) = match signal {
            Signal::Displacement => (FloorConfig::default(), HealthConfig::default()),
            Signal::Vibration => {
                (FloorConfig::default().in_any_unit(), HealthConfig::default().in_any_unit())
            }
        };
        Self {
            sample_rate,
            signal,
            floor,
            known_floor: None,
            known_reference: None,
            certificate: None,
            detector: DetectorConfig::default(),
            health,
            methods: Methods::ALL,
            travel: DistanceConfig::default(),
            pressure: PressureConfig::default(),
            velocity: VelocityConfig::default(),
            observation: ObservationConfig::default(),
            grip: None,
            no_skip: false,
        }
    }

    /// The defaults for a gripper whose stylus measures displacement.
    #[must_use]
    pub fn gripping(sample_rate: Hertz) -> Self {
        Self {
            grip: Some(GripConfig::default()),
            ..Self::observing(Signal::Displacement, sample_rate)
        }
    }

    /// # Errors
    /// The first value outside its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        let rate_hz = self.sample_rate.0;
        ConfigError::within("sample_rate_hz", rate_hz, 20.0, Self::HIGHEST_RATE_HZ)?;
        self.floor.check()?;
        self.check_detector()?;
        self.certificate.map_or(Ok(()), |certificate| certificate.check())?;
        self.health.check()?;
        self.observation.check()?;
        fusion::check(self.methods)?;
        self.travel.check()?;
        self.pressure.check()?;
        self.velocity.check()?;
        self.grip.map_or(Ok(()), |grip| grip.check())
    }

    fn check_detector(&self) -> Result<(), ConfigError> {
        let d = &self.detector;
        let limit_hz = MAX_CORNER * self.sample_rate.0;
        for (i, band) in d.bands().into_iter().enumerate() {
            let [low, high] = BAND_NAMES[i.min(2)];
            ConfigError::within(high, band.high_hz, 0.01, 1e6)?;
            // At the rates of taxels and IMUs the detector lowers the first two; above, a band that does not fit is a mistake.
            let lowered = i >= 2 || self.sample_rate.0 < LOWERED_BELOW_HZ;
            let top = if lowered { band.high_hz } else { band.high_hz.min(limit_hz) };
            ConfigError::within(low, band.low_hz, 1e-3, top)?;
        }
        d.check()?;
        SlipDetector::new(d, self.floor, KnownFloors::default(), self.sample_rate.0)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::PipelineConfig;
    use crate::units::Hertz;
    use crate::{ConfigError, Signal};

    #[test]
    fn defaults_fit_every_rate_of_the_contract() {
        for rate in [20.0, 40.0, 100.0, 333.0, 1000.0, 2200.0, 10_000.0, 20_000.0] {
            assert_eq!(PipelineConfig::gripping(Hertz(rate)).check(), Ok(()));
            assert_eq!(PipelineConfig::observing(Signal::Vibration, Hertz(rate)).check(), Ok(()));
        }
    }

    #[test]
    fn a_wrong_value_is_named() {
        let mut config = PipelineConfig::gripping(Hertz(10_000.0));
        config.detector.envelope_ms = f32::NAN;
        let Err(ConfigError::Range { name, .. }) = config.check() else { panic!("accepted") };
        assert_eq!(name, "detector.envelope_ms");
        let mut config = PipelineConfig::gripping(Hertz(10_000.0));
        config.grip.as_mut().unwrap().trial_force_n = 100.0;
        let error = config.check().unwrap_err();
        assert_eq!(
            error,
            ConfigError::Range { name: "grip.trial_force_n", value: 100.0, low: 0.01, high: 60.0 }
        );
    }

    /// A value on which the range of another one depends is blamed itself, and tables within tables are checked.
    #[test]
    fn the_value_that_is_wrong_is_the_one_that_is_named() {
        let named = |change: fn(&mut PipelineConfig)| {
            let mut config = PipelineConfig::gripping(Hertz(10_000.0));
            change(&mut config);
            let Err(ConfigError::Range { name, .. }) = config.check() else { panic!("accepted") };
            name
        };
        assert_eq!(named(|c| c.travel.resolution_m = 0.05), "travel.resolution_m");
        assert_eq!(named(|c| c.travel.limit_m = 1e-6), "travel.limit_m");
        assert_eq!(named(|c| c.pressure.threshold = 40.0), "pressure.threshold");
        assert_eq!(named(|c| c.velocity.spacing_m = 0.0), "velocity.spacing_m");
        assert_eq!(named(|c| c.health.drift.limit = f32::NAN), "health.drift.limit");
        assert_eq!(named(|c| c.health.max_bad_run = 0), "health.max_bad_run");
        assert_eq!(named(|c| c.detector.gate.gain[3] = -1.0), "detector.gate.gain");
        assert_eq!(
            named(|c| c.observation.speed.fixed_m_s = Some(0.0)),
            "observation.speed.fixed_m_s"
        );
        assert_eq!(named(|c| c.pressure.known_rms = Some(0.0)), "pressure.known_rms");
    }
}
