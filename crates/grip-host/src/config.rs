//! The text of a configuration file in, checked settings or the line and column of the mistake out.

use crate::calibrate::Calibration;
use serde::{Deserialize, Serialize};
use slip_core::{
    ConfigError, PipelineConfig, Signal,
    detector::DetectorConfig,
    distance::DistanceConfig,
    esc::Reading,
    floor::FloorConfig,
    grip::GripConfig,
    health::HealthConfig,
    methods::{Method, Methods},
    observation::ObservationConfig,
    pressure::PressureConfig,
    units::Hertz,
    velocity::VelocityConfig,
};
use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};

/// What `gripd.toml` may hold. Everything has a default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HostConfig {
    /// Serial port, `auto`, or `sim` with an optional `:SCENE`.
    pub port: Option<String>,
    /// Bits per second of the serial line; USB devices ignore it.
    pub baud: Option<u32>,
    /// Which USB port `auto` means.
    pub usb: UsbFilter,
    /// Model file that replaces the embedded network.
    pub model: Option<PathBuf>,
    /// Calibration file: floor, gate and thresholds of this gripper.
    pub calibration: Option<PathBuf>,
    /// What that file says; see [`HostConfig::with_calibration`].
    #[serde(skip)]
    pub calibrated: Option<Calibration>,
    /// The methods that may tell a slip, where the gripper has their channels.
    pub methods: Vec<Method>,
    /// What is asked of the microcontroller.
    pub link: LinkConfig,
    /// How the noise floor is found.
    pub floor: FloorConfig,
    /// Bands and thresholds of the slip detector.
    pub detector: DetectorConfig,
    /// What is believed of the sensors.
    pub health: HealthConfig,
    /// The moved-distance method.
    pub travel: DistanceConfig,
    /// The pressure-distribution method.
    pub pressure: PressureConfig,
    /// What is known of the sensors of speed.
    pub velocity: VelocityConfig,
    /// How a slip is measured.
    pub observation: ObservationConfig,
    /// Forces and rates of the controller.
    pub grip: GripConfig,
}

impl Default for HostConfig {
    fn default() -> Self {
        Self {
            port: None,
            baud: None,
            usb: UsbFilter::ANY,
            model: None,
            calibration: None,
            calibrated: None,
            methods: Method::ALL.to_vec(),
            link: LinkConfig::default(),
            floor: FloorConfig::default(),
            detector: DetectorConfig::default(),
            health: HealthConfig::default(),
            travel: DistanceConfig::default(),
            pressure: PressureConfig::default(),
            velocity: VelocityConfig::default(),
            observation: ObservationConfig::default(),
            grip: GripConfig::default(),
        }
    }
}

/// The reading of E_sc of that name, for a flag.
///
/// # Errors
/// A sentence with the names there are.
pub fn esc_reading(name: &str) -> Result<Reading, String> {
    Reading::from_name(name).ok_or_else(|| {
        let names: Vec<&str> = Reading::ALL.iter().map(|reading| reading.name()).collect();
        format!("expected one of {}", names.join(", "))
    })
}

/// Which USB serial port `auto` means; what is absent fits every port.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct UsbFilter {
    /// Vendor.
    pub vid: Option<u16>,
    /// Product.
    pub pid: Option<u16>,
    /// Serial number; `*` stands for any characters.
    pub serial: Option<String>,
    /// Name of the product; `*` stands for any characters.
    pub product: Option<String>,
}

impl UsbFilter {
    /// Fits every USB serial port.
    pub const ANY: Self = Self { vid: None, pid: None, serial: None, product: None };
}

/// What is asked of the microcontroller when the link is set up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LinkConfig {
    /// Samples per second, 1,000 to 20,000.
    pub sample_rate_hz: u32,
    /// Samples per frame, 1 to 32.
    pub batch: u8,
    /// How long a command stays valid on the device (ms), 20 to 100.
    pub ttl_ms: u16,
}

impl Default for LinkConfig {
    fn default() -> Self {
        Self { sample_rate_hz: 10_000, batch: 10, ttl_ms: 50 }
    }
}

