//! Reports about the daemon: what clients are sent when they come, and what their sockets report to the board.

use crate::settings::Settings;
use grip_daemon::{
    board::ClientCounts,
    clients::{About, Clients},
    realtime::{Granted, Outcome},
};
use grip_link::message::daemon::RealTime;

/// What a client is sent when it comes.
pub(crate) fn about(settings: &Settings, run_id: u32, granted: &Granted) -> About {
    let real_time = if granted.refused().next().is_some() {
        RealTime::Partly
    } else if granted.attempts().iter().all(|attempt| attempt.outcome == Outcome::NotAsked) {
        RealTime::NotAsked
    } else {
        RealTime::Granted
    };
    About { real_time, ..settings.client_about(run_id) }
}

/// What the sockets report to the board.
pub(crate) fn clients(clients: &Clients) -> ClientCounts {
    let counters = clients.counters();
    ClientCounts {
        connected: clients.count() as u64,
        accepted: counters.accepted,
        refused: counters.refused,
        dropped: counters.dropped,
        bad_commands: counters.bad_commands,
    }
}
