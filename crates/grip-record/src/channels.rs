//! Channels of a recording: column names and the fields of a `Sample` they fill.

use std::collections::BTreeMap;

use slip_core::sample::Sample;

/// What the stylus column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StylusKind {
    /// Column `stylus`: displacement along the stylus axis (m).
    Displacement,
    /// Column `vibration`: an uncalibrated vibration signal in the sensor's own units (counts).
    Vibration,
    /// No such column: taxels or a measured travel stand for themselves. Samples hold 0.
    Absent,
}

impl StylusKind {
    /// The column's name in a file, where there is one.
    #[must_use]
    pub const fn column(self) -> Option<&'static str> {
        match self {
            Self::Displacement => Some("stylus"),
            Self::Vibration => Some("vibration"),
            Self::Absent => None,
        }
    }
}

slip_msg::named! {
    /// A channel that a gripper may lack; order is the order of the columns written.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum Channel {
        fn column: "The column's name in a file that [`CsvWriter`](super::CsvWriter) writes.";
    }
    NormalForce: "Normal force of one finger (N).", "force_n";
    Tangential: "Tangential force on one finger (N).", "tangential_n";
    Travel: "Moved distance of the object (m).", "travel_m";
    Velocity: "Slip speed measured directly (m/s).", "velocity_m_s";
    SecondStylus: "Second stylus (m).", "stylus2";
    Reference: "Motion reference (own units).", "reference";
    Pressure: "Static pressure of the fingertip (own units).", "pressure";
    Motion: "Commanded motion of arm or fingers: 0 at rest, anything else in motion.", "motion";
}

impl Channel {
    /// The reading of this channel in `sample`, in the unit given at the variant.
    #[must_use]
    pub const fn reading(self, sample: &Sample) -> Option<f32> {
        match self {
            Self::NormalForce => sample.normal_force_n,
            Self::Tangential => sample.tangential_n,
            Self::Travel => sample.travel_m,
            Self::Velocity => sample.velocity_m_s,
            Self::SecondStylus => sample.second_stylus,
            Self::Reference => sample.reference,
            Self::Pressure => sample.pressure,
            Self::Motion => sample.motion,
        }
    }

    /// Puts a reading of this channel into `sample`, in the unit given at the variant, or takes it out.
    pub const fn set(self, sample: &mut Sample, value: Option<f32>) {
        match self {
            Self::NormalForce => sample.normal_force_n = value,
            Self::Tangential => sample.tangential_n = value,
            Self::Travel => sample.travel_m = value,
            Self::Velocity => sample.velocity_m_s = value,
            Self::SecondStylus => sample.second_stylus = value,
            Self::Reference => sample.reference = value,
            Self::Pressure => sample.pressure = value,
            Self::Motion => sample.motion = value,
        }
    }
}

/// The channels a recording holds, each with the name of the column it came from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelSet {
    /// What the stylus column holds.
    pub stylus: StylusKind,
    /// The file's name of the stylus column, where there is one.
    pub stylus_source: Option<String>,
    /// Names of the columns of all axes of the vibration sensor, `vibration_x` and so on; empty where it has one.
    pub axes: Vec<String>,
    /// The same of the motion reference.
    pub reference_axes: Vec<String>,
    /// The file's name of the time column; `None` where the times come from a rate.
    pub time_source: Option<String>,
    /// The optional channels present and the file's names of their columns.
    pub optional: BTreeMap<Channel, String>,
    /// Taxels of the array (`pressure_0` and so on), 0 where there is none.
    pub taxels: usize,
    /// Whether it reports when the computer took each sample in, and how old it was then.
    pub arrivals: bool,
}

/// Columns of host time of arrival and of age (us), whole numbers.
pub(crate) const ARRIVAL: [&str; 2] = ["arrived_us", "age_us"];

impl ChannelSet {
    /// Time and stylus only.
    #[must_use]
    pub fn new(stylus: StylusKind) -> Self {
        Self {
            stylus,
            stylus_source: stylus.column().map(str::to_owned),
            axes: Vec::new(),
            reference_axes: Vec::new(),
            time_source: Some("t_s".to_owned()),
            optional: BTreeMap::new(),
            taxels: 0,
            arrivals: false,
        }
    }

    /// The same set with the arrival of each sample.
    #[must_use]
    pub fn with_arrivals(mut self) -> Self {
        self.arrivals = true;
        self
    }

