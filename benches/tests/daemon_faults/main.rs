//! What the real program gripd does when it is killed, unplugged, disturbed and starved.
//!
//! It runs against a virtual gripper of this process: [`gripper`] lives in a thread behind a pseudo-terminal, [`judge`] listens to every
//! byte that reaches it. Each test has its own gripper and its own gripd in its own folder, and ends both. Times are judged generously;
//! what must never happen is judged strictly:
//! - no command above the largest force, none faster than the slew, none raised without a new sample, none after a release;
//! - what is held stays held, whatever happens to the daemon;
//! - the daemon does not end by itself, and states no word of a panic;
//! - every recording can be read or recovered, and lacks at most [`kills::LOST_MS`] at its end.
//!
//! `GRIP_TIMES=50 cargo test --release -p slip-benches --test daemon_faults -- --nocapture` has fifty times as many faults of each kind, and
//! prints figures.
#![cfg(test)]

mod gripper;
mod judge;
mod kills;
mod line;
mod plugs;
mod recordings;
mod release;
mod rig;
mod slips;

/// `few`, or so many times as many as GRIP_TIMES states.
fn times(few: u64) -> u64 {
    let stated = std::env::var("GRIP_TIMES").map(|times| times.parse::<u64>().unwrap());
    few * stated.unwrap_or(1)
}

/// Prints median and largest of some times.
fn spread(what: &str, mut values: Vec<u64>) {
    values.sort_unstable();
    if let (Some(median), Some(most)) = (values.get(values.len() / 2), values.last()) {
        println!("{what}: median {median} ms, max {most} ms, of {}", values.len());
    }
}
