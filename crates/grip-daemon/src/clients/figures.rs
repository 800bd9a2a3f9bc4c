//! The message HEALTH for clients, from the board of the daemon.

use crate::Board;
use grip_link::message::daemon::{
    Appended, BadFrames, ClockOffset, Dropped, Health, Latency, Recording,
};

/// Figures of the daemon at host time `now_us` (us), for [`Clients::health`](super::Clients::health).
#[must_use]
pub fn health(board: &Board, now_us: u64) -> Health {
    let hot = board.counters();
    let (frames, stages) = (&hot.frames, &hot.stages);
    let useless = [frames.version, frames.stale, frames.duplicate, frames.unknown, hot.malformed];
    let recording = &board.recording;
    let (latency, appended) = latency(&hot.latency, hot.clock);
    Health {
        host_us: now_us,
        rate_hz: board.rate_hz().map(single),
        samples: hot.samples,
        lost: hot.loss.lost,
        bad: BadFrames {
            too_long: frames.too_long,
            cobs: frames.cobs,
            length: frames.length,
            crc: frames.crc,
            useless: useless.iter().fold(frames.echo, |sum, count| sum.saturating_add(*count)),
            gap: frames.gap,
        },
        dropped: Dropped {
            service: hot.service_dropped,
            recorder: hot.recorder_dropped,
            clients: u32::try_from(board.clients.dropped).unwrap_or(u32::MAX),
        },
        clients: u16::try_from(board.clients.connected).unwrap_or(u16::MAX),
        link: board.link().state,
        recording: match (&recording.failure, &recording.file) {
            (Some(_), _) => Recording::Stopped,
            (None, Some(_)) => Recording::Running,
            (None, None) => Recording::Off,
        },
        latency,
        recorded_bytes: recording.bytes,
        stages: [stages.bands, stages.gate, stages.methods, stages.observation],
        slips: u32::try_from(hot.slips).unwrap_or(u32::MAX),
        reconnects: u32::try_from(hot.reconnects).unwrap_or(u32::MAX),
        commands: hot.commands,
        appended: Some(appended),
    }
}

/// Latency and clock as HEALTH has them.
#[must_use]
pub fn latency(latency: &crate::Latency, clock: Option<ClockOffset>) -> (Latency, Appended) {
    let us = |q| latency.quantile_ns(q).map(micros);
    let max_us = (latency.count() > 0).then(|| micros(latency.max_ns()));
    (
        Latency { p50_us: us(0.5), p99_us: us(0.99), max_us },
        Appended { p999_us: us(0.999), clock, histogram: latency.doublings() },
    )
}

#[expect(clippy::cast_possible_truncation, reason = "seven digits are enough")]
const fn single(value: f64) -> f32 {
    value as f32
}

fn micros(ns: u64) -> f32 {
    ns as f32 / 1e3
}
