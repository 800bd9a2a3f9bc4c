//! What happens: its kind, its time, and what is known of a slip.

use grip_session::report::{confidence_text, statistic_text};
use serde::{Deserialize, Serialize};
use slip_core::{Cause, CauseSet, Phase, SlipReport, alarm::Method};

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
        let (t_s, text) = (slip.t.as_seconds(), slip_text(kind, slip));
        Self { t_s, kind, text, slip: Some(*slip) }
    }

    /// An event that is no slip.
    #[must_use]
    pub fn plain(t_s: f64, kind: EventKind, text: impl Into<String>) -> Self {
        Self { t_s, kind, text: text.into(), slip: None }
    }
}

/// What is known of the causes of a slip other than a slip (`ruled out: knock, motion`, `possible: closing`); `None` for a set
/// that is empty.
#[must_use]
pub fn causes_text(slip: &SlipReport) -> [Option<String>; 2] {
    [("ruled out", slip.ruled_out), ("possible", slip.possible)].map(|(what, bits)| {
        let names: Vec<_> = CauseSet::from_bits(bits).iter().map(Cause::name).collect();
        (!names.is_empty()).then(|| format!("{what}: {}", names.join(", ").replace('_', " ")))
    })
}

/// A line for people.
fn slip_text(kind: EventKind, slip: &SlipReport) -> String {
    let mut text = kind.name().to_owned();
    let mut add = |part: Option<String>| {
        if let Some(part) = part {
            text.push_str(&part);
        }
    };
    add(Some(slip.method)
        .filter(|method| *method != Method::None)
        .map(|method| format!(" by {}", method.felt())));
    add(slip.duration_s.map(|time_s| format!(" after {:.1} ms", 1e3 * time_s)));
    add(slip.statistic.map(|statistic| format!(", statistic {}", statistic_text(statistic))));
    add(slip.confidence.map(|sure| format!(", {}", confidence_text(sure))));
    add(slip.speed_m_s.map(|speed| format!(", {:.1} mm/s", 1e3 * speed)));
    add(slip.moved_m.map(|moved| format!(", moved {:.2} mm", 1e3 * moved)));
    add(slip.esc_w.map(|esc| format!(", E_sc {esc:.3} W")));
    add(slip.estimate_n.map(|force| format!(", estimate {force:.2} N")));
    add(slip.command_n.map(|force| format!(", command {force:.2} N")));
    for known in causes_text(slip) {
        add(known.map(|known| format!(", {known}")));
    }
    text
}
