//! The curves that a scope can show: name, unit and group of each.

use crate::group::Group;
use slip_core::detector::BANDS;

/// One curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Channel {
    /// The stylus (m, or the sensor's own unit).
    Stylus,
    /// The second stylus (m).
    SecondStylus,
    /// Normal force of one finger as every sample has it (N).
    NormalForce,
    /// Tangential force (N).
    TangentialForce,
    /// Moved distance (m).
    Travel,
    /// Slip speed as measured (m/s).
    Velocity,
    /// Motion reference (own unit).
    Reference,
    /// Static pressure (own unit).
    Pressure,
    /// Commanded motion: 0 stands still.
    Motion,
    /// Slip statistic over its threshold, as the source tells it.
    Statistic,
    /// The same as the scope's own observer has it.
    OwnStatistic,
    /// Energy of a band over its floor, highest of some milliseconds; bands in the order of `DetectorConfig::bands`.
    BandEnergy(u8),
    /// Energy over floor at which that band is a slip, own motion included.
    BandThreshold(u8),
    /// Commanded force (N).
    Command,
    /// Measured normal force, as the state tells it (N).
    Applied,
    /// Estimate of the adequate force (N).
    Estimate,
    /// The same as the scope's own observer has it (N).
    OwnEstimate,
    /// The observer's estimate where the slip speed is one standard deviation off, the lower one (N).
    EstimateLow,
    /// The observer's estimate where the slip speed is one standard deviation off, the higher one (N).
    EstimateHigh,
    /// Largest force of the controller (N).
    ForceLimit,
    /// E_sc (W or J, see [`Info::esc_unit`](crate::Info)).
    Esc,
    /// E_sc as the scope's own observer has it; the same where it saw the same samples with the same settings.
    OwnEsc,
    /// Lower end of the enclosure of the observer's E_sc.
    EscLow,
    /// Upper end of the enclosure of the observer's E_sc.
    EscHigh,
    /// Flags of E_sc as a whole number, see [`EscPoint::flags`](crate::feed::EscPoint): no curve.
    EscFlags,
    /// Slip speed as the observer has it (m/s).
    SlipSpeed,
    /// Its standard deviation (m/s).
    SlipSpeedSigma,
}

/// Names of the bands in the detector's order.
const BAND_NAMES: [&str; BANDS] =
    ["shear", "vibration", "octave 1", "octave 2", "octave 3", "octave 4"];

impl Channel {
    /// Channels that stand in rows of samples, in the order of the wire.
    pub const ROWS: [Self; 9] = [
        Self::Stylus,
        Self::NormalForce,
        Self::TangentialForce,
        Self::Travel,
        Self::Velocity,
        Self::SecondStylus,
        Self::Reference,
        Self::Pressure,
        Self::Motion,
    ];

    /// Every channel that is no band.
    const OTHERS: [Self; 16] = [
        Self::Statistic,
        Self::OwnStatistic,
        Self::Command,
        Self::Applied,
        Self::Estimate,
        Self::OwnEstimate,
        Self::EstimateLow,
        Self::EstimateHigh,
        Self::ForceLimit,
        Self::Esc,
        Self::OwnEsc,
        Self::EscLow,
        Self::EscHigh,
        Self::EscFlags,
        Self::SlipSpeed,
        Self::SlipSpeedSigma,
    ];

    /// Every channel.
    pub fn all() -> impl Iterator<Item = Self> {
        let bands = (0..).take(BANDS);
        let bands = bands.flat_map(|band| [Self::BandEnergy(band), Self::BandThreshold(band)]);
        Self::ROWS.into_iter().chain(Self::OTHERS).chain(bands)
    }

    /// The channel that a CSV file calls so.
    #[must_use]
    pub fn of_column(name: &str) -> Option<Self> {
        Self::all().find(|channel| channel.column() == name)
    }

    /// The same channel of a recording's samples, where it is one that they may lack.
    #[must_use]
    pub const fn recorded(self) -> Option<grip_record::Channel> {
        use grip_record::Channel as Recorded;
        Some(match self {
            Self::NormalForce => Recorded::NormalForce,
            Self::TangentialForce => Recorded::Tangential,
            Self::Travel => Recorded::Travel,
            Self::Velocity => Recorded::Velocity,
            Self::SecondStylus => Recorded::SecondStylus,
            Self::Reference => Recorded::Reference,
            Self::Pressure => Recorded::Pressure,
            Self::Motion => Recorded::Motion,
            _ => return None,
        })
    }

