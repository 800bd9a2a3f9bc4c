//! A column of the table: its title, what it reports of a gripper, and what it is ordered by.

use super::row::{Presence, Row, Trouble};
use core::cmp::Ordering;
use grip_scope::format::{self, NOTHING};

slip_msg::named! {
    /// A column, from left to right.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum Column {
        fn title: "What stands over it.";
        fn about: "What it means, in a sentence.";
    }
    Trouble: "A lamp: what to look at first.",
        "!", "What to look at first: faults, then what is gone, silent, has no link, a bad sensor, slips.";
    Site: "The place.", "Site", "The place that gripd names in its [fleet].";
    Gripper: "The gripper's identity.", "Gripper", "The gripper's identity, 32 digits.";
    Here: "Whether it is there.", "There", "Whether its gripd is there and reports what it does.";
    Link: "The link between daemon and gripper.", "Link", "The link between gripd and the gripper.";
    Scene: "What the grasp is doing.", "Scene", "What the grasp is doing.";
    Grip: "What the force controller does.", "Grip", "What the force controller does.";
    Command: "Commanded force.", "Cmd N", "Commanded force (N).";
    Applied: "Measured force.", "Meas N", "Measured force (N).";
    Force: "Force over the last minutes.",
        "Force, 3 min", "Lowest to highest measured force (commanded, where none is measured) of each 2 s; all rows have one scale.";
    Statistic: "Slip statistic over the last minutes.",
        "Slip statistic, 3 min", "Highest slip statistic reported in each 2 s, by its logarithm; a slip from the line on. It is reported five times a second: a short slip may lie between, the count of slips has it.";
    Slips: "Slips since the daemon's start.", "Slips", "Slips since the start of its gripd.";
    Minute: "Slips in the last minute.", "1 min", "Slips that were reported in the last minute.";
    Lost: "Samples lost.", "Lost", "Samples lost between the gripper and its gripd.";
    Sensors: "The sensor that is worst off.", "Sensors", "The sensor that is worst off, where one is not good.";
    Fault: "The fault that is latched.", "Fault", "The fault that the gripper has latched.";
    Model: "The model that estimates the force.", "Model", "The model that estimates the force in its gripd.";
    Firmware: "The gripper's firmware.", "Firmware", "The version of the gripper's firmware.";
}

impl Column {
    /// Those in whose words a filter looks.
    pub(super) const WORDS: [Self; 11] = [
        Self::Trouble,
        Self::Site,
        Self::Gripper,
        Self::Here,
        Self::Link,
        Self::Scene,
        Self::Grip,
        Self::Sensors,
        Self::Fault,
        Self::Model,
        Self::Firmware,
    ];

    /// Whether the largest stand on top when it is first asked for.
    #[must_use]
    pub const fn begins_large(self) -> bool {
        use Column::{Firmware, Grip, Gripper, Link, Model, Scene, Site};
        !matches!(self, Site | Gripper | Link | Scene | Grip | Model | Firmware)
    }

    /// What it reports of a gripper at this time (s).
    #[must_use]
    pub fn text(self, row: &Row, now_s: f64) -> String {
        let state = row.state.as_ref();
        let force = |force_n: Option<f32>| force_n.map(|force_n| format!("{force_n:.2}"));
        let text = match self {
            Self::Trouble => Some(word(row.trouble(now_s)).to_owned()),
            Self::Site => Some(row.member.site.to_string()),
            Self::Gripper => Some(row.member.uid.to_string()),
            Self::Here => Some(there(row.presence(now_s))),
            Self::Link => row.figures.map(|figures| figures.link.name().to_owned()),
            Self::Scene => state.map(|state| state.scene.name().to_owned()),
            Self::Grip => state.map(|state| state.grip.name().to_owned()),
            Self::Command => force(state.and_then(|state| state.command_n)),
            Self::Applied => force(state.and_then(|state| state.applied_n)),
            Self::Force => force(row.force.highest(now_s)),
            Self::Statistic => {
                row.statistic.highest(now_s).map(|times| format::number(times.into()))
            }
            Self::Slips => row.figures.map(|figures| figures.slips.to_string()),
            Self::Minute => Some(row.slips_last_minute(now_s).to_string()),
            Self::Lost => row.lost().map(|lost| lost.to_string()),
            Self::Sensors => state.map(|_| sensors(row)),
            Self::Fault => row.fault().map(|fault| format!("{fault:04x}")),
            Self::Model => row.model.clone(),
            Self::Firmware => row.firmware.clone(),
        };
        text.unwrap_or_else(|| NOTHING.to_owned())
    }

