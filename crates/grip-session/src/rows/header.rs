//! Parser of the first line of the rows: their columns, rate and format.

use crate::replay;
use core::str::FromStr;
use grip_link::message::{Channel, ChannelKind, MAX_CHANNELS, MAX_ELEMENTS, Unit};
use grip_record::StylusKind;

/// Least and largest rate (Hz).
const RATES: core::ops::RangeInclusive<f64> = 50.0..=20_000.0;
/// What there is beside taxels.
const NAMES: &str = "t_s, stylus or vibration, force_n, tangential_n, travel_m, travel_mm, velocity_m_s, stylus2, \
                     reference, pressure, pressure_0 to pressure_63";

/// How rows stand in the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowFormat {
    /// A line of text each, with commas between the values.
    Csv,
    /// A f32 in little endian for each column, nothing between.
    F32,
}

/// The content of the first line.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Names of the columns as they were written, without `t_s`.
    pub names: Vec<String>,
    /// Place of `t_s` among all columns, where it is there.
    pub time: Option<usize>,
    /// What the columns are on the link, in their order; taxels are one channel.
    pub channels: Vec<Channel>,
    /// From the number of each column to the unit of its channel.
    pub factors: Vec<f32>,
    /// Place of the stylus or vibration among the columns without `t_s`, where it is there.
    pub stylus: Option<usize>,
    /// Rows a second.
    pub rate_hz: f64,
    /// How rows stand in the stream.
    pub format: RowFormat,
}

/// Why a line is no header.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HeaderError {
    /// It is no text, or too long.
    #[error("the header is no line of text: expected something like `vibration,rate=1600`")]
    NoText,
    /// A column that rows do not have.
    #[error("header: `{0}` is no column: expected {NAMES}")]
    Column(String),
    /// Axes, which the link does not carry.
    #[error(
        "header: `{0}`: only one axis of vibration is carried; send the one along the slip, without gravity, as `vibration`"
    )]
    Axis(String),
    /// A column that stands there twice.
    #[error("header: `{0}` stands there twice")]
    Twice(String),
    /// Nothing that shows a slip, or stylus and vibration.
    #[error(
        "header: one column `stylus` (m) or `vibration` (any unit) is needed, {0} are there; without one, `travel_m` or 3 taxels show slips \
         later, and nothing else does"
    )]
    Stylus(usize),
    /// Taxels that are not numbered from 0 on, side by side.
    #[error(
        "header: taxels are pressure_0, pressure_1 and so on, side by side, at most 64; `{0}` is out of place"
    )]
    Taxels(String),
    /// A word with `=` that is no setting.
    #[error("header: `{0}` is no setting: expected rate=HZ, format=csv or format=f32")]
    Setting(String),
    /// No rate.
    #[error("header: the rate is missing: add the rows a second, as in `vibration,rate=1600`")]
    NoRate,
    /// A rate that is none.
    #[error("header: rate={0}: expected 50 to 20000 rows a second")]
    Rate(String),
    /// A time as f32.
    #[error(
        "header: packed rows have no t_s, for which f32 is too coarse: leave it out, rate= times the rows"
    )]
    PackedTime,
    /// More columns than the link has channels.
    #[error("header: {0} columns, at most {MAX_CHANNELS} and an array are carried")]
    Many(usize),
}

impl FromStr for Header {
    type Err = HeaderError;

