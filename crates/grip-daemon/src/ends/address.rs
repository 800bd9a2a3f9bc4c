//! Addresses of ends, from names such as `robotiq:2f-85:/dev/ttyUSB0,activate`.

use super::{RowsAddress, RowsAddressError};
use core::fmt;
use grip_robotiq::{
    Model, ModelError,
    gripper::GripperConfig,
    tsf85::{RAIL, Tsf85Config},
};
use grip_session::gripper::GripperSpec;
use slip_core::health::HealthConfig;

/// Bits per second of Robotiq's grippers and fingertips as they are delivered.
const ROBOTIQ_BAUD: u32 = 115_200;
/// First-order lag (s) from an acknowledged force register to the force: registers taken over at 200 Hz, and a motor. Our estimate, that
/// of `grippers/industrial.toml`; no gripper was measured.
const ROBOTIQ_LAG_S: f32 = 0.015;

/// What measures.
#[derive(Clone, Debug, PartialEq)]
pub enum SensorAddress {
    /// Rows of another program.
    Rows(RowsAddress),
    /// The fingertips TSF-85.
    Tsf85 {
        /// The serial port.
        port: String,
        /// Which signals.
        config: Tsf85Config,
    },
    /// A board that speaks the link.
    Board {
        /// The serial port.
        port: String,
    },
}

/// What grips, on another line than that of the sensor.
#[derive(Clone, Debug, PartialEq)]
pub enum GripperAddress {
    /// A gripper of Robotiq on Modbus RTU.
    Robotiq {
        /// The serial port.
        port: String,
        /// Bits per second.
        baud: u32,
        /// Which one, and how.
        config: GripperConfig,
    },
    /// A board that speaks the link.
    Board {
        /// The serial port.
        port: String,
    },
}

/// Why a name means nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AddressError {
    /// No rows.
    #[error(transparent)]
    Rows(#[from] RowsAddressError),
    /// No model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// No port.
    #[error("`{0}` names no port: expected tsf85:PORT or robotiq:MODEL:PORT")]
    Port(String),
    /// A gripper in the place of a sensor.
    #[error(
        "`{0}`: this gripper feels no slip; name it with --gripper, and what feels the slip with --sensor"
    )]
    Numb(String),
    /// A force with which this gripper cannot hold.
    #[error("`{word}`: a {model} holds with {} to {} N", model.force_min_n(), model.force_max_n())]
    Holds {
        /// The word.
        word: String,
        /// The gripper.
        model: Model,
    },
    /// A force that this gripper cannot stay under.
    #[error("grip.f_max_n is {f_max_n} N, and a {model} presses with {} N at least", model.force_min_n())]
    Most {
        /// Largest force that is allowed (N).
        f_max_n: f32,
        /// The gripper.
        model: Model,
    },
    /// A word that is no setting.
    #[error("`{word}` is no setting of {of}: expected {expected}")]
    Setting {
        /// The word.
        word: String,
        /// Of what.
        of: &'static str,
        /// What there is.
        expected: &'static str,
    },
}

/// Settings of a TSF-85.
const TSF85: &str = "finger=0 to finger=3, or reference";
/// Settings of a Robotiq gripper.
const ROBOTIQ: &str = "activate, holds=N (newtons, within its range), speed=0 to speed=255, unit=1 to unit=247, or baud=BITS";

impl SensorAddress {
    /// The range that the sensor is known to have, unless another one is set: one wrong bit of a line puts a reading at its end, which is
    /// no evidence of a slip.
    pub fn limit(&self, health: &mut HealthConfig) {
        if matches!(self, Self::Tsf85 { .. }) && health.range == HealthConfig::default().range {
            health.range = RAIL;
        }
    }

    /// The sensor that `name` means.
    ///
    /// # Errors
    /// Where it begins as one of those below and goes on as none, or is a gripper that feels nothing.
    pub fn parse(name: &str) -> Result<Self, AddressError> {
        if let Some(rows) = RowsAddress::of_port(name)? {
            return Ok(Self::Rows(rows));
        }
        if name.starts_with("robotiq:") {
            return Err(AddressError::Numb(name.to_owned()));
        }
        let Some(rest) = name.strip_prefix("tsf85:") else {
            return Ok(Self::Board { port: name.to_owned() });
        };
        let (port, words) = port(name, rest)?;
        let mut config = Tsf85Config::default();
        for word in words {
            match (word, word.strip_prefix("finger=").and_then(|text| text.parse().ok())) {
                ("reference", _) => config.reference = true,
                (_, Some(finger @ 0..=3)) => config.finger = finger,
                _ => return Err(setting(word, "tsf85", TSF85)),
            }
        }
        Ok(Self::Tsf85 { port, config })
    }

