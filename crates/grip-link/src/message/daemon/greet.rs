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
        3 NEWS "GRIPPER, SETUP, and NOTICE about link, sensors and clients' commands.",
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
        0 versions: Versions, "0..=15", "Protocol versions the client speaks.";
        2 topics: Topics, "unknown bits are ignored", "Topics that it asks for.";
        4 every_nth: u16, "0 = none", "Samples whose number is a multiple of this come as ROWS.";
        6 state_ms: u16, "ms, 0 = all", "Least time between two STATE.";
    }
}

bits! {
    /// How the daemon runs, as bits.
    WelcomeFlags(u32) {
        0 COMMANDS "commands of clients are allowed.",
        1 DRY_RUN "the pipeline only observes: the daemon never commands a force.",
        2 RECORDS "a recording was asked for.",
        3 MODELS "models of clients are taken.",
    }
}

message! {
    /// WELCOME (A0), daemon to client: the answer to SUBSCRIBE.
    #[derive(Eq)]
    Welcome<'a> {
        0 versions: Versions, "0..=15", "Protocol versions the daemon speaks.";
        2 max_rx: u16, "bytes, 480", "Longest payload it takes.";
        4 flags: WelcomeFlags, "", "How it runs.";
        8 token: u32, "0 where commands are not allowed", "What RELEASE must bear.";
        12 run_id: u32, "", "Number of this start: differs at every start of the daemon.";
        16 host_us: u64, "us", "Time since its start.";
        24 real_time: RealTime, "", "What of real-time operation was granted.";
        25 text: &'a [u8], "bytes of text m, then UTF-8", "Its name and version; at most 255 bytes are sent.";
    }
}

impl<'a> Welcome<'a> {
    /// The text up to the first byte that is not UTF-8.
    #[must_use]
    pub fn daemon(&self) -> &'a str {
        super::readable(self.text)
    }
}