    fn from_str(line: &str) -> Result<Self, HeaderError> {
        let (mut rate_hz, mut format, mut columns) = (None, RowFormat::Csv, Vec::new());
        for word in line.trim_start_matches('\u{feff}').trim().split(',').map(str::trim) {
            match word.split_once('=') {
                None => columns.push(word),
                Some(("rate", text)) => rate_hz = Some(rate(text)?),
                Some(("format", "csv")) => format = RowFormat::Csv,
                Some(("format", "f32")) => format = RowFormat::F32,
                Some(_) => return Err(HeaderError::Setting(word.to_owned())),
            }
        }
        let time = columns.iter().position(|name| *name == "t_s");
        let names: Vec<String> = columns
            .iter()
            .enumerate()
            .filter(|(place, _)| Some(*place) != time)
            .map(|(_, name)| (*name).to_owned())
            .collect();
        if let Some(twice) = names.iter().enumerate().find(|(at, name)| names[..*at].contains(name))
        {
            return Err(HeaderError::Twice(twice.1.clone()));
        }
        let (channels, factors) = channels(&names)?;
        let is_stylus = |name: &String| name == "stylus" || name == "vibration";
        let found: Vec<usize> = names
            .iter()
            .enumerate()
            .filter(|(_, name)| is_stylus(name))
            .map(|(at, _)| at)
            .collect();
        // Fewer taxels than three have no distribution that could change.
        let slow = |channel: &Channel| match channel.kind {
            ChannelKind::PressureArray => channel.count >= 3,
            kind => kind == ChannelKind::Travel,
        };
        let stylus = match found.as_slice() {
            [stylus] => Some(*stylus),
            [] if channels.iter().any(slow) => None,
            _ => return Err(HeaderError::Stylus(found.len())),
        };
        let rate_hz = rate_hz.ok_or(HeaderError::NoRate)?;
        if format == RowFormat::F32 && time.is_some() {
            return Err(HeaderError::PackedTime);
        }
        Ok(Self { names, time, channels, factors, stylus, rate_hz, format })
    }
}

impl Header {
    /// Values of a row, with `t_s`.
    #[must_use]
    pub fn values(&self) -> usize {
        self.names.len() + usize::from(self.time.is_some())
    }

    /// What a session with these columns cannot do, where that is worth a sentence at its start.
    #[must_use]
    pub fn limits(&self) -> Option<String> {
        let array = self.channels.iter().find(|c| c.kind == ChannelKind::PressureArray);
        let taxels = array.map_or(0, |array| usize::from(array.count));
        let limits =
            replay::limits(StylusKind::Absent, taxels).filter(|_| self.stylus.is_none())?;
        Some(format!("{limits}; nothing is commanded"))
    }

    /// Time between two rows (us).
    #[must_use]
    pub fn period_us(&self) -> f64 {
        1e6 / self.rate_hz
    }
}

fn rate(text: &str) -> Result<f64, HeaderError> {
    let rate = text.parse().ok().filter(|rate| RATES.contains(rate));
    rate.ok_or_else(|| HeaderError::Rate(text.to_owned()))
}

/// The channels of the link that these columns are, and the factor of each column.
fn channels(names: &[String]) -> Result<(Vec<Channel>, Vec<f32>), HeaderError> {
    let mut channels: Vec<Channel> = Vec::new();
    let mut factors = Vec::new();
    for name in names {
        if let Some(number) = name.strip_prefix("pressure_") {
            let place = channels.iter().position(|c| c.kind == ChannelKind::PressureArray);
            let last = channels.len().wrapping_sub(1);
            let expected = match place {
                None => 0,
                Some(at) if at == last => channels.get(at).map_or(0, |array| array.count),
                Some(_) => MAX_ELEMENTS,
            };
            if expected >= MAX_ELEMENTS || number != expected.to_string() {
                return Err(HeaderError::Taxels(name.clone()));
            }
            match channels.last_mut().filter(|_| place.is_some()) {
                Some(array) => array.count += 1,
                None => channels.push(channel(ChannelKind::PressureArray, Unit::None)),
            }
            factors.push(1.0);
        } else {
            let (channel, factor) = column(name)?;
            channels.push(channel);
            factors.push(factor);
        }
    }
    if channels.len() > MAX_CHANNELS {
        return Err(HeaderError::Many(names.len()));
    }
    Ok((channels, factors))
}

/// What one column is.
fn column(name: &str) -> Result<(Channel, f32), HeaderError> {
    use ChannelKind as Kind;
    let own = |kind: Kind| channel(kind, kind.unit());
    Ok(match name {
        "stylus" => (own(Kind::Stylus), 1.0),
        "vibration" => (channel(Kind::Stylus, Unit::None), 1.0),
        "force_n" => (own(Kind::NormalForce), 1.0),
        "tangential_n" => (own(Kind::TangentialForce), 1.0),
        "travel_m" => (own(Kind::Travel), 1.0),
        "travel_mm" => (own(Kind::Travel), 1e-3),
        "velocity_m_s" => (own(Kind::Velocity), 1.0),
        "stylus2" => (own(Kind::SecondStylus), 1.0),
        "reference" => (channel(Kind::Reference, Unit::None), 1.0),
        "pressure" => (channel(Kind::Pressure, Unit::None), 1.0),
        axis if axis.starts_with("vibration_") || axis.starts_with("reference_") => {
            return Err(HeaderError::Axis(axis.to_owned()));
        }
        other => return Err(HeaderError::Column(other.chars().take(40).collect())),
    })
}

