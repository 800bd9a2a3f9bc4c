//! A gripd program in; what it does when it is killed, unplugged, disturbed and starved, counted, out.
//!
//! The real program runs against a virtual gripper of this process: [`gripper`] lives in a thread behind a pseudo-terminal, [`judge`] listens
//! to every byte that reaches it. Each kind of fault starts its own gripper and its own gripd in its own folder and ends both. Times are shown
//! and judged generously; what must never happen is judged strictly:
//! - no command above the largest force, none faster than the slew, none raised without a new sample, none after a release;
//! - what is held stays held, whatever happens to the daemon;
//! - the daemon does not end by itself, and states no word of a panic;
//! - every recording can be read or recovered, and lacks at most [`kills::LOST_MS`] at its end.

pub mod gripper;
pub mod judge;
pub mod kills;
mod line;
mod outcome;
mod plugs;
mod programs;
pub mod recordings;
mod rig;
mod slips;
mod storage;

pub use outcome::Outcome;
pub use rig::Setup;

use anyhow::Result;

/// How much of each fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// kill -9 at random moments.
    pub kills: u64,
    /// The port goes and comes back.
    pub unplugs: u64,
    /// Connections that come and go.
    pub connects: u64,
    /// Restarts of the gripper.
    pub reboots: u64,
    /// SIGSTOP for 300 ms.
    pub pauses: u64,
    /// SIGHUP with a broken file, and as many with a good one.
    pub reloads: u64,
    /// Noise on the line (s).
    pub noise_s: u64,
    /// Slips with each fault in their middle.
    pub slips: u64,
}

impl Counts {
    /// What the promises are about.
    pub const FULL: Self = Self {
        kills: 200,
        unplugs: 100,
        connects: 1000,
        reboots: 20,
        pauses: 20,
        reloads: 20,
        noise_s: 30,
        slips: 4,
    };
    /// What fits a test.
    pub const QUICK: Self = Self {
        kills: 4,
        unplugs: 3,
        connects: 100,
        reboots: 1,
        pauses: 2,
        reloads: 1,
        noise_s: 2,
        slips: 1,
    };
}

/// A kind of fault: its name and what it does.
type Kind = (&'static str, fn(&Setup<'_>, Counts) -> Result<Outcome>);

const KINDS: [Kind; 11] = [
    ("kill -9", |setup, counts| kills::run(setup, counts.kills)),
    ("unplug, replug", |setup, counts| plugs::again(setup, counts.unplugs)),
    ("another gripper at the port", |setup, _| plugs::stranger(setup)),
    ("clients", |setup, counts| programs::run(setup, counts.connects)),
    ("release by a client", |setup, _| programs::release(setup)),
    ("disk full", |setup, _| storage::run(setup)),
    ("reboot of the gripper", |setup, counts| line::reboots(setup, counts.reboots)),
    ("stylus broken, stuck", |setup, _| line::styluses(setup)),
    ("noise, SIGSTOP", |setup, counts| line::noise(setup, counts.noise_s, counts.pauses)),
    ("faults in slips", |setup, counts| slips::run(setup, counts.slips)),
    ("SIGHUP", |setup, counts| line::reloads(setup, counts.reloads)),
];

/// Names of all kinds of faults, in their order.
pub fn names() -> impl Iterator<Item = &'static str> {
    KINDS.iter().map(|(name, _)| *name)
}

/// One kind of fault. A run that cannot go on is a violation.
#[must_use]
pub fn run(name: &str, setup: &Setup<'_>, counts: Counts) -> Option<Outcome> {
    let (name, kind) = KINDS.iter().find(|(kind, _)| *kind == name)?;
    let outcome = kind(setup, counts).unwrap_or_else(|error| Outcome::failed(format!("{error:#}")));
    Some(Outcome { name, ..outcome })
}