    /// Its serial port and its bits per second, where they are not those of a board.
    pub(super) fn line(&self) -> Option<(&str, Option<u32>)> {
        match self {
            Self::Rows(_) => None,
            Self::Tsf85 { port, .. } => Some((port, Some(ROBOTIQ_BAUD))),
            Self::Board { port } => Some((port, None)),
        }
    }
}

impl GripperAddress {
    /// The gripper that `name` means.
    ///
    /// # Errors
    /// Where it begins as one of Robotiq's and goes on as none.
    pub fn parse(name: &str) -> Result<Self, AddressError> {
        let Some(rest) = name.strip_prefix("robotiq:") else {
            return Ok(Self::Board { port: name.to_owned() });
        };
        let (model, rest) =
            rest.split_once(':').ok_or_else(|| AddressError::Port(name.to_owned()))?;
        let (port, words) = port(name, rest)?;
        let (mut config, mut baud) = (GripperConfig::new(model.parse::<Model>()?), ROBOTIQ_BAUD);
        for word in words {
            let wrong = || setting(word, "robotiq", ROBOTIQ);
            match word.split_once('=') {
                None if word == "activate" => config.activate = true,
                Some(("holds", text)) => {
                    let model = config.model;
                    let force_n = text.parse::<f32>().ok().filter(|force_n| force_n.is_finite());
                    let force_n = force_n.ok_or_else(wrong)?;
                    if !(model.force_min_n()..=model.force_max_n()).contains(&force_n) {
                        return Err(AddressError::Holds { word: word.to_owned(), model });
                    }
                    config.holds_n = Some(force_n);
                }
                Some(("speed", text)) => config.speed = text.parse().map_err(|_| wrong())?,
                Some(("unit", text)) => {
                    let unit = text.parse().ok().filter(|unit| (1..=247).contains(unit));
                    config.unit = unit.ok_or_else(wrong)?;
                }
                Some(("baud", text)) => {
                    let bits = text.parse().ok().filter(|bits| (9600..=1_000_000).contains(bits));
                    baud = bits.ok_or_else(wrong)?;
                }
                _ => return Err(wrong()),
            }
        }
        Ok(Self::Robotiq { port, baud, config })
    }

    /// Checks that it can press with no more than `f_max_n` (N).
    ///
    /// # Errors
    /// Where its least force is more.
    pub fn check(&self, f_max_n: f32) -> Result<(), AddressError> {
        match *self {
            Self::Robotiq { config: GripperConfig { model, .. }, .. }
                if f_max_n < model.force_min_n() =>
            {
                Err(AddressError::Most { f_max_n, model })
            }
            _ => Ok(()),
        }
    }

    /// What it can do, as far as that is known before it answers.
    #[must_use]
    pub fn spec(&self) -> Option<GripperSpec> {
        let Self::Robotiq { config: GripperConfig { model, .. }, .. } = self else { return None };
        Some(GripperSpec {
            force_min_n: model.force_min_n(),
            force_max_n: model.force_max_n(),
            step_n: model.step_n(),
            lag_s: Some(ROBOTIQ_LAG_S),
        })
    }

    /// Its serial port and its bits per second, where they are not those of a board.
    pub(super) fn line(&self) -> (&str, Option<u32>) {
        match self {
            Self::Robotiq { port, baud, .. } => (port, Some(*baud)),
            Self::Board { port } => (port, None),
        }
    }
}

impl fmt::Display for GripperAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Robotiq { port, config, .. } => write!(f, "{} on {port}", config.model),
            Self::Board { port } => write!(f, "gripper on {port}"),
        }
    }
}

impl fmt::Display for SensorAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rows(rows) => write!(f, "rows from {rows}"),
            Self::Tsf85 { port, .. } => write!(f, "TSF-85 on {port}"),
            Self::Board { port } => write!(f, "sensor on {port}"),
        }
    }
}

/// A port and the words behind it.
fn port<'a>(
    name: &str,
    rest: &'a str,
) -> Result<(String, impl Iterator<Item = &'a str> + use<'a>), AddressError> {
    let mut words = rest.split(',');
    let port = words.next().filter(|port| !port.is_empty());
    let port = port.ok_or_else(|| AddressError::Port(name.to_owned()))?;
    Ok((port.to_owned(), words))
}

