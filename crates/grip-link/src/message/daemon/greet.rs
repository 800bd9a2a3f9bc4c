//! SUBSCRIBE and WELCOME: a client reports what it wants to receive, the daemon who it is.

use super::RealTime;
use crate::message::{Versions, bits::bits};
use slip_msg::message;

bits! {
    /// Topics that a client asks for, as bits.
    Topics(u16) {
        0 SLIP "SLIP.",
        1 STATE "STATE.",
        2 HEALTH "HEALTH.",
        3 NEWS "GRIPPER, SETUP, and NOTICE of kinds SENSOR, LINK, CLIENT; DROPPED and GOODBYE come to everybody.",
        4 ESTIMATES "ESTIMATES.",
    }
}

impl Topics {
    /// All of these.
    pub const ALL: Self = Self(31);
}

message! {
    /// SUBSCRIBE (A8), client to daemon: opens the session whose nonce (1..=65535) stands in the header, or changes its topics.
    #[derive(Eq)]
    Subscribe {
        0 versions: Versions, "", "Protocol versions the client speaks.";
        2 topics: Topics, "topics; unknown bits are ignored", "Topics that it asks for.";
        4 every_nth: u16, "every n-th sample comes as ROWS; 0 = none", "Samples whose number is a multiple of this come as ROWS.";
        6 state_ms: u16, "ms, least time between two STATE; 0 = all", "Least time between two STATE.";
    }
}

bits! {
    /// How the daemon runs, as bits.
    WelcomeFlags(u32) {
        0 COMMANDS "commands of clients are allowed.",
        1 DRY_RUN "the daemon only observes: it never commands a force.",
        2 RECORDS "a recording was asked for.",
        3 MODELS "models of clients are taken.",
    }
}

message! {
    /// WELCOME (A0), daemon to client: the answer to SUBSCRIBE.
    #[derive(Eq)]
    Welcome<'a> {
        0 versions: Versions, "", "Protocol versions the daemon speaks.";
        2 max_rx: u16, "bytes, longest payload taken: 480", "Longest payload it takes.";
        4 flags: WelcomeFlags, "welcome flags", "How it runs.";
        8 token: u32, "what a COMMAND of RELEASE must bear; 0 where commands are not allowed", "What RELEASE must bear.";
        12 run_id: u32, "differs at every start of the daemon", "Number of this start: differs at every start of the daemon.";
        16 host_us: u64, "us since the daemon's start", "Time since its start.";
        24 real_time: RealTime, "real-time grant", "What of real-time operation was granted.";
        25 text: &'a [u8], "name and version of the daemon, UTF-8", "Its name and version; at most 255 bytes are sent.";
    }
}

impl<'a> Welcome<'a> {
    /// The text up to the first byte that is not UTF-8.
    #[must_use]
    pub fn daemon(&self) -> &'a str {
        super::readable(self.text)
    }
}
