//! The curves that a scope can show: name, unit and group of each.

use crate::group::Group;
use slip_core::detector::BANDS;

/// One curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Channel {
    /// The stylus (m), or a vibration in a unit of its own: [`Info::unit`](crate::Info::unit).
    Stylus,
    /// The second stylus (as the first).
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
    /// Evidence of a slip (s): the statistic that the source reports times the wanted interval.
    Statistic,
    /// The same as the scope's own observer has it.
    OwnStatistic,
    /// Energy of a band over its floor, highest of some milliseconds; bands in the order of `DetectorConfig::bands`.
    BandEnergy(u8),
    /// Commanded force (N).
    Command,
    /// Measured normal force, as the state shows it (N).
    Applied,
    /// Estimate of the adequate force (N).
    Estimate,
    /// The same as the scope's own observer has it (N).
    OwnEstimate,
    /// The observer's estimate where the slip speed is one standard deviation off, the lower one (N).
    EstimateLow,
    /// The observer's estimate where the slip speed is one standard deviation off, the higher one (N).
    EstimateHigh,
    /// Median of the normal force that the object needs at full weight (N).
    Need,
    /// Its 10 % quantile (N).
    NeedLow,
    /// Its 90 % quantile (N).
    NeedHigh,
    /// Normal force of each finger that the object needs now, where a simulator knows it (N).
    NeedTruth,
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
    const OTHERS: [Self; 20] = [
        Self::Statistic,
        Self::OwnStatistic,
        Self::Command,
        Self::Applied,
        Self::Estimate,
        Self::OwnEstimate,
        Self::EstimateLow,
        Self::EstimateHigh,
        Self::Need,
        Self::NeedLow,
        Self::NeedHigh,
        Self::NeedTruth,
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
        let bands = (0..).take(BANDS).map(Self::BandEnergy);
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

    /// Name, name in a CSV file, unit and plot.
    const fn row(self) -> (&'static str, &'static str, &'static str, Group) {
        match self {
            Self::Stylus => ("stylus", "stylus", "", Group::Stylus),
            Self::SecondStylus => ("second stylus", "stylus2", "", Group::Stylus),
            Self::NormalForce => ("normal force", "force_n", "N", Group::Force),
            Self::TangentialForce => ("tangential force", "tangential_n", "N", Group::Force),
            Self::Travel => ("travel", "travel_m", "m", Group::Motion),
            Self::Velocity => ("velocity", "velocity_m_s", "m/s", Group::Motion),
            Self::Reference => ("reference", "reference", "", Group::Reference),
            Self::Pressure => ("pressure", "pressure", "", Group::Pressure),
            Self::Motion => ("commanded motion", "motion", "", Group::Reference),
            Self::Statistic => ("evidence", "evidence_s", "s", Group::Statistic),
            Self::OwnStatistic => ("own evidence", "own_evidence_s", "s", Group::Statistic),
            Self::Command => ("commanded", "command_n", "N", Group::Force),
            Self::Applied => ("applied", "applied_n", "N", Group::Force),
            Self::Estimate => ("estimate", "estimate_n", "N", Group::Force),
            Self::OwnEstimate => ("own estimate", "own_estimate_n", "N", Group::Force),
            Self::EstimateLow => ("estimate, low", "estimate_low_n", "N", Group::Force),
            Self::EstimateHigh => ("estimate, high", "estimate_high_n", "N", Group::Force),
            Self::Need => ("needed force", "need_n", "N", Group::Force),
            Self::NeedLow => ("needed force, 10 %", "need_low_n", "N", Group::Force),
            Self::NeedHigh => ("needed force, 90 %", "need_high_n", "N", Group::Force),
            Self::NeedTruth => ("needed, truth", "need_truth_n", "N", Group::Force),
            Self::ForceLimit => ("limit", "limit_n", "N", Group::Force),
            Self::Esc => ("E_sc", "esc", "W", Group::Esc),
            Self::OwnEsc => ("own E_sc", "own_esc", "W", Group::Esc),
            Self::EscLow => ("E_sc, lower bound", "esc_low", "W", Group::Esc),
            Self::EscHigh => ("E_sc, upper bound", "esc_high", "W", Group::Esc),
            Self::EscFlags => ("E_sc, flags", "esc_flags", "", Group::Esc),
            Self::SlipSpeed => ("slip speed", "slip_speed_m_s", "m/s", Group::Motion),
            Self::SlipSpeedSigma => {
                ("slip speed, deviation", "slip_speed_sigma_m_s", "m/s", Group::Motion)
            }
            Self::BandEnergy(_) => ("band", "band_{}_energy", "", Group::Bands),
        }
    }

    /// What a legend states.
    #[must_use]
    pub fn name(self) -> &'static str {
        let band = match self {
            Self::BandEnergy(band) => BAND_NAMES.get(usize::from(band)).copied(),
            _ => None,
        };
        band.unwrap_or(self.row().0)
    }

    /// What its name does not say.
    #[must_use]
    pub const fn about(self) -> &'static str {
        match self {
            Self::OwnStatistic | Self::OwnEstimate | Self::OwnEsc => {
                "computed by this window from the samples, beside what the source reports"
            }
            Self::NeedTruth => "what the simulator knows that the object needs now",
            Self::Need => "force that the object needs at full weight: 10, 50 and 90 % quantile",
            Self::Applied => "normal force as the pipeline sees it",
            _ => "",
        }
    }

    /// Its name in a CSV file: lower case, with the unit where it has one.
    #[must_use]
    pub fn column(self) -> String {
        match self {
            Self::BandEnergy(band) => self.row().1.replace("{}", &band.to_string()),
            _ => self.row().1.to_owned(),
        }
    }

    /// Its unit whatever the source; empty where it has none, or one of its own.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        self.row().2
    }

    /// The plot it belongs in.
    #[must_use]
    pub const fn group(self) -> Group {
        self.row().3
    }

    /// Whether it stands in rows of samples, at the sample rate.
    #[must_use]
    pub fn is_row(self) -> bool {
        Self::ROWS.contains(&self)
    }
}

#[cfg(test)]
mod tests {
    use super::{BANDS, Channel};
    use std::collections::BTreeSet;

    #[test]
    fn every_channel_has_a_column_of_its_own_by_which_it_is_found() {
        let all: Vec<Channel> = Channel::all().collect();
        let names: BTreeSet<String> = all.iter().map(|channel| channel.column()).collect();
        assert_eq!((names.len(), all.len()), (all.len(), 9 + 20 + BANDS));
        for channel in all {
            assert_eq!(Channel::of_column(&channel.column()), Some(channel));
        }
        assert_eq!(Channel::of_column("nothing"), None);
        assert_eq!(Channel::BandEnergy(1).name(), "vibration");
    }
}
