//! The plots in which channels belong: the title of each.

/// Which plot a channel belongs in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Group {
    /// The styli.
    Stylus,
    /// Energies of the detector's bands, and their thresholds.
    Bands,
    /// The slip statistic over its threshold.
    Statistic,
    /// Forces.
    Force,
    /// E_sc with its enclosure.
    Esc,
    /// Travel and slip speed.
    Motion,
    /// Motion reference and commanded motion.
    Reference,
    /// The static pressure.
    Pressure,
}

impl Group {
    /// Title of the plot.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stylus => "stylus",
            Self::Bands => "bands",
            Self::Statistic => "slip statistic",
            Self::Force => "force",
            Self::Esc => "E_sc",
            Self::Motion => "travel and speed",
            Self::Reference => "motion reference",
            Self::Pressure => "pressure",
        }
    }
}
