//! What a slip shows, in the names and units the network was trained with.

use crate::esc::Esc;

/// The measured properties of a slip that is going on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Features {
    /// Slip speed v (m/s).
    pub slip_speed_m_s: f32,
    /// Length of the stretch the other figures were taken over (s).
    pub contact_time_s: f32,
    /// Mean slip acceleration over that stretch (m/s^2); negative while friction wins.
    pub slip_acceleration_m_s2: f32,
    /// Standard deviation of that acceleration by the noise of what measures travel or speed (m/s^2); `None` where the speed is configured.
    pub slip_acceleration_sigma_m_s2: Option<f32>,
    /// Distance moved since the slip was noticed (m).
    pub micro_displacement_m: f32,
    /// Mean normal force of one finger over the stretch, the trial force F (N).
    pub trial_force_n: f32,
    /// Irregularities the stylus passed since the slip was noticed.
    pub irregularities: u32,
    /// Mean of delta/s over these.
    pub mean_slope: Option<f32>,
    /// E_sc as printed, with its figures of trust.
    pub esc: Option<Esc>,
    /// The chosen reading of E_sc; the same as `esc` unless another one was asked for.
    pub esc_chosen: Option<Esc>,
}

/// A feature by name: what a model file may ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// `slip_speed_m_s`
    SlipSpeed,
    /// `contact_time_s`
    ContactTime,
    /// `slip_acceleration_m_s2`
    SlipAcceleration,
    /// `micro_displacement_m`
    MicroDisplacement,
    /// `trial_force_n`
    TrialForce,
    /// `irregularities`
    Irregularities,
    /// `mean_slope`
    MeanSlope,
    /// `esc_literal_w`
    EscLiteral,
}

impl Feature {
    /// Every feature there is.
    pub const ALL: [Self; 8] = [
        Self::SlipSpeed,
        Self::ContactTime,
        Self::SlipAcceleration,
        Self::MicroDisplacement,
        Self::TrialForce,
        Self::Irregularities,
        Self::MeanSlope,
        Self::EscLiteral,
    ];

    /// Its name in model files and training data.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::SlipSpeed => "slip_speed_m_s",
            Self::ContactTime => "contact_time_s",
            Self::SlipAcceleration => "slip_acceleration_m_s2",
            Self::MicroDisplacement => "micro_displacement_m",
            Self::TrialForce => "trial_force_n",
            Self::Irregularities => "irregularities",
            Self::MeanSlope => "mean_slope",
            Self::EscLiteral => "esc_literal_w",
        }
    }

    /// The feature of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|feature| feature.name() == name)
    }

    /// Its value in `features`; `None` where the slip did not show it (yet).
    #[must_use]
    pub fn value(self, features: &Features) -> Option<f32> {
        match self {
            Self::SlipSpeed => Some(features.slip_speed_m_s),
            Self::ContactTime => Some(features.contact_time_s),
            Self::SlipAcceleration => Some(features.slip_acceleration_m_s2),
            Self::MicroDisplacement => Some(features.micro_displacement_m),
            Self::TrialForce => Some(features.trial_force_n),
            #[expect(clippy::cast_precision_loss, reason = "a network input needs no more digits")]
            Self::Irregularities => Some(features.irregularities as f32),
            Self::MeanSlope => features.mean_slope,
            #[expect(clippy::cast_possible_truncation, reason = "a network input is f32")]
            Self::EscLiteral => features.esc.map(|esc| esc.value as f32),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Feature;

    #[test]
    fn names_lead_back_to_their_feature() {
        for feature in Feature::ALL {
            assert_eq!(Feature::from_name(feature.name()), Some(feature));
        }
        assert_eq!(Feature::from_name("slip_speed"), None);
    }
}
