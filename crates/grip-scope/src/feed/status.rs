//! How a source is, who answers there and what it reports to people.

use grip_link::message::daemon::RealTime;

/// How a source is.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum SourceStatus {
    /// Nothing was asked for yet.
    #[default]
    Idle,
    /// It is being opened.
    Connecting {
        /// What is being opened.
        what: String,
        /// Why the attempt before was of no use, a sentence; empty for the first one.
        before: String,
    },
    /// Data come as they are made.
    Live,
    /// A file is being read.
    Loading {
        /// Share done (0 to 1).
        done: f32,
    },
    /// A file has been read.
    Complete {
        /// What was odd about it, a sentence; empty where nothing was.
        note: String,
    },
    /// It is gone and will be tried again.
    Waiting {
        /// Why, a sentence.
        reason: String,
        /// When (s from now).
        again_in_s: f32,
    },
    /// It is there, and nothing comes.
    Stalled {
        /// For how long (s).
        for_s: f32,
    },
    /// It cannot be used.
    Failed {
        /// Why, a sentence.
        sentence: String,
    },
}

impl SourceStatus {
    /// One line for a status bar.
    #[must_use]
    pub fn sentence(&self) -> String {
        match self {
            Self::Idle => "no source".to_owned(),
            Self::Connecting { what, before } if before.is_empty() => {
                format!("connecting to {what}")
            }
            Self::Connecting { before, .. } => format!("{before}; trying again"),
            Self::Live => "live".to_owned(),
            Self::Loading { done } => format!("loading, {:.0} %", 100.0 * done),
            Self::Complete { note } if note.is_empty() => "loaded".to_owned(),
            Self::Complete { note } => format!("loaded; {note}"),
            Self::Waiting { reason, again_in_s } => {
                format!("{reason}; trying again in {again_in_s:.1} s")
            }
            Self::Stalled { for_s } => format!("no samples for {for_s:.1} s"),
            Self::Failed { sentence } => sentence.clone(),
        }
    }

    /// Whether nobody is there who could take a command. A stream that stalls has its connection still.
    #[must_use]
    pub const fn is_disconnected(&self) -> bool {
        matches!(self, Self::Connecting { .. } | Self::Waiting { .. } | Self::Failed { .. })
    }
}

/// Who a daemon is.
#[derive(Clone, Debug, PartialEq)]
pub struct DaemonInfo {
    /// Its name and version.
    pub name: String,
    /// Where it was found.
    pub place: String,
    /// Whether it takes commands.
    pub may_command: bool,
    /// Whether it only observes.
    pub dry_run: bool,
    /// What of real-time operation was granted.
    pub real_time: RealTime,
    /// Every n-th sample comes; 1: all, 0: none.
    pub every_nth: u16,
}
