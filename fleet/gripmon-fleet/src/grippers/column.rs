//! A column of the table: its title, what it reports of a gripper, and what it is ordered by.

use super::row::{Presence, Row};
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
        self.value(row, now_s).map_or_else(|| NOTHING.to_owned(), |(_, text)| text)
    }

    /// What it is ordered by, and how that is shown, where it is known.
    pub(super) fn value(self, row: &Row, now_s: f64) -> Option<(Key, String)> {
        let (state, figures) = (row.state.as_ref(), row.figures);
        let name = |name: &str| (Key::Text(name.to_owned()), name.to_owned());
        let text = |text: String| (Key::Text(text.clone()), text);
        let force = |force_n: f32| (Key::Number(force_n.into()), format!("{force_n:.2}"));
        let count = |n: u64| (Key::Number(n as f64), n.to_string());
        match self {
            Self::Trouble => {
                let trouble = row.trouble(now_s);
                Some((Key::Number(f64::from(trouble as u8)), trouble.name().to_owned()))
            }
            Self::Site => Some(text(row.member.site.to_string())),
            Self::Gripper => Some(text(row.member.uid.to_string())),
            Self::Here => {
                let presence = row.presence(now_s);
                Some((Key::Number(away_s(presence)), there(presence)))
            }
            Self::Link => figures.map(|figures| name(figures.link.name())),
            Self::Scene => state.map(|state| name(state.scene.name())),
            Self::Grip => state.map(|state| name(state.grip.name())),
            Self::Command => state.and_then(|state| state.command_n).map(force),
            Self::Applied => state.and_then(|state| state.applied_n).map(force),
            Self::Force => row.force.highest(now_s).map(force),
            Self::Statistic => {
                let highest = row.statistic.highest(now_s).map(f64::from);
                highest.map(|times| (Key::Number(times), format::number(times)))
            }
            Self::Slips => figures.map(|figures| count(figures.slips.into())),
            Self::Minute => Some(count(row.slips_last_minute(now_s) as u64)),
            Self::Lost => row.lost().map(count),
            Self::Sensors => state.map(|_| (Key::Number(row.severity().into()), sensors(row))),
            Self::Fault => row.fault().map(|it| (Key::Number(it.into()), format!("{it:04x}"))),
            Self::Model => row.model.clone().map(text),
            Self::Firmware => row.firmware.clone().map(text),
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
            (Self::Number(_), Self::Text(_)) | (Self::Text(_), Self::Number(_)) => Ordering::Equal,
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