    /// What it is ordered by, where that is known.
    pub(super) fn key(self, row: &Row, now_s: f64) -> Option<Key> {
        let state = row.state.as_ref();
        let name = |name: &str| Key::Text(name.to_owned());
        let number = |x: f32| Key::Number(x.into());
        match self {
            Self::Trouble => Some(number(f32::from(row.trouble(now_s) as u8))),
            Self::Site => Some(Key::Text(row.member.site.to_string())),
            Self::Gripper => Some(Key::Text(row.member.uid.to_string())),
            Self::Here => Some(Key::Number(away_s(row.presence(now_s)))),
            Self::Link => row.figures.map(|figures| name(figures.link.name())),
            Self::Scene => state.map(|state| name(state.scene.name())),
            Self::Grip => state.map(|state| name(state.grip.name())),
            Self::Command => state.and_then(|state| state.command_n).map(number),
            Self::Applied => state.and_then(|state| state.applied_n).map(number),
            Self::Force => row.force.highest(now_s).map(number),
            Self::Statistic => row.statistic.highest(now_s).map(number),
            Self::Slips => row.figures.map(|figures| Key::Number(figures.slips.into())),
            Self::Minute => Some(Key::Number(row.slips_last_minute(now_s) as f64)),
            Self::Lost => row.lost().map(|lost| Key::Number(count(lost))),
            Self::Sensors => state.map(|_| Key::Number(row.severity().into())),
            Self::Fault => row.fault().map(|fault| Key::Number(fault.into())),
            Self::Model => row.model.clone().map(Key::Text),
            Self::Firmware => row.firmware.clone().map(Key::Text),
        }
    }
}

/// What a row is ordered by.
#[derive(Clone, Debug)]
pub(super) enum Key {
    Number(f64),
    Text(String),
}

impl Key {
    /// Of one column all are numbers or all are texts.
    pub(super) fn compare(&self, other: &Self) -> Ordering {
        match (self, other) {
            (Self::Number(a), Self::Number(b)) => a.total_cmp(b),
            (Self::Text(a), Self::Text(b)) => a.cmp(b),
            (Self::Number(_), Self::Text(_)) => Ordering::Less,
            (Self::Text(_), Self::Number(_)) => Ordering::Greater,
        }
    }
}

/// For how long nothing was reported (s); all that is gone stands behind what is silent.
const fn away_s(presence: Presence) -> f64 {
    match presence {
        Presence::Here => 0.0,
        Presence::Silent(for_s) => for_s,
        Presence::Gone(for_s) => 1e12 + for_s,
    }
}

/// A trouble as a word.
const fn word(trouble: Trouble) -> &'static str {
    match trouble {
        Trouble::None => "ok",
        Trouble::Slipping => "slipping",
        Trouble::Sensor => "sensor",
        Trouble::Link => "no link",
        Trouble::Silent => "silent",
        Trouble::Gone => "gone",
        Trouble::Fault => "fault",
    }
}

fn there(presence: Presence) -> String {
    match presence {
        Presence::Here => "here".to_owned(),
        Presence::Silent(for_s) => format!("silent{}", since(for_s)),
        Presence::Gone(for_s) => format!("gone{}", since(for_s)),
    }
}

/// How long, in steps that need no frame each second.
fn since(for_s: f64) -> String {
    match for_s {
        60.0..3600.0 => format!(" {:.0} min", (for_s / 60.0).floor()),
        3600.0.. => format!(" {:.0} h", (for_s / 3600.0).floor()),
        _ => String::new(),
    }
}

fn sensors(row: &Row) -> String {
    row.worst_sensor()
        .map_or_else(|| "good".to_owned(), |(name, health)| format!("{name} {}", health.name()))
}

const fn count(n: u64) -> f64 {
    n as f64
}