/// Why a configuration file is refused.
#[derive(Debug, thiserror::Error)]
pub enum HostConfigError {
    /// The file cannot be read.
    #[error("{}: the configuration cannot be read: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Not TOML, an unknown key, or a value of the wrong type.
    #[error("{}: {message}", file.display())]
    Parse {
        /// The file.
        file: PathBuf,
        /// Line, column, the line itself and what is wrong with it.
        message: String,
    },
    /// The calibration was made for another sample rate or another kind of stylus.
    #[error(
        "the calibration holds for {made_hz} Hz and {}, not for {rate_hz} Hz and {}: calibrate again",
        stylus_name(*made_vibration),
        stylus_name(*vibration)
    )]
    OtherSignal {
        /// Rate it was made at.
        made_hz: f32,
        /// Whether it was made for uncalibrated vibration.
        made_vibration: bool,
        /// Rate it is to be used at.
        rate_hz: f32,
        /// Whether it is to be used for uncalibrated vibration.
        vibration: bool,
    },
    /// A value outside its range.
    #[error("{}:{line}:{column}: {source}", file.display())]
    Value {
        /// The file.
        file: PathBuf,
        /// Line of the value, from 1; 0 where the value is a default.
        line: usize,
        /// Column of the value, from 1; 0 where the value is a default.
        column: usize,
        /// The value and its range.
        source: ConfigError,
    },
}

impl HostConfig {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// Where the file cannot be read, is not TOML, has an unknown key or a value outside its range.
    pub fn read(file: &Path) -> Result<Self, HostConfigError> {
        let text = std::fs::read_to_string(file)
            .map_err(|source| HostConfigError::Read { file: file.to_owned(), source })?;
        let config = Self::parse(file, &text)?;
        match config.calibration.clone() {
            Some(file) => config.with_calibration(&file),
            None => Ok(config),
        }
    }

    /// The same settings with the calibration in `file` in force.
    ///
    /// # Errors
    /// Where the file cannot be read or is no calibration.
    pub fn with_calibration(self, file: &Path) -> Result<Self, HostConfigError> {
        let text = std::fs::read_to_string(file)
            .map_err(|source| HostConfigError::Read { file: file.to_owned(), source })?;
        let calibrated: Calibration =
            toml::from_str(&text).map_err(|error| HostConfigError::Parse {
                file: file.to_owned(),
                message: error.to_string().trim_end().to_owned(),
            })?;
        calibrated
            .apply(PipelineConfig::observing(
                Signal::Displacement,
                Hertz(calibrated.sample_rate_hz),
            ))
            .check()
            .map_err(|source| HostConfigError::Value {
                file: file.to_owned(),
                line: 0,
                column: 0,
                source,
            })?;
        Ok(Self { calibrated: Some(calibrated), ..self })
    }

    /// Whether the calibration, where there is one, was made for such a signal.
    ///
    /// # Errors
    /// [`HostConfigError::OtherSignal`] where it was not.
    pub fn check_signal(&self, rate: Hertz, vibration: bool) -> Result<(), HostConfigError> {
        match self.calibrated {
            Some(made) if !made.fits(rate, vibration) => Err(HostConfigError::OtherSignal {
                made_hz: made.sample_rate_hz,
                made_vibration: made.vibration,
                rate_hz: rate.0,
                vibration,
            }),
            _ => Ok(()),
        }
    }

    /// `config` with the calibration in force, where there is one.
    #[must_use]
    pub fn calibrate(&self, config: PipelineConfig) -> PipelineConfig {
        self.calibrated.map_or(config, |calibrated| calibrated.apply(config))
    }

    /// Checks the text of a file; `file` is only named in errors.
    ///
    /// # Errors
    /// As [`HostConfig::read`].
    pub fn parse(file: &Path, text: &str) -> Result<Self, HostConfigError> {
        let config: Self = toml::from_str(text).map_err(|error| HostConfigError::Parse {
            file: file.to_owned(),
            message: error.to_string().trim_end().to_owned(),
        })?;
        config.check().map_err(|source| {
            let name = match source {
                ConfigError::Range { name, .. } => name,
                ConfigError::Corner(_) => "detector",
            };
            let (line, column) = place(text, name).unwrap_or((0, 0));
            HostConfigError::Value { file: file.to_owned(), line, column, source }
        })?;
        Ok(config)
    }

    /// The first of `./gripd.toml`, the user's and the system's file that exists.
    #[must_use]
    pub fn find(user_directory: Option<&Path>) -> Option<PathBuf> {
        let user = user_directory.map(|directory| directory.join("gripd/gripd.toml"));
        [Some(PathBuf::from("gripd.toml")), user, Some(PathBuf::from("/etc/gripd/gripd.toml"))]
            .into_iter()
            .flatten()
            .find(|file| file.is_file())
    }

    fn check(&self) -> Result<(), ConfigError> {
        let LinkConfig { sample_rate_hz, batch, ttl_ms } = self.link;
        #[expect(clippy::cast_precision_loss, reason = "only shown and compared")]
        let rate = sample_rate_hz as f32;
        #[expect(clippy::cast_precision_loss, reason = "only shown and compared")]
        let baud = self.baud.map_or(1.0, |baud| baud as f32);
        ConfigError::within("baud", baud, 1.0, 1e9)?;
        ConfigError::within("link.sample_rate_hz", rate, 1000.0, 20_000.0)?;
        ConfigError::within("link.batch", f32::from(batch), 1.0, 32.0)?;
        ConfigError::within("link.ttl_ms", f32::from(ttl_ms), 20.0, 100.0)?;
        self.pipeline(Hertz(rate)).check()
    }

