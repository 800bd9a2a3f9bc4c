//! SUBSCRIBE and WELCOME: a client says what it wants to hear, the daemon who it is.

use super::RealTime;
use crate::message::Versions;
use crate::message::wire::{PayloadError, Reader, Writer};

/// What a client wants to hear, as bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Topics(pub u16);

impl Topics {
    /// SLIP.
    pub const SLIP: Self = Self(1);
    /// STATE.
    pub const STATE: Self = Self(2);
    /// HEALTH.
    pub const HEALTH: Self = Self(4);
    /// GRIPPER, and NOTICE about link, sensors and clients' commands.
    pub const NEWS: Self = Self(8);
    /// All of these.
    pub const ALL: Self = Self(15);

    /// Whether all bits of `other` are set.
    #[must_use]
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// With the bits of `other` too.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// SUBSCRIBE (A8), client to daemon: opens the session whose nonce (1..=65535) stands in the header, or changes what it hears.
///
/// | offset | size | type | field | range |
/// |---|---|---|---|---|
/// | 0 | 1 | u8 | lowest protocol version spoken | 0..=15 |
/// | 1 | 1 | u8 | highest protocol version spoken | 0..=15 |
/// | 2 | 2 | u16 | [`Topics`] | unknown bits are ignored |
/// | 4 | 2 | u16 | every n-th sample comes as ROWS | 0 = none |
/// | 6 | 2 | u16 | ms, least time between two STATE | 0 = all |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Subscribe {
    /// Protocol versions the client speaks.
    pub versions: Versions,
    /// What it wants to hear.
    pub topics: Topics,
    /// Samples whose number is a multiple of this come as ROWS; 0: none.
    pub every_nth: u16,
    /// Least time between two STATE (ms).
    pub state_ms: u16,
}

impl Subscribe {
    /// Bytes of the payload.
    pub const SIZE: usize = 8;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &[u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        let versions = Versions::read(&mut r)?;
        let topics = Topics(r.u16()?);
        Ok(Self { versions, topics, every_nth: r.u16()?, state_ms: r.u16()? })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out).u8(self.versions.min).u8(self.versions.max).u16(self.topics.0);
        w.u16(self.every_nth).u16(self.state_ms).finish()
    }
}

/// How the daemon runs, as bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WelcomeFlags(pub u32);

impl WelcomeFlags {
    /// Commands of clients are allowed.
    pub const COMMANDS: Self = Self(1);
    /// The pipeline only observes: the daemon never commands a force.
    pub const DRY_RUN: Self = Self(2);
    /// A recording was asked for.
    pub const RECORDS: Self = Self(4);

    /// Whether all bits of `other` are set.
    #[must_use]
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// With the bits of `other` too, where `applies`.
    #[must_use]
    pub const fn with(self, other: Self, applies: bool) -> Self {
        if applies { Self(self.0 | other.0) } else { self }
    }
}

/// WELCOME (A0), daemon to client: the answer to SUBSCRIBE.
///
/// | offset | size | type | field | range |
/// |---|---|---|---|---|
/// | 0 | 1 | u8 | lowest protocol version spoken | 0..=15 |
/// | 1 | 1 | u8 | highest protocol version spoken | 0..=15 |
/// | 2 | 2 | u16 | bytes, longest payload taken | 480 |
/// | 4 | 4 | u32 | [`WelcomeFlags`] | |
/// | 8 | 4 | u32 | token that RELEASE must bear; 0 where commands are not allowed | |
/// | 12 | 4 | u32 | number of this start of the daemon | |
/// | 16 | 8 | u64 | us since the daemon's start | |
/// | 24 | 1 | u8 | [`RealTime`] code | |
/// | 25 | 1 | u8 | bytes of text m | |
/// | 26 | m | u8\[m\] | name and version of the daemon, UTF-8 | |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Welcome<'a> {
    /// Protocol versions the daemon speaks.
    pub versions: Versions,
    /// Longest payload it takes (bytes).
    pub max_rx: u16,
    /// How it runs.
    pub flags: WelcomeFlags,
    /// What RELEASE must bear; 0 where commands are not allowed.
    pub token: u32,
    /// Differs at every start of the daemon.
    pub run_id: u32,
    /// Time since its start (us).
    pub host_us: u64,
    /// What of real-time operation was granted.
    pub real_time: RealTime,
    /// Its name and version; at most 255 bytes are sent.
    pub text: &'a [u8],
}

impl<'a> Welcome<'a> {
    /// Bytes before the text.
    pub const HEADER: usize = 26;

    /// Reads a payload.
    ///
    /// # Errors
    /// [`PayloadError::Short`].
    pub fn parse(payload: &'a [u8]) -> Result<Self, PayloadError> {
        let mut r = Reader::new(payload);
        Ok(Self {
            versions: Versions::read(&mut r)?,
            max_rx: r.u16()?,
            flags: WelcomeFlags(r.u32()?),
            token: r.u32()?,
            run_id: r.u32()?,
            host_us: r.u64()?,
            real_time: RealTime::from_code(r.u8()?),
            text: r.text()?,
        })
    }

    /// Writes the payload; its length.
    ///
    /// # Errors
    /// [`PayloadError::Full`].
    pub fn write(&self, out: &mut [u8]) -> Result<usize, PayloadError> {
        let w = Writer::new(out).u8(self.versions.min).u8(self.versions.max).u16(self.max_rx);
        let w = w.u32(self.flags.0).u32(self.token).u32(self.run_id).u64(self.host_us);
        w.u8(self.real_time.code()).text(self.text).finish()
    }

    /// The text up to the first byte that is not UTF-8.
    #[must_use]
    pub fn daemon(&self) -> &'a str {
        super::readable(self.text)
    }
}
