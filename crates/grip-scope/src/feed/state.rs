//! What a pipeline thinks of the samples: that of the source, and the scope's own observer.

use slip_core::detector::{BANDS, DetectorConfig};

/// Names of the flags of E_sc that are set: b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate.
#[must_use]
pub fn esc_flags(flags: u8) -> Vec<&'static str> {
    let names = ["pole inside", "sign unknown", "no information", "degenerate"];
    let set = names.into_iter().enumerate().filter(|(bit, _)| flags >> bit & 1 == 1);
    set.map(|(_, name)| name).collect()
}

/// Whose settings the scope goes by: evidence of a slip, and E_sc, follow them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ObserverSettings {
    /// Those with which the source itself runs or ran.
    Source {
        /// Wanted time between false alarms (s).
        interval_s: f32,
    },
    /// The shipped ones: the source does not show its own.
    #[default]
    Shipped,
}

impl ObserverSettings {
    /// Wanted time between false alarms (s): evidence of so much is a slip.
    #[must_use]
    pub fn interval_s(self) -> f32 {
        match self {
            Self::Source { interval_s } => interval_s,
            Self::Shipped => DetectorConfig::default().interval_s,
        }
    }
}

/// What the observer makes of some milliseconds of samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DerivedBlock {
    /// Band energies, a point for each few milliseconds.
    pub bands: Vec<BandPoint>,
    /// Peaks and valleys of the stylus.
    pub turns: Vec<Turn>,
    /// E_sc, estimate and slip speed while an object slips.
    pub evidence: Vec<EvidencePoint>,
    /// Spectra of the stylus.
    pub spectra: Vec<SpectrumColumn>,
    /// Whether what comes does not join what came before.
    pub broken: bool,
}

/// The highest of some milliseconds of what the detector sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandPoint {
    /// Device time of their end (s).
    pub t_s: f64,
    /// Energy of each band over its floor; NaN while the floor is learned.
    pub energy: [f32; BANDS],
    /// Evidence of a slip (s).
    pub evidence_s: f32,
}

/// A peak or a valley of the stylus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// When (s).
    pub t_s: f64,
    /// How high (unit of the stylus).
    pub height: f32,
    /// Whether it is a peak.
    pub is_peak: bool,
}

/// What is known of a slip that goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvidencePoint {
    /// Device time (s).
    pub t_s: f64,
    /// E_sc (W or J) and the ends of its enclosure: value, low, high.
    pub esc: Option<[f32; 3]>,
    /// Slip speed and its standard deviation (m/s).
    pub speed: Option<(f32, f32)>,
    /// Estimate (N), and the estimates one deviation of the acceleration away: value, low, high.
    pub estimate: Option<[f32; 3]>,
}

/// One spectrum of the stylus.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectrumColumn {
    /// Device times of its first and last sample (s).
    pub span: [f64; 2],
    /// Highest frequency (Hz); bins are spread evenly from 0 to it.
    pub top_hz: f32,
    /// Power of each bin (dB over one unit of the stylus squared per bin), in steps of [`DB_STEP`](crate::model::DB_STEP) above
    /// [`DB_BASE`](crate::model::DB_BASE).
    pub bins: Box<[u8]>,
}