    /// The methods as a set.
    #[must_use]
    pub fn methods(&self) -> Methods {
        self.methods.iter().fold(Methods::NONE, |set, &method| set.with(method))
    }

    /// The pipeline of a gripper with these settings.
    #[must_use]
    pub fn pipeline(&self, sample_rate: Hertz) -> PipelineConfig {
        self.calibrate(PipelineConfig {
            sample_rate,
            signal: Signal::Displacement,
            floor: self.floor,
            known_floor: None,
            known_reference: None,
            detector: self.detector,
            health: self.health,
            methods: self.methods(),
            travel: self.travel,
            pressure: self.pressure,
            velocity: self.velocity,
            observation: self.observation,
            grip: Some(self.grip),
            no_skip: false,
        })
    }
}

fn stylus_name(vibration: bool) -> &'static str {
    if vibration { "vibration" } else { "displacement" }
}

/// Line and column of the value `path` (dotted) in a TOML text, both from 1; of its innermost table that
/// is there, where the value itself is not.
pub(crate) fn place(text: &str, path: &str) -> Option<(usize, usize)> {
    let root = DeTable::parse(text).ok()?;
    let mut table = root.get_ref();
    let mut at = None;
    for name in path.split('.') {
        let Some((key, value)) = table.iter().find(|(key, _)| key.get_ref().as_ref() == name)
        else {
            break;
        };
        at = Some(key.span().start);
        let DeValue::Table(inner) = value.get_ref() else { break };
        table = inner;
    }
    let before = text.get(..at?)?;
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
    Some((line, column))
}

#[cfg(test)]
mod tests {
    use super::{HostConfig, HostConfigError};
    use std::path::Path;

    fn error(text: &str) -> String {
        HostConfig::parse(Path::new("gripd.toml"), text).unwrap_err().to_string()
    }

    #[test]
    fn an_empty_file_is_the_default() {
        assert_eq!(HostConfig::parse(Path::new("x"), "").unwrap(), HostConfig::default());
    }

    #[test]
    fn the_documented_file_lists_every_setting_with_its_default() {
        let text = include_str!("../../../docs/gripd.toml");
        assert_eq!(HostConfig::parse(Path::new("x"), text).unwrap(), HostConfig::default());
        let all = toml::to_string(&HostConfig::default()).unwrap();
        let keys = all.lines().filter_map(|line| line.split_once(" = ").map(|(key, _)| key));
        for key in keys {
            assert!(text.contains(&format!("{key} =")), "{key} is not documented");
        }
    }

    #[test]
    fn the_default_can_be_written_and_read_back() {
        let text = toml::to_string(&HostConfig::default()).unwrap();
        assert_eq!(HostConfig::parse(Path::new("x"), &text).unwrap(), HostConfig::default());
    }

    #[test]
    fn unknown_keys_and_wrong_types_name_line_and_column() {
        let text = error("[grip]\nf_max_n = 10.0\nforce = 3\n");
        assert!(
            text.contains("line 3, column 1") && text.contains("unknown field `force`"),
            "{text}"
        );
        let text = error("port = 7\n");
        assert!(text.contains("line 1, column 8"), "{text}");
        let text = error("[grip\n");
        assert!(text.contains("line 1"), "{text}");
    }

    #[test]
    fn impossible_limits_name_line_column_and_range() {
        let text = error("# limits\n[grip]\nf_max_n = 10.0\ntrial_force_n = 20.0\n");
        assert_eq!(text, "gripd.toml:4:1: grip.trial_force_n = 20 is outside 0.01 to 10");
        let text =
            error("[detector]\nshear = { low_hz = 500.0, high_hz = 90.0, threshold = 25.0 }\n");
        assert_eq!(text, "gripd.toml:2:11: detector.shear.low_hz = 500 is outside 0.001 to 90");
        assert_eq!(error("baud = 0\n"), "gripd.toml:1:1: baud = 0 is outside 1 to 1000000000");
        let error = HostConfig::parse(Path::new("x"), "[link]\nttl_ms = 5").unwrap_err();
        assert!(matches!(error, HostConfigError::Value { line: 2, column: 1, .. }), "{error}");
        assert!(HostConfig::parse(Path::new("x"), "[grip]\nf_max_n = nan").is_err());
    }

    #[test]
    fn a_missing_file_is_named() {
        let text = HostConfig::read(Path::new("nowhere.toml")).unwrap_err().to_string();
        assert!(text.starts_with("nowhere.toml: "), "{text}");
    }
}
