//! What happens: its kind, its time, and what is known of a slip.

use grip_session::report::slip_text;
use serde::{Deserialize, Serialize};
use slip_core::{Phase, SlipReport};

slip_msg::named! {
    /// Kinds of events.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    #[non_exhaustive]
    pub enum EventKind {
        fn name: "Its name.";
    }
    #[serde(rename = "incipient slip")]
    Incipient: "Shear and first movements.", "incipient slip";
    #[serde(rename = "gross slip")]
    Gross: "The object slides.", "gross slip";
    #[serde(rename = "slip ended")]
    Ended: "A slip has ended.", "slip ended";
    Reflex: "The force was raised to stop a slip.", "reflex";
    Gap: "Samples are missing.", "gap";
    Fault: "A sensor or the gripper reports a fault.", "fault";
    Recovered: "The fault is over.", "recovered";
    #[serde(rename = "pipeline begins")]
    Reload: "A pipeline begins, with other settings or another gripper.", "pipeline begins";
    Clock: "The device's time went backwards or leapt.", "clock";
    Client: "A client's command.", "client";
    Link: "The link changed.", "link";
    Marker: "A mark of the user.", "marker";
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
    pub slip: Option<SlipReport>,
}

impl EventMark {
    /// A slip.
    #[must_use]
    pub fn slip(slip: &SlipReport) -> Self {
        let kind = match slip.phase {
            Phase::Gross => EventKind::Gross,
            Phase::Ended => EventKind::Ended,
            _ => EventKind::Incipient,
        };
        let (t_s, text) = (slip.t.as_seconds(), slip_text(slip));
        Self { t_s, kind, text, slip: Some(*slip) }
    }

    /// An event that is no slip.
    #[must_use]
    pub fn plain(t_s: f64, kind: EventKind, text: impl Into<String>) -> Self {
        Self { t_s, kind, text: text.into(), slip: None }
    }
}