fn setting(word: &str, of: &'static str, expected: &'static str) -> AddressError {
    AddressError::Setting { word: word.to_owned(), of, expected }
}

#[cfg(test)]
mod tests {
    use super::{GripperAddress, SensorAddress};
    use grip_robotiq::{Model, gripper::GripperConfig, tsf85::Tsf85Config};
    use slip_core::health::HealthConfig;

    #[test]
    fn names_of_ends() {
        let sensor = SensorAddress::parse("tsf85:/dev/ttyACM0,finger=1,reference");
        let config = Tsf85Config { finger: 1, reference: true };
        assert_eq!(sensor, Ok(SensorAddress::Tsf85 { port: "/dev/ttyACM0".to_owned(), config }));
        assert!(matches!(SensorAddress::parse("rows:-"), Ok(SensorAddress::Rows(_))));
        assert!(matches!(SensorAddress::parse("/dev/ttyACM0"), Ok(SensorAddress::Board { .. })));
        let name = "robotiq:2F-85:/dev/ttyUSB0,activate,holds=40,speed=255,unit=3,baud=57600";
        let config = GripperConfig {
            model: Model::F85,
            unit: 3,
            speed: 255,
            activate: true,
            holds_n: Some(40.0),
        };
        let port = "/dev/ttyUSB0".to_owned();
        assert_eq!(
            GripperAddress::parse(name),
            Ok(GripperAddress::Robotiq { port, baud: 57_600, config })
        );
        let arm = GripperAddress::parse("robotiq:hand-e:tcp:arm:54321,unit=3").unwrap();
        assert_eq!(
            (arm.line().0, arm.to_string()),
            ("tcp:arm:54321", "Hand-E on tcp:arm:54321".to_owned())
        );
        let spec = GripperAddress::parse("robotiq:hand-e:x").unwrap().spec().unwrap();
        assert!((spec.force_min_n, spec.force_max_n) == (20.0, 185.0) && spec.lag_s.is_some());
    }

    #[test]
    fn the_ends_of_the_range_of_fingertips_are_saturated_unless_another_range_is_set() {
        let limited = |name: &str, range| {
            let mut health = HealthConfig { range, ..HealthConfig::default() };
            SensorAddress::parse(name).unwrap().limit(&mut health);
            health.in_any_unit().range
        };
        let usual = HealthConfig::default().range;
        assert_eq!(limited("tsf85:x", usual), 32_767.0);
        assert_eq!((limited("tsf85:x", 9.0), limited("/dev/x", usual) > 1e9), (9.0, true));
    }

    #[test]
    fn a_gripper_that_cannot_stay_under_the_most_is_refused() {
        let gripper = GripperAddress::parse("robotiq:2f-85:x").unwrap();
        let text = gripper.check(15.0).unwrap_err().to_string();
        assert!(text.contains("15 N") && text.contains("20 N"), "{text}");
        assert_eq!(gripper.check(20.0), Ok(()));
        assert_eq!(GripperAddress::parse("/dev/ttyACM0").unwrap().check(1.0), Ok(()));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (name, words) in [
            ("tsf85:", "names no port"),
            ("tsf85:x,finger=4", "finger=0 to finger=3"),
            ("rows:x", "no source of rows"),
            ("robotiq:2f-85:tcp:10.0.0.2:54321", "--sensor"),
        ] {
            let text = SensorAddress::parse(name).unwrap_err().to_string();
            assert!(text.contains(words), "{name}: {text}");
        }
        for (name, words) in [
            ("robotiq:/dev/ttyUSB0", "names no port"),
            ("robotiq:3f:/dev/ttyUSB0", "2f-85, 2f-140 or hand-e"),
            ("robotiq:2f-85:", "names no port"),
            ("robotiq:2f-85:x,holds=nan", "holds=N"),
            ("robotiq:2f-85:x,open", "activate"),
            ("robotiq:2f-85:x,holds=15", "`holds=15`: a 2F-85 holds with 20 to 235 N"),
            ("robotiq:2f-140:x,holds=126", "`holds=126`: a 2F-140 holds with 10 to 125 N"),
        ] {
            let text = GripperAddress::parse(name).unwrap_err().to_string();
            assert!(text.contains(words), "{name}: {text}");
        }
    }
}
