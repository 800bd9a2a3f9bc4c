//! The computer's side of the link: gripper events and frames to send, from bytes and time.
//!
//! ```text
//! CLOSED -> OPEN -> HELLO -> CONFIG -> STREAM <-> DEGRADED -> CLOSED
//! ```
//! A driver calls [`HostLink::receive`] until it gives `None` whenever bytes came or time went on, then
//! [`HostLink::poll_transmit`] until it gives `None`, writing each frame with one write. Force commands go through
//! [`HostLink::grip`]. Time is a monotonic host time in microseconds.

mod conversation;
mod link;
mod request;

pub use conversation::{Loss, LossCount};
pub use link::{GripCommand, HostEvent, HostLink};
pub use slip_msg::LinkState;

use crate::message::{Config, NackReason};
use thiserror::Error;

/// What a host wants of the link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HostConfig {
    /// CONFIG to send; the gripper clamps it to its limits.
    pub config: Config,
    /// No samples for longer than this: DEGRADED \[us\]. Three sample periods count if that is longer.
    pub stale_us: u64,
    /// No frame for longer than this: CLOSED \[us\].
    pub lost_us: u64,
    /// HELLO is repeated this long \[us\].
    pub hello_for_us: u64,
}

impl HostConfig {
    /// 5 ms to DEGRADED, 1 s to CLOSED, 3 s of HELLO.
    #[must_use]
    pub const fn new(config: Config) -> Self {
        Self { config, stale_us: 5_000, lost_us: 1_000_000, hello_for_us: 3_000_000 }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`HostConfigError`] with the numbers that cannot be.
    pub fn check(&self) -> Result<(), HostConfigError> {
        let Self { config, stale_us, lost_us, hello_for_us } = *self;
        if stale_us == 0 || lost_us <= stale_us || hello_for_us == 0 {
            return Err(HostConfigError::Times { stale_us, lost_us, hello_for_us });
        }
        Config::parse(&config.to_bytes()).map(drop).map_err(HostConfigError::Config)
    }
}

/// Why a [`HostConfig`] cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum HostConfigError {
    /// A time is zero or the link would be lost before it is stale.
    #[error("stale after {stale_us} us, lost after {lost_us} us, HELLO for {hello_for_us} us")]
    Times {
        /// Time to DEGRADED.
        stale_us: u64,
        /// Time to CLOSED.
        lost_us: u64,
        /// Time of HELLO.
        hello_for_us: u64,
    },
    /// Session 0 means "no session".
    #[error("the session nonce is 0")]
    Session,
    /// CONFIG holds a value outside its range.
    #[error("CONFIG: {0}")]
    Config(crate::message::PayloadError),
}

/// Bytes that are kept of what is no answer: a line of text, for the most part.
pub const LAST_BYTES: usize = 64;

/// Why the link closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CloseReason {
    /// The caller asked for it.
    Requested,
    /// Nobody answered HELLO. Bytes but no frames mean another protocol or a wrong baud rate.
    NoAnswer {
        /// HELLOs written.
        hellos: u32,
        /// Bytes received since opening.
        bytes: u64,
        /// Bytes in blocks that were no frames.
        garbage_bytes: u32,
        /// Own frames coming back: an echoing line.
        echoes: u32,
        /// Good frames of other sessions or types.
        frames: u32,
        /// The last bytes that came, zeros before them.
        last: [u8; LAST_BYTES],
    },
    /// The gripper speaks other versions.
    VersionMismatch {
        /// Lowest version of the gripper.
        min: u8,
        /// Highest version of the gripper.
        max: u8,
    },
    /// IDENT describes neither a stylus nor a travel nor an array of taxels.
    NoStylus,
    /// IDENT does not follow its table.
    BadIdent,
    /// A request was sent three times without an answer.
    Unanswered {
        /// Type of the request.
        kind: u8,
    },
    /// A request was refused.
    Refused {
        /// Type of the request.
        kind: u8,
        /// Why.
        reason: NackReason,
    },
    /// The caller cannot work with what the gripper put in force.
    BadConfig {
        /// Sample rate \[Hz\].
        sample_rate_hz: u32,
        /// Largest force \[mN\].
        force_max_mn: i32,
        /// Largest change of force \[mN/s\].
        slew_mn_s: u32,
    },
    /// No frame came any more.
    Lost {
        /// Time since the last frame \[us\].
        silent_us: u64,
    },
}

impl CloseReason {
    /// Its name in files.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Requested => "requested",
            Self::NoAnswer { .. } => "no_answer",
            Self::VersionMismatch { .. } => "version_mismatch",
            Self::NoStylus => "no_stylus",
            Self::BadIdent => "bad_ident",
            Self::Unanswered { .. } => "unanswered",
            Self::Refused { .. } => "refused",
            Self::BadConfig { .. } => "bad_config",
            Self::Lost { .. } => "lost",
        }
    }
}
