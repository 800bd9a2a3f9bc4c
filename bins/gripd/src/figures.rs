//! The board in, the figures that clients are told every second out.

use crate::settings::Settings;
use grip_daemon::{
    Board,
    board::ClientCounts,
    clients::{About, Clients},
    realtime::{Granted, Outcome},
};
use grip_link::message::daemon::{BadFrames, Dropped, Health, Latency, RealTime, Recording};

/// What a client is told when it comes.
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

/// What the sockets tell the board.
pub(crate) fn clients(clients: &Clients, commands_lost: u64) -> ClientCounts {
    let counters = clients.counters();
    ClientCounts {
        connected: clients.count() as u64,
        accepted: counters.accepted,
        refused: counters.refused,
        dropped: counters.dropped,
        bad_commands: commands_lost,
    }
}

/// HEALTH; what only the sockets know is filled in by them.
pub(crate) fn health(board: &Board, now_us: u64) -> Health {
    let counters = board.counters();
    let frames = &counters.frames;
    #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, reason = "shown")]
    let us = |ns: u64| ns as f32 / 1000.0;
    let quantile = |q| counters.latency.quantile_ns(q).map(us);
    #[expect(clippy::cast_possible_truncation, reason = "a rate in Hz is shown as f32")]
    let rate_hz = board.rate_hz().map(|rate| rate as f32);
    let useless = [
        frames.echo,
        frames.version,
        frames.stale,
        frames.duplicate,
        frames.unknown,
        counters.malformed,
    ];
    let recording = match &board.recording {
        state if state.failure.is_some() => Recording::Stopped,
        state if state.file.is_some() => Recording::Running,
        _ => Recording::Off,
    };
    Health {
        host_us: now_us,
        rate_hz,
        samples: counters.samples,
        lost: counters.lost,
        bad: BadFrames {
            too_long: frames.too_long,
            cobs: frames.cobs,
            length: frames.length,
            crc: frames.crc,
            useless: useless.into_iter().fold(0, u32::saturating_add),
            gap: frames.gap,
        },
        dropped: Dropped {
            service: counters.service_dropped,
            recorder: counters.recorder_dropped,
            clients: 0,
        },
        recording,
        latency: Latency {
            p50_us: quantile(0.5),
            p99_us: quantile(0.99),
            max_us: Some(us(counters.latency.max_ns())),
        },
        recorded_bytes: board.recording.bytes,
        stages: counters.scenes,
        slips: u32::try_from(counters.slips).unwrap_or(u32::MAX),
        reconnects: u32::try_from(counters.reconnects).unwrap_or(u32::MAX),
        commands: counters.commands,
        ..Health::default()
    }
}
