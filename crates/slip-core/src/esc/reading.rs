//! The readings of E_sc by name.

/// Unit of a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// W
    Watt,
    /// J
    Joule,
}

impl Unit {
    /// Its symbol.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Watt => "W",
            Self::Joule => "J",
        }
    }
}

/// A reading of the scattered energy of vibration.
///
/// The printed equation gives a power and a periodic function of the ratios. The others are what its terms can mean
/// physically; for shallow irregularities, mean slope power times contact time is twice the lift work:
/// SlopePower / n x T = 2 LiftWork with T = sum s / v of n equal irregularities.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum Reading {
    /// n F v tan(sum cot(delta/s)) (W), as printed.
    #[default]
    Literal,
    /// n F v tan(sum arccot(delta/s)) (W): cot read as the angle whose cotangent is delta/s.
    ArcCot,
    /// F v sum 2 delta/s (W): power to lift along the flanks; n F v tan(mean flank angle) to second order.
    SlopePower,
    /// F sum delta (J): work to lift over every irregularity once.
    LiftWork,
    /// (pi^2/2) c v sum delta^2/s (J): what the damper c of the stylus takes while it follows sinusoidal
    /// irregularities at speed v.
    ViscousWork,
}

impl Reading {
    /// Every reading, the literal one first.
    pub const ALL: [Self; 5] =
        [Self::Literal, Self::ArcCot, Self::SlopePower, Self::LiftWork, Self::ViscousWork];

    /// Its name in flags, files and JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Literal => "literal",
            Self::ArcCot => "arc_cot",
            Self::SlopePower => "slope_power",
            Self::LiftWork => "lift_work",
            Self::ViscousWork => "viscous_work",
        }
    }

    /// The reading of that name; `-` counts as `_`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|reading| {
            reading.name().len() == name.len()
                && reading
                    .name()
                    .bytes()
                    .zip(name.bytes())
                    .all(|(own, given)| own == given || (own == b'_' && given == b'-'))
        })
    }

    /// The formula in plain text.
    #[must_use]
    pub fn formula(self) -> &'static str {
        match self {
            Self::Literal => "n F v tan(sum cot(delta/s))",
            Self::ArcCot => "n F v tan(sum arccot(delta/s))",
            Self::SlopePower => "F v sum 2 delta/s",
            Self::LiftWork => "F sum delta",
            Self::ViscousWork => "(pi^2/2) c v sum delta^2/s",
        }
    }

    /// Its unit.
    #[must_use]
    pub fn unit(self) -> Unit {
        match self {
            Self::Literal | Self::ArcCot | Self::SlopePower => Unit::Watt,
            Self::LiftWork | Self::ViscousWork => Unit::Joule,
        }
    }
}
