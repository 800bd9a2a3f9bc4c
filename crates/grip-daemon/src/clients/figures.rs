//! The board of the daemon in, HEALTH for its clients out.

use crate::Board;
use grip_link::message::daemon::{Appended, BadFrames, Dropped, Health, Latency, Recording};

/// Figures of the daemon at host time `now_us` (us), for [`Clients::health`](super::Clients::health).
#[must_use]
pub fn health(board: &Board, now_us: u64) -> Health {
    let hot = board.counters();
    let (frames, stages) = (&hot.frames, &hot.stages);
    let useless = [frames.version, frames.stale, frames.duplicate, frames.unknown, hot.malformed];
    let recording = &board.recording;
    let us = |q| hot.latency.quantile_ns(q).map(micros);
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
        latency: Latency {
            p50_us: us(0.5),
            p99_us: us(0.99),
            max_us: (hot.latency.count() > 0).then(|| micros(hot.latency.max_ns())),
        },
        recorded_bytes: recording.bytes,
        stages: [stages.bands, stages.gate, stages.methods, stages.observation],
        slips: u32::try_from(hot.slips).unwrap_or(u32::MAX),
        reconnects: u32::try_from(hot.reconnects).unwrap_or(u32::MAX),
        commands: hot.commands,
        appended: Some(Appended {
            p999_us: us(0.999),
            clock: hot.clock,
            histogram: hot.latency.doublings(),
        }),
    }
}

#[expect(clippy::cast_possible_truncation, reason = "told with seven digits")]
const fn single(value: f64) -> f32 {
    value as f32
}

#[expect(clippy::cast_precision_loss, reason = "told with seven digits")]
fn micros(ns: u64) -> f32 {
    ns as f32 / 1e3
}
