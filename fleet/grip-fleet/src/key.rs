//! Names under which the messages of a gripper at a site are published, made and parsed.
//!
//! `grip/v1/SITE/UID/state`, `.../events`, `.../health`, `.../samples` are publications, `.../alive` is the sign that the gripper's
//! daemon is there, the others answer questions. Each event of an answer has a name of its own, `.../events/RUN/NUMBER`, and so has each
//! message of `.../status/`: a receiver that keeps one answer of each name, as Zenoh does by default, keeps all. Events and HEALTH are there
//! as JSON too: `.../json/events`, `.../json/health`.

use core::{fmt, str::FromStr};
use grip_session::config::{Site, Uid};
use serde_with::{DeserializeFromStr, SerializeDisplay};

/// What every name begins with: who, and the version of what follows.
const PREFIX: &str = "grip/v1";

slip_core::named! {
    /// What stands behind the gripper in a name. The first four are publications of frames.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum Part {
        fn name: "The words of it.";
    }
    State: "STATE: what the pipeline thinks.", "state";
    Events: "SLIP, GRIPPER and NOTICE: each once and in order.", "events";
    Health: "HEALTH: figures of the daemon, every second.", "health";
    Samples: "ROWS: samples.", "samples";
    EventsJson: "Events as JSON.", "json/events";
    HealthJson: "HEALTH as JSON.", "json/health";
    Alive: "The sign of life.", "alive";
    Status: "Answers with everything known now.", "status";
    Config: "Answers with the configuration at the start.", "config";
    About: "Answers with what it is made of: program, firmware, model.", "about";
    Command: "Takes a command for the fingers.", "command";
    Model: "Takes a model, gives it back, and states how it does.", "model";
    Recordings: "Answers with the recordings there are, and with what stands in them.", "recordings";
}

impl Part {
    /// Whether each answer has a name of its own below that of the part.
    #[must_use]
    pub const fn has_names_below(self) -> bool {
        matches!(self, Self::Events | Self::EventsJson | Self::Status)
    }

    /// What is asked for all answers of the part of this name.
    #[must_use]
    pub fn question(self, name: &str) -> String {
        format!("{name}{}", if self.has_names_below() { "/**" } else { "" })
    }
}

/// One gripper among all.
#[derive(
    Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, SerializeDisplay, DeserializeFromStr,
)]
pub struct Member {
    /// Where.
    pub site: Site,
    /// Which.
    pub uid: Uid,
}

impl Member {
    /// The name of a part of it.
    #[must_use]
    pub fn key(&self, part: Part) -> String {
        format!("{PREFIX}/{self}/{}", part.name())
    }

    /// A name taken apart; `None` for one of something else, or of a version that is not known.
    #[must_use]
    pub fn parse(key: &str) -> Option<(Self, Part)> {
        let rest = key.strip_prefix(PREFIX)?.strip_prefix('/')?;
        let (site, rest) = rest.split_once('/')?;
        let (uid, name) = rest.split_once('/')?;
        let part = Part::ALL.into_iter().find(|part| match name.strip_prefix(part.name()) {
            Some(below) => below.is_empty() || part.has_names_below() && below.starts_with('/'),
            None => false,
        })?;
        Some((Self { site: site.parse().ok()?, uid: uid.parse().ok()? }, part))
    }
}

impl FromStr for Member {
    type Err = String;

    /// `SITE/UID`, as it is shown.
    fn from_str(text: &str) -> Result<Self, String> {
        let (site, uid) = text
            .split_once('/')
            .ok_or_else(|| "expected a gripper as SITE/UID, as `fleet list` shows it".to_owned())?;
        let site = site.parse().map_err(|error| format!("site: {error}"))?;
        Ok(Self { site, uid: uid.parse().map_err(|error| format!("uid: {error}"))? })
    }
}

impl fmt::Display for Member {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.site, self.uid)
    }
}

/// Which grippers: what is absent stands for any.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selector {
    /// Where.
    pub site: Option<Site>,
    /// Which.
    pub uid: Option<Uid>,
}

impl From<Member> for Selector {
    fn from(Member { site, uid }: Member) -> Self {
        Self { site: Some(site), uid: Some(uid) }
    }
}

impl Selector {
    /// The names of a part of all of them.
    #[must_use]
    pub fn key(&self, part: Part) -> String {
        let any = || "*".to_owned();
        let site = self.site.as_ref().map_or_else(any, ToString::to_string);
        let uid = self.uid.map_or_else(any, |uid| uid.to_string());
        format!("{PREFIX}/{site}/{uid}/{}", part.name())
    }
}

#[cfg(test)]
mod tests {
    use super::{Member, Part, Selector};
    use grip_session::config::{Site, Uid};

    #[test]
    fn names_are_read_as_they_are_written() {
        let site: Site = "hall-2.east".parse().unwrap();
        let member = Member { site: site.clone(), uid: Uid([7; 16]) };
        for part in Part::ALL {
            assert_eq!(Member::parse(&member.key(part)), Some((member.clone(), part)));
        }
        let key = member.key(Part::Events);
        assert_eq!(key, "grip/v1/hall-2.east/07070707070707070707070707070707/events");
        for below in [format!("{key}/0000002a/7"), format!("{key}/**")] {
            assert_eq!(Member::parse(&below), Some((member.clone(), Part::Events)));
        }
        assert_eq!(Part::Events.question("a/events"), "a/events/**");
        assert_eq!(Part::Config.question("a/config"), "a/config");
        let json = member.key(Part::EventsJson);
        assert_eq!(json, "grip/v1/hall-2.east/07070707070707070707070707070707/json/events");
        let below = format!("{json}/0000002a/7");
        assert_eq!(Member::parse(&below), Some((member.clone(), Part::EventsJson)));
        let here = Selector { site: Some(site), uid: None };
        assert_eq!(here.key(Part::Alive), "grip/v1/hall-2.east/*/alive");
        assert_eq!(Selector::default().key(Part::Status), "grip/v1/*/*/status");
    }

    #[test]
    fn other_names_are_not_ours() {
        let uid = "07070707070707070707070707070707";
        for key in [
            String::new(),
            "grip/v1".to_owned(),
            format!("grip/v2/a/{uid}/state"),
            format!("grip/v1/a/{uid}"),
            format!("grip/v1/a/{uid}/state/x"),
            format!("grip/v1/a/{uid}/eventsx"),
            format!("grip/v1/a/{uid}/json"),
            format!("grip/v1/a/{uid}/json/health/x"),
            format!("grip/v1/a/{uid}/other"),
            "grip/v1/a/07/state".to_owned(),
            format!("grip/v1//{uid}/state"),
        ] {
            assert_eq!(Member::parse(&key), None, "{key}");
        }
    }
}
