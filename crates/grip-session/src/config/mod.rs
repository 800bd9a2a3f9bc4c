//! Checked settings from the texts of configuration files, or the line and column of the mistake.

mod address;
pub mod advice;
mod change;
mod check;
mod error;
mod keys;
mod layers;
mod template;

pub use address::{AddressError, Listen, Site, Uid};
pub use change::{Change, NEEDS_RESTART, needs_restart};
pub use check::BOOT_LOADER_BAUD;
pub(crate) use error::THRESHOLDS;
pub use error::{HostConfigError, Place, ValueError};
pub use keys::{
    FleetConfig, LinkConfig, LogLevel, MemoryConfig, RealtimeConfig, RealtimeMode, RecordingConfig,
    UsbFilter,
};
pub use layers::{Layers, Setting};
pub use template::{RecordTemplate, TemplateError};

use crate::{
    calibration::{Calibration, StylusCalibration},
    signature::{KeyError, ModelKeys},
};
use core::net::SocketAddr;
use serde::{Deserialize, Serialize};
use slip_core::{
    PipelineConfig, Signal,
    alarm::{Method, Methods},
    detector::DetectorConfig,
    distance::DistanceConfig,
    esc::Reading,
    floor::FloorConfig,
    grip::GripConfig,
    health::HealthConfig,
    observation::ObservationConfig,
    pressure::PressureConfig,
    units::Hertz,
    velocity::VelocityConfig,
};
use std::path::{Path, PathBuf};

/// What `gripd.toml` may hold. Everything has a default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HostConfig {
    /// Serial port, `auto`, or `sim` with an optional `:SCENE`.
    pub port: Option<String>,
    /// Bits per second of the serial line; USB devices ignore it.
    pub baud: Option<u32>,
    /// The only gripper to talk to, 32 hexadecimal digits; any, where absent.
    pub uid: Option<Uid>,
    /// Where clients may connect: `tcp:IP:PORT`, `unix:PATH` or `off`.
    pub listen: Listen,
    /// Whether clients may command the gripper.
    pub allow_commands: bool,
    /// Whether clients may bring a model, which is then in force until gripd ends.
    pub allow_models: bool,
    /// Public keys of minisign: a model is taken only where one of them has signed it.
    pub model_keys: Vec<String>,
    /// Whether a model without a signature is taken too; where absent, only while no key is named.
    pub allow_unsigned_models: Option<bool>,
    /// Whether addresses may be open to other computers.
    pub allow_remote: bool,
    /// Clients at a time, 1 to 1024.
    pub max_clients: u16,
    /// Where a browser and Prometheus read, `IP:PORT`; nowhere, where absent.
    #[serde(deserialize_with = "address::socket")]
    pub metrics: Option<SocketAddr>,
    /// Names of the recordings, .mcap or .csv; `{start}` is the time (UTC). Nothing is recorded, where absent.
    pub record: Option<RecordTemplate>,
    /// Where the last frames and the state are written on a fault.
    pub dump_dir: Option<PathBuf>,
    /// What is logged on standard error.
    pub log_level: LogLevel,
    /// Model file, or the built-in `default` or `paper`; `default`, where absent.
    pub model: Option<PathBuf>,
    /// Calibration file of `gripctl calibrate`: floor, gate and slack of this gripper.
    pub calibration: Option<PathBuf>,
    /// What that file states; see [`HostConfig::with_calibration`].
    #[serde(skip)]
    pub calibrated: Option<Calibration>,
    /// The methods that may detect a slip, where the gripper has their channels.
    pub methods: Vec<Method>,
    /// What is asked of the microcontroller.
    pub link: LinkConfig,
    /// When recordings go on in another file.
    pub recording: RecordingConfig,
    /// What is asked of the scheduler.
    pub realtime: RealtimeConfig,
    /// What is remembered of objects.
    pub memory: MemoryConfig,
    /// Which ports `auto` takes.
    pub usb: UsbFilter,
    /// How the gripper is seen beside many others.
    pub fleet: FleetConfig,
    /// How the noise floor is found.
    pub floor: FloorConfig,
    /// Bands, slack and interval of the slip detector.
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
            uid: None,
            listen: Listen::default(),
            allow_commands: false,
            allow_models: false,
            model_keys: Vec::new(),
            allow_unsigned_models: None,
            allow_remote: false,
            max_clients: 32,
            metrics: None,
            record: None,
            dump_dir: None,
            log_level: LogLevel::Info,
            model: None,
            calibration: None,
            calibrated: None,
            methods: Method::ALL.to_vec(),
            link: LinkConfig::default(),
            recording: RecordingConfig::default(),
            realtime: RealtimeConfig::default(),
            memory: MemoryConfig::default(),
            usb: UsbFilter::default(),
            fleet: FleetConfig::default(),
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

impl HostConfig {
    /// Reads and checks a file, without any other.
    ///
    /// # Errors
    /// Where the file cannot be read, is not TOML, has an unknown key or a value outside its range.
    pub fn read(file: &Path) -> Result<Self, HostConfigError> {
        Layers::file(file)?.resolve()
    }

