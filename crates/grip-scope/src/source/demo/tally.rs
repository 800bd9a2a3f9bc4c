//! Tally of sessions of one grasp after the other: the numbers a daemon would report.

use grip_daemon::{Latency, clients};
use grip_link::message::daemon::{BadFrames, ClockOffset, Health};
use grip_session::Session;

/// From one point to the next (us).
const EVERY_US: u64 = 1_000_000;

/// Samples, commands, slips, rows lost, and the samples of each of four stages.
type Counts = [u64; 8];

/// Counts over all grasps.
#[derive(Default)]
pub(super) struct Tally {
    pub(super) latency: Latency,
    /// What the grasps before the present one counted.
    before: Counts,
    grasps: u32,
    reported_us: u64,
    samples_then: u64,
}

impl Tally {
    /// A grasp is over.
    pub(super) fn end(&mut self, session: &Session) {
        self.before = self.with(session);
        self.grasps += 1;
    }

    fn with(&self, session: &Session) -> Counts {
        let counters = session.counters();
        let [bands, gate, methods, observation] =
            session.pipeline_counters().map_or([0; 4], |(stages, _)| {
                [stages.bands, stages.gate, stages.methods, stages.observation]
            });
        let (slips, lost) = (session.log().slips(), session.lost());
        let now =
            [counters.samples, counters.commands, slips, lost, bands, gate, methods, observation];
        core::array::from_fn(|k| self.before[k] + now[k])
    }

    /// The figures, once a second of device time.
    pub(super) fn health(&mut self, now_us: u64, session: &Session) -> Option<Health> {
        let since_us = now_us.saturating_sub(self.reported_us);
        if since_us < EVERY_US {
            return None;
        }
        let [samples, commands, slips, lost, stages @ ..] = self.with(session);
        let fresh = samples - core::mem::replace(&mut self.samples_then, samples);
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
            samples,
            lost,
            bad: BadFrames {
                too_long: frames.too_long,
                cobs: frames.cobs,
                length: frames.length,
                crc: frames.crc,
                useless: frames.stale,
                gap: frames.gap,
            },
            clients: 1,
            link: link.state(),
            latency,
            stages,
            slips: u32::try_from(slips).unwrap_or(u32::MAX),
            reconnects: self.grasps,
            commands,
            appended: Some(appended),
            ..Health::default()
        })
    }
}