    /// The same set and `channel`, under the name the writer gives it.
    #[must_use]
    pub fn with(mut self, channel: Channel) -> Self {
        self.optional.insert(channel, channel.column().to_owned());
        self
    }

    /// The same set and an array of `count` taxels.
    #[must_use]
    pub fn with_taxels(mut self, count: usize) -> Self {
        self.taxels = count;
        self
    }

    /// Time, stylus and every optional channel.
    #[must_use]
    pub fn all(stylus: StylusKind) -> Self {
        Channel::ALL.into_iter().fold(Self::new(stylus), Self::with)
    }

    /// The same set with these axes of the vibration sensor and of the reference; none or one name where there is one axis.
    #[must_use]
    pub fn with_axes(mut self, vibration: &[&str], reference: &[&str]) -> Self {
        let several = |names: &[&str]| {
            let names = if names.len() > 1 { names } else { &[] };
            names.iter().map(|&name| name.to_owned()).collect()
        };
        (self.axes, self.reference_axes) = (several(vibration), several(reference));
        self
    }

    /// Names of the columns of a written file: stylus or vibration with its axes, then the optional channels.
    #[must_use]
    pub fn columns(&self) -> Vec<&str> {
        let or = |axes: &'static str, all: &Vec<String>| all.is_empty().then_some(axes);
        let mut names: Vec<&str> = self.axes.iter().map(String::as_str).collect();
        names.extend(self.stylus.column().and_then(|column| or(column, &self.axes)));
        for channel in self.optional.keys() {
            match channel {
                Channel::Reference if !self.reference_axes.is_empty() => {
                    names.extend(self.reference_axes.iter().map(String::as_str));
                }
                channel => names.push(channel.column()),
            }
        }
        names
    }

    /// Whether `channel` has a column.
    #[must_use]
    pub fn has(&self, channel: Channel) -> bool {
        self.optional.contains_key(&channel)
    }
}

/// What a column of a known name is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Role {
    Time,
    Stylus(StylusKind),
    Optional(Channel, Scale),
}

/// From the number in the cell to the unit of the `Sample` field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scale {
    Same,
    MilliToUnit,
    By(f64),
}

impl Scale {
    /// The reading in a cell; `None` if the text is no number. `NaN`, `inf` and what overflows to infinity are readings.
    pub(crate) fn parse(self, text: &str) -> Option<f32> {
        match self {
            Self::Same => text.parse().ok(),
            scaled => text.parse().ok().map(|value| scaled.narrow(value)),
        }
    }

    /// A number in the unit of its `Sample` field, with the 24 bits of a reading.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "rounding to the precision of a Sample is the purpose"
    )]
    pub(crate) fn narrow(self, value: f64) -> f32 {
        (match self {
            Self::Same => value,
            Self::MilliToUnit => value / 1000.0,
            Self::By(by) => value * by,
        }) as f32
    }
}

/// Every column name the reader knows; the left side of a renaming must be one of them.
pub const COLUMN_NAMES: [&str; 12] = [
    "t_s",
    "stylus",
    "vibration",
    "force_n",
    "tangential_n",
    "travel_m",
    "travel_mm",
    "velocity_m_s",
    "stylus2",
    "reference",
    "pressure",
    "motion",
];

impl Role {
    pub(crate) fn of(name: &str) -> Option<Self> {
        match name {
            "t_s" => Some(Self::Time),
            "stylus" => Some(Self::Stylus(StylusKind::Displacement)),
            "vibration" => Some(Self::Stylus(StylusKind::Vibration)),
            "travel_mm" => Some(Self::Optional(Channel::Travel, Scale::MilliToUnit)),
            other => Channel::ALL
                .into_iter()
                .find(|channel| channel.column() == other)
                .map(|channel| Self::Optional(channel, Scale::Same)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_known_name_has_a_role() {
        for name in COLUMN_NAMES {
            assert!(Role::of(name).is_some(), "{name}");
        }
        assert_eq!(Role::of("acceleration"), None);
    }

    #[test]
    fn a_channel_returns_what_was_set() {
        for channel in Channel::ALL {
            let mut sample = Sample::default();
            channel.set(&mut sample, Some(2.5));
            assert_eq!(channel.reading(&sample), Some(2.5));
            let others =
                Channel::ALL.into_iter().filter(|other| other.reading(&sample).is_some()).count();
            assert_eq!(others, 1, "{channel:?} fills one field");
        }
    }
}