    /// What a legend says.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Stylus => "stylus",
            Self::SecondStylus => "second stylus",
            Self::NormalForce => "normal force",
            Self::TangentialForce => "tangential force",
            Self::Travel => "travel",
            Self::Velocity => "velocity",
            Self::Reference => "reference",
            Self::Pressure => "pressure",
            Self::Motion => "commanded motion",
            Self::Statistic => "statistic",
            Self::OwnStatistic => "own statistic",
            Self::BandEnergy(band) => band_name(band),
            Self::BandThreshold(_) => "threshold",
            Self::Command => "commanded",
            Self::Applied => "applied",
            Self::Estimate => "estimate",
            Self::OwnEstimate => "own estimate",
            Self::EstimateLow => "estimate, low",
            Self::EstimateHigh => "estimate, high",
            Self::ForceLimit => "limit",
            Self::Esc => "E_sc",
            Self::OwnEsc => "own E_sc",
            Self::EscLow => "E_sc, lower bound",
            Self::EscHigh => "E_sc, upper bound",
            Self::EscFlags => "E_sc, flags",
            Self::SlipSpeed => "slip speed",
            Self::SlipSpeedSigma => "slip speed, deviation",
        }
    }

    /// Its name in a CSV file: lower case, with the unit where it has one.
    #[must_use]
    pub fn column(self) -> String {
        match self {
            Self::Stylus => "stylus".to_owned(),
            Self::SecondStylus => "stylus2".to_owned(),
            Self::NormalForce => "force_n".to_owned(),
            Self::TangentialForce => "tangential_n".to_owned(),
            Self::Travel => "travel_m".to_owned(),
            Self::Velocity => "velocity_m_s".to_owned(),
            Self::Reference => "reference".to_owned(),
            Self::Pressure => "pressure".to_owned(),
            Self::Motion => "motion".to_owned(),
            Self::Statistic => "statistic".to_owned(),
            Self::OwnStatistic => "own_statistic".to_owned(),
            Self::BandEnergy(band) => format!("band_{band}_energy"),
            Self::BandThreshold(band) => format!("band_{band}_threshold"),
            Self::Command => "command_n".to_owned(),
            Self::Applied => "applied_n".to_owned(),
            Self::Estimate => "estimate_n".to_owned(),
            Self::OwnEstimate => "own_estimate_n".to_owned(),
            Self::EstimateLow => "estimate_low_n".to_owned(),
            Self::EstimateHigh => "estimate_high_n".to_owned(),
            Self::ForceLimit => "limit_n".to_owned(),
            Self::Esc => "esc".to_owned(),
            Self::OwnEsc => "own_esc".to_owned(),
            Self::EscLow => "esc_low".to_owned(),
            Self::EscHigh => "esc_high".to_owned(),
            Self::EscFlags => "esc_flags".to_owned(),
            Self::SlipSpeed => "slip_speed_m_s".to_owned(),
            Self::SlipSpeedSigma => "slip_speed_sigma_m_s".to_owned(),
        }
    }

    /// Its unit; empty where it has none, or one of its own.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Stylus | Self::SecondStylus | Self::Travel => "m",
            Self::NormalForce
            | Self::TangentialForce
            | Self::Command
            | Self::Applied
            | Self::Estimate
            | Self::OwnEstimate
            | Self::EstimateLow
            | Self::EstimateHigh
            | Self::ForceLimit => "N",
            Self::Velocity | Self::SlipSpeed | Self::SlipSpeedSigma => "m/s",
            Self::Esc | Self::OwnEsc | Self::EscLow | Self::EscHigh => "W",
            _ => "",
        }
    }

    /// The plot it belongs in.
    #[must_use]
    pub const fn group(self) -> Group {
        match self {
            Self::Stylus | Self::SecondStylus => Group::Stylus,
            Self::Travel | Self::Velocity | Self::SlipSpeed | Self::SlipSpeedSigma => Group::Motion,
            Self::Reference | Self::Motion => Group::Reference,
            Self::Pressure => Group::Pressure,
            Self::Statistic | Self::OwnStatistic => Group::Statistic,
            Self::BandEnergy(_) | Self::BandThreshold(_) => Group::Bands,
            Self::Esc | Self::OwnEsc | Self::EscLow | Self::EscHigh | Self::EscFlags => Group::Esc,
            _ => Group::Force,
        }
    }

    /// Whether it stands in rows of samples, at the sample rate.
    #[must_use]
    pub fn is_row(self) -> bool {
        Self::ROWS.contains(&self)
    }
}

fn band_name(band: u8) -> &'static str {
    BAND_NAMES.get(usize::from(band)).copied().unwrap_or("band")
}

#[cfg(test)]
mod tests {
    use super::{BANDS, Channel};
    use std::collections::BTreeSet;

    #[test]
    fn every_channel_has_a_column_of_its_own_by_which_it_is_found() {
        let all: Vec<Channel> = Channel::all().collect();
        let names: BTreeSet<String> = all.iter().map(|channel| channel.column()).collect();
        assert_eq!((names.len(), all.len()), (all.len(), 9 + 16 + 2 * BANDS));
        for channel in all {
            assert_eq!(Channel::of_column(&channel.column()), Some(channel));
        }
        assert_eq!(Channel::of_column("nothing"), None);
        assert_eq!(Channel::BandEnergy(1).name(), "vibration");
    }
}