/// A channel of one element as f32.
fn channel(kind: ChannelKind, unit: Unit) -> Channel {
    Channel { unit, formats: 2, ..Channel::single(kind, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::{Header, HeaderError, RowFormat};
    use grip_link::message::{ChannelKind, Unit};

    fn error(line: &str) -> HeaderError {
        line.parse::<Header>().unwrap_err()
    }

    #[test]
    fn columns_rate_and_format_are_named() {
        let header: Header = "\u{feff}t_s, vibration ,travel_mm,rate=1612.5\r".parse().unwrap();
        assert_eq!((header.time, header.stylus, header.values()), (Some(0), Some(0), 3));
        assert_eq!((header.rate_hz, header.format), (1612.5, RowFormat::Csv));
        assert_eq!(header.channels[0].unit, Unit::None);
        assert_eq!((header.channels[1].kind, header.factors[1]), (ChannelKind::Travel, 1e-3));
        let header: Header = "rate=50,force_n,stylus,format=f32".parse().unwrap();
        assert_eq!((header.stylus, header.format), (Some(1), RowFormat::F32));
        assert_eq!(header.channels[1].unit, Unit::Metre);
    }

    #[test]
    fn a_travel_or_taxels_are_enough() {
        for line in ["force_n,travel_mm,rate=100", "pressure_0,pressure_1,pressure_2,rate=100"] {
            let header: Header = line.parse().unwrap();
            assert_eq!(header.stylus, None);
            assert!(header.limits().unwrap().contains("nothing is commanded"), "{line}");
        }
        assert_eq!(error("pressure_0,pressure_1,rate=100"), HeaderError::Stylus(0));
        let header: Header = "travel_mm,pressure_0,rate=100".parse().unwrap();
        assert!(header.limits().unwrap().contains("fewer than 3 taxels"));
        assert_eq!("vibration,rate=100".parse::<Header>().unwrap().limits(), None);
        assert_eq!(error("force_n,pressure,velocity_m_s,rate=100"), HeaderError::Stylus(0));
    }

    #[test]
    fn taxels_are_one_channel() {
        let header: Header = "stylus,pressure_0,pressure_1,pressure,rate=100".parse().unwrap();
        let counts: Vec<u8> = header.channels.iter().map(|channel| channel.count).collect();
        assert_eq!((counts, header.values()), (vec![1, 2, 1], 4));
        for line in ["stylus,pressure_1,rate=100", "stylus,pressure_0,force_n,pressure_1,rate=100"]
        {
            assert!(matches!(error(line), HeaderError::Taxels(_)), "{line}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let long = "x".repeat(4000);
        let cases = [
            ("", "`` is no column"),
            ("0.1,0.2", "`0.1` is no column"),
            (&long, "is no column"),
            ("vibration", "the rate is missing"),
            ("vibration,rate=0", "rate=0: expected 50 to 20000"),
            ("vibration,rate=nan", "rate=nan"),
            ("vibration,rate=1e9", "rate=1e9"),
            ("vibration,rat=5", "`rat=5` is no setting"),
            ("vibration,rate=100,format=json", "format=csv or format=f32"),
            ("force_n,rate=100", "0 are there"),
            ("stylus,vibration,rate=100", "2 are there"),
            ("vibration,vibration,rate=100", "twice"),
            ("vibration_x,vibration_y,rate=100", "only one axis"),
            ("t_s,vibration,rate=100,format=f32", "too coarse"),
            ("motion,vibration,rate=100", "`motion` is no column"),
        ];
        for (line, words) in cases {
            let text = error(line).to_string();
            assert!(text.contains(words) && text.len() < 300, "{line}: {text}");
        }
    }
}
