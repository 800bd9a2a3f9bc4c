//! The curves that a scope can show: name, unit and column of each.

use slip_core::detector::BANDS;

slip_msg::named! {
    /// One curve.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
    #[non_exhaustive]
    pub enum Channel {
        fn name: "What a legend states.";
        fn column: "Its name in a CSV file: lower case, with the unit where it has one.";
        fn unit: "Its unit whatever the source; empty where it has none, or one of its own.";
    }
    Stylus: "The stylus (m), or a vibration in a unit of its own: `Info::unit`.",
        "stylus", "stylus", "";
    SecondStylus: "The second stylus (as the first).",
        "second stylus", "stylus2", "";
    NormalForce: "Normal force of one finger as every sample has it (N).",
        "normal force", "force_n", "N";
    TangentialForce: "Tangential force (N).",
        "tangential force", "tangential_n", "N";
    Travel: "Moved distance (m).",
        "travel", "travel_m", "m";
    Velocity: "Slip speed as measured (m/s).",
        "velocity", "velocity_m_s", "m/s";
    Reference: "Motion reference (own unit).",
        "reference", "reference", "";
    Pressure: "Static pressure (own unit).",
        "pressure", "pressure", "";
    Motion: "Commanded motion: 0 stands still.",
        "commanded motion", "motion", "";
    Statistic: "Evidence of a slip (s): the statistic that the source reports times the wanted interval.",
        "evidence", "evidence_s", "s";
    OwnStatistic: "The same as the scope's own observer has it.",
        "own evidence", "own_evidence_s", "s";
    Command: "Commanded force (N).",
        "commanded", "command_n", "N";
    Applied: "Measured normal force, as the state shows it (N).",
        "applied", "applied_n", "N";
    Estimate: "Estimate of the adequate force (N).",
        "estimate", "estimate_n", "N";
    OwnEstimate: "The same as the scope's own observer has it (N).",
        "own estimate", "own_estimate_n", "N";
    EstimateLow: "The observer's estimate where the slip speed is one standard deviation off, the lower one (N).",
        "estimate, low", "estimate_low_n", "N";
    EstimateHigh: "The observer's estimate where the slip speed is one standard deviation off, the higher one (N).",
        "estimate, high", "estimate_high_n", "N";
    Need: "Median of the normal force that the object needs at full weight (N).",
        "needed force", "need_n", "N";
    NeedLow: "Its 10 % quantile (N).",
        "needed force, 10 %", "need_low_n", "N";
    NeedHigh: "Its 90 % quantile (N).",
        "needed force, 90 %", "need_high_n", "N";
    NeedTruth: "Normal force of each finger that the object needs now, where a simulator knows it (N).",
        "needed, truth", "need_truth_n", "N";
    ForceLimit: "Largest force of the controller (N).",
        "limit", "limit_n", "N";
    Esc: "E_sc (W or J, see `Info::esc_unit`).",
        "E_sc", "esc", "W";
    OwnEsc: "E_sc as the scope's own observer has it; the same where it saw the same samples with the same settings.",
        "own E_sc", "own_esc", "W";
    EscLow: "Lower end of the enclosure of the observer's E_sc.",
        "E_sc, lower bound", "esc_low", "W";
    EscHigh: "Upper end of the enclosure of the observer's E_sc.",
        "E_sc, upper bound", "esc_high", "W";
    EscFlags: "Flags of E_sc as a whole number, see `feed::esc_flags`: no curve.",
        "E_sc, flags", "esc_flags", "";
    SlipSpeed: "Slip speed as the observer has it (m/s).",
        "slip speed", "slip_speed_m_s", "m/s";
    SlipSpeedSigma: "Its standard deviation (m/s).",
        "slip speed, deviation", "slip_speed_sigma_m_s", "m/s";
    Band0: "Energy of a band over its floor, highest of some milliseconds; bands in the order of the detector.",
        "shear", "band_0_energy", "";
    Band1: "Energy of a band over its floor, highest of some milliseconds; bands in the order of the detector.",
        "vibration", "band_1_energy", "";
    Band2: "Energy of a band over its floor, highest of some milliseconds; bands in the order of the detector.",
        "octave 1", "band_2_energy", "";
    Band3: "Energy of a band over its floor, highest of some milliseconds; bands in the order of the detector.",
        "octave 2", "band_3_energy", "";
    Band4: "Energy of a band over its floor, highest of some milliseconds; bands in the order of the detector.",
        "octave 3", "band_4_energy", "";
    Band5: "Energy of a band over its floor, highest of some milliseconds; bands in the order of the detector.",
        "octave 4", "band_5_energy", "";
}

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

    /// The bands, in the order of `DetectorConfig::bands`.
    pub const BANDS: [Self; BANDS] =
        [Self::Band0, Self::Band1, Self::Band2, Self::Band3, Self::Band4, Self::Band5];

    /// The channel that a CSV file calls so.
    #[must_use]
    pub fn of_column(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|channel| channel.column() == name)
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

    /// Whether it stands in rows of samples, at the sample rate.
    #[must_use]
    pub fn is_row(self) -> bool {
        Self::ROWS.contains(&self)
    }
}

#[cfg(test)]
mod tests {
    use super::Channel;

    #[test]
    fn every_channel_is_found_by_its_column() {
        for channel in Channel::ALL {
            assert_eq!(Channel::of_column(channel.column()), Some(channel));
        }
        assert_eq!(Channel::of_column("nothing"), None);
    }
}