    /// Checks the text of a file; `file` is named in errors, and its folder is where relative paths begin.
    ///
    /// # Errors
    /// As [`HostConfig::read`].
    pub fn parse(file: &Path, text: &str) -> Result<Self, HostConfigError> {
        let mut layers = Layers::default();
        layers.push(file, text);
        layers.resolve()
    }

    /// The same settings with the calibration in `file` in force.
    ///
    /// # Errors
    /// Where the file cannot be read or is no calibration.
    pub fn with_calibration(self, file: &Path) -> Result<Self, HostConfigError> {
        let text = layers::read(file, "calibration")?;
        let name = file.display().to_string();
        let calibrated = Calibration::parse(&text)
            .map_err(|error| HostConfigError::of_toml(&name, &text, &error))?;
        calibrated
            .apply(PipelineConfig::observing(Signal::Displacement, calibrated.sample_rate()))
            .check()
            .map_err(|source| HostConfigError::Value {
                place: Place { source: name, at: None },
                inherited: false,
                source: source.into(),
            })?;
        Ok(Self { calibrated: Some(calibrated), ..self })
    }

    /// What the calibration, where there is one, knows of a stylus.
    #[must_use]
    pub fn stylus_calibration(&self) -> Option<&StylusCalibration> {
        self.calibrated.as_ref().and_then(Calibration::stylus)
    }

    /// Whether the calibration, where there is one, was made for such a signal.
    ///
    /// # Errors
    /// [`HostConfigError::OtherSignal`] where it was not.
    pub fn check_signal(&self, rate: Hertz, vibration: bool) -> Result<(), HostConfigError> {
        match self.calibrated {
            Some(made) if !made.fits(rate, vibration) => Err(HostConfigError::OtherSignal {
                made_hz: made.sample_rate().0,
                made_vibration: made.stylus().map_or(vibration, |stylus| stylus.vibration),
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

    /// Whose models are taken.
    ///
    /// # Errors
    /// [`KeyError`]; never of settings that were checked.
    pub fn keys(&self) -> Result<ModelKeys, KeyError> {
        ModelKeys::new(&self.model_keys, self.allow_unsigned_models.unwrap_or(false))
    }

    /// The methods as a set.
    #[must_use]
    pub fn methods(&self) -> Methods {
        self.methods.iter().fold(Methods::NONE, |set, &method| set.with(method))
    }

    /// The pipeline of a gripper with these settings, whose stylus measures `signal`. Settings in metres show nothing of a vibration.
    #[must_use]
    pub fn pipeline(&self, signal: Signal, sample_rate: Hertz) -> PipelineConfig {
        let (floor, health) = match signal {
            Signal::Displacement => (self.floor, self.health),
            Signal::Vibration => (self.floor.in_any_unit(), self.health.in_any_unit()),
        };
        self.calibrate(PipelineConfig {
            sample_rate,
            signal,
            floor,
            known_floor: None,
            known_reference: None,
            certificate: None,
            detector: self.detector,
            health,
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
    fn the_default_can_be_written_and_read_back() {
        let text = toml::to_string(&HostConfig::default()).unwrap();
        assert_eq!(HostConfig::parse(Path::new("x"), &text).unwrap(), HostConfig::default());
    }

    #[test]
    fn unknown_keys_and_wrong_types_name_line_and_column() {
        let text = error("[grip]\nf_max_n = 10.0\nforce = 3\n");
        assert!(text.starts_with("gripd.toml:3:1: unknown field `force`, expected"), "{text}");
        assert!(text.ends_with("\n3 | force = 3\n    ^^^^^"), "{text}");
        let text = error("[detector]\ntest = \"fused\"\n");
        assert!(text.contains("has one threshold, detector.interval_s"), "{text}");
        let text = error("port = 7\n");
        assert!(text.starts_with("gripd.toml:1:8: "), "{text}");
        let text = error("[grip\n");
        assert!(text.starts_with("gripd.toml:1:"), "{text}");
    }

    #[test]
    fn impossible_limits_name_line_column_and_range() {
        let text = error("# limits\n[grip]\nf_max_n = 10.0\ntrial_force_n = 20.0\n");
        assert_eq!(text, "gripd.toml:4:1: grip.trial_force_n = 20 is outside 0.01 to 10");
        let text = error("[detector]\nshear = { low_hz = 500.0, high_hz = 90.0 }\n");
        assert_eq!(text, "gripd.toml:2:11: detector.shear.low_hz = 500 is outside 0.001 to 90");
        assert_eq!(error("baud = 0\n"), "gripd.toml:1:1: baud = 0 is outside 1 to 1000000000");
        assert!(error("baud = 1200\n").starts_with("gripd.toml:1:1: baud 1200 is not used"));
        let error = HostConfig::parse(Path::new("x"), "[link]\nttl_ms = 5").unwrap_err();
        let HostConfigError::Value { place, inherited: false, .. } = error else {
            panic!("{error}")
        };
        assert_eq!(place.at, Some((2, 1)));
        assert!(HostConfig::parse(Path::new("x"), "[grip]\nf_max_n = nan").is_err());
    }

    #[test]
    fn a_missing_file_is_named() {
        let text = HostConfig::read(Path::new("nowhere.toml")).unwrap_err().to_string();
        assert!(text.starts_with("nowhere.toml: "), "{text}");
    }
}
