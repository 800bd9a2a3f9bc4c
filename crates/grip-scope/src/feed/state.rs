//! What a pipeline thinks of the samples: that of the source, and the scope's own observer.

use crate::channel::Channel;
use slip_core::detector::DetectorConfig;

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
    /// Band energies and evidence of a slip each few milliseconds; E_sc, estimate and slip speed while an object slips. In order of time.
    pub values: Vec<DerivedValue>,
    /// Peaks and valleys of the stylus.
    pub turns: Vec<Turn>,
    /// Spectra of the stylus.
    pub spectra: Vec<SpectrumColumn>,
    /// Whether what comes does not join what came before.
    pub broken: bool,
}

impl DerivedBlock {
    /// Adds values of one device time (s).
    pub fn put<V: Into<Option<f32>>>(
        &mut self,
        t_s: f64,
        values: impl IntoIterator<Item = (Channel, V)>,
    ) {
        let value = |(channel, value): (_, V)| DerivedValue { t_s, channel, value: value.into() };
        self.values.extend(values.into_iter().map(value));
    }
}

/// A value of one of the observer's curves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DerivedValue {
    /// Device time (s).
    pub t_s: f64,
    /// Which curve.
    pub channel: Channel,
    /// None where nothing is known any more.
    pub value: Option<f32>,
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

/// One spectrum of the stylus.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectrumColumn {
    /// Device times of its first and last sample (s).
    pub span: [f64; 2],
    /// Highest frequency (Hz); bins are spread evenly from 0 to it.
    pub top_hz: f32,
    /// Power of each bin (dB over one unit of the stylus squared per bin), in steps of [`DB_STEP`] above [`DB_BASE`].
    pub bins: Box<[u8]>,
}

/// Power of a bin whose byte is 0 (dB).
pub const DB_BASE: f32 = -260.0;
/// Power from byte to byte (dB).
pub const DB_STEP: f32 = 1.5;

impl SpectrumColumn {
    /// Power (dB) of a byte of its bins.
    #[must_use]
    pub fn db(byte: u8) -> f32 {
        DB_STEP.mul_add(f32::from(byte), DB_BASE)
    }
}
