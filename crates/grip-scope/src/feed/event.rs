//! What happens: its kind, its time, and what is known of a slip.

use grip_link::message::daemon::{Method, SpeedSource};

/// Kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum EventKind {
    /// Shear and first movements.
    Incipient,
    /// The object slides.
    Gross,
    /// A slip has ended.
    Ended,
    /// The force was raised to stop a slip.
    Reflex,
    /// Samples are missing.
    Gap,
    /// A sensor or the gripper reports a fault.
    Fault,
    /// The fault is over.
    Recovered,
    /// A pipeline begins, with other settings or another gripper.
    Reload,
    /// The device's time went backwards or leapt.
    Clock,
    /// A client's command.
    Client,
    /// The link changed.
    Link,
    /// A mark of the user.
    Marker,
}

impl EventKind {
    /// Every kind.
    pub const ALL: [Self; 12] = [
        Self::Incipient,
        Self::Gross,
        Self::Ended,
        Self::Reflex,
        Self::Gap,
        Self::Fault,
        Self::Recovered,
        Self::Reload,
        Self::Clock,
        Self::Client,
        Self::Link,
        Self::Marker,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Incipient => "incipient slip",
            Self::Gross => "gross slip",
            Self::Ended => "slip ended",
            Self::Reflex => "reflex",
            Self::Gap => "gap",
            Self::Fault => "fault",
            Self::Recovered => "recovered",
            Self::Reload => "pipeline begins",
            Self::Clock => "clock",
            Self::Client => "client",
            Self::Link => "link",
            Self::Marker => "marker",
        }
    }
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub struct EventMark {
    /// Device time (s); NaN where only "now" is known.
    pub t_s: f64,
    /// What.
    pub kind: EventKind,
    /// A line for people.
    pub text: String,
    /// What is known of a slip.
    pub slip: Option<SlipFacts>,
}

impl EventMark {
    /// An event that is no slip.
    #[must_use]
    pub fn plain(t_s: f64, kind: EventKind, text: impl Into<String>) -> Self {
        Self { t_s, kind, text: text.into(), slip: None }
    }
}

/// What an event tells of a slip.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlipFacts {
    /// Which method noticed it.
    pub method: Option<Method>,
    /// Statistic over its threshold.
    pub statistic: Option<f32>,
    /// Probability that noise alone would not reach it (0 to 1).
    pub confidence: Option<f32>,
    /// Slip speed (m/s).
    pub speed_m_s: Option<f32>,
    /// Its standard deviation (m/s).
    pub speed_sigma_m_s: Option<f32>,
    /// Where the speed comes from.
    pub speed_source: Option<SpeedSource>,
    /// Distance moved (m).
    pub moved_m: Option<f32>,
    /// Irregularities passed.
    pub irregularities: Option<u32>,
    /// E_sc as printed (W).
    pub esc_w: Option<f32>,
    /// Estimate (N).
    pub estimate_n: Option<f32>,
    /// Commanded force (N).
    pub command_n: Option<f32>,
    /// How long it lasted (s).
    pub duration_s: Option<f32>,
}

impl SlipFacts {
    /// The confidence for people (`confidence 76 %`), never rounded up to certainty.
    #[must_use]
    pub fn sure(&self) -> Option<String> {
        self.confidence.map(|sure| match sure {
            0.999.. => "confidence > 99.9 %".to_owned(),
            _ => format!("confidence {:.0} %", (100.0 * sure).floor()),
        })
    }
}
