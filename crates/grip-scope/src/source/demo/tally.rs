//! Sessions of one grasp after the other in, the figures a daemon would report out.

use grip_daemon::{Latency, clients};
use grip_link::message::daemon::{BadFrames, ClockOffset, Dropped, Health, Recording};
use grip_session::Session;

/// From one point to the next (us).
const EVERY_US: u64 = 1_000_000;

/// Counts over all grasps.
#[derive(Default)]
pub(super) struct Tally {
    pub(super) latency: Latency,
    /// What the grasps before the present one counted.
    before: Counts,
    reported_us: u64,
    samples_then: u64,
}

#[derive(Clone, Copy, Default)]
struct Counts {
    samples: u64,
    commands: u64,
    slips: u64,
    lost: u64,
    stages: [u64; 4],
    grasps: u32,
}

impl Counts {
    fn with(self, session: &Session) -> Self {
        let counters = session.counters();
        let stages = session.pipeline_counters().map_or([0; 4], |(stages, _)| {
            [stages.bands, stages.gate, stages.methods, stages.observation]
        });
        let sum = |k: usize| {
            self.stages.get(k).copied().unwrap_or(0) + stages.get(k).copied().unwrap_or(0)
        };
        Self {
            samples: self.samples + counters.samples,
            commands: self.commands + counters.commands,
            slips: self.slips + session.log().slips(),
            lost: self.lost + session.lost(),
            stages: core::array::from_fn(sum),
            grasps: self.grasps + 1,
        }
    }
}

impl Tally {
    /// A grasp is over.
    pub(super) fn end(&mut self, session: &Session) {
        self.before = self.before.with(session);
    }

    /// The figures, once a second of device time.
    pub(super) fn health(&mut self, now_us: u64, session: &Session) -> Option<Health> {
        let since_us = now_us.saturating_sub(self.reported_us);
        if since_us < EVERY_US {
            return None;
        }
        let counts = self.before.with(session);
        let fresh = counts.samples - core::mem::replace(&mut self.samples_then, counts.samples);
        self.reported_us = now_us;
        let link = session.link();
        let frames = link.counters();
        let rate_hz = Some(1e6 * fresh as f32 / since_us as f32);
        #[expect(clippy::cast_possible_truncation, reason = "seven digits are enough")]
        let offset = |(offset_us, half_us)| ClockOffset { offset_us, half_us: half_us as f32 };
        let clock = session.clock_offset_us().map(offset);
        let (latency, appended) = clients::latency(&self.latency, clock);
        Some(Health {
            host_us: now_us,
            rate_hz,
            samples: counts.samples,
            lost: counts.lost,
            bad: BadFrames {
                too_long: frames.too_long,
                cobs: frames.cobs,
                length: frames.length,
                crc: frames.crc,
                useless: frames.stale,
                gap: frames.gap,
            },
            dropped: Dropped::default(),
            clients: 1,
            link: link.state(),
            recording: Recording::Off,
            recorded_bytes: 0,
            latency,
            stages: counts.stages,
            slips: u32::try_from(counts.slips).unwrap_or(u32::MAX),
            reconnects: counts.grasps - 1,
            commands: counts.commands,
            appended: Some(appended),
        })
    }
}
