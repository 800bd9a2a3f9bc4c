//! What the hot thread counts: plain numbers that it copies into the ring once a second.

use crate::latency::Latency;
use grip_link::message::daemon::ClockOffset;
use grip_link::{decoder::Counters as FrameCounters, host::LossCount};
use grip_session::{Session, session::ClockHealth};
use slip_core::{StageCounters, health::HealthCounters};

/// Counts since the start of the daemon, as of `host_us`. Those of the link and of the pipeline begin anew with each of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HotCounters {
    /// Host time of this copy (us).
    pub host_us: u64,
    /// Turns of the hot loop.
    pub turns: u64,
    /// Samples that went through the pipeline.
    pub samples: u64,
    /// Slips.
    pub slips: u64,
    /// Rows lost, over all openings of the port.
    pub lost: u64,
    /// Force commands written.
    pub commands: u64,
    /// Bytes read from the line.
    pub rx_bytes: u64,
    /// Bytes written to the line.
    pub tx_bytes: u64,
    /// Rows received and lost.
    pub loss: LossCount,
    /// Frames, good and bad by cause.
    pub frames: FrameCounters,
    /// Good frames with a malformed payload.
    pub malformed: u32,
    /// Good frames that nothing waited for.
    pub unexpected: u32,
    /// Times samples were late or missing.
    pub degraded: u64,
    /// Times a line was opened after the first.
    pub reconnects: u64,
    /// Samples that went through each stage.
    pub stages: StageCounters,
    /// Unusable readings by cause.
    pub health: HealthCounters,
    /// Items that did not fit into the ring of the service thread.
    pub service_dropped: u64,
    /// Items that did not fit into the ring of the recorder.
    pub recorder_dropped: u64,
    /// From the last byte of a frame to its command written.
    pub latency: Latency,
    /// Age of the newest usable row at each command.
    pub evidence_age: Latency,
    /// Commands at which it was too old to raise the force.
    pub late_commands: u64,
    /// State of the gripper's clock.
    pub clock_health: ClockHealth,
    /// How often another fault of it was seen.
    pub clock_faults: u64,
    /// Whether no usable row has come for more than 50 ms while samples should flow.
    pub blind: bool,
    /// The clocks of host and gripper, where both are known.
    pub clock: Option<ClockOffset>,
}

impl HotCounters {
    /// Takes over what `session`, its link and its pipeline count.
    pub fn read(&mut self, session: &Session) {
        let link = session.link();
        let counters = session.counters();
        self.samples = counters.samples;
        self.commands = counters.commands;
        self.slips = session.log().slips();
        self.loss = link.loss();
        self.lost = session.lost();
        let clock_health = session.clock_health();
        let failed = clock_health != self.clock_health && clock_health != ClockHealth::Good;
        self.clock_faults += u64::from(failed);
        self.clock_health = clock_health;
        self.blind = session.is_blind(self.host_us);
        self.frames = *link.counters();
        self.malformed = link.malformed();
        self.unexpected = link.unexpected();
        #[expect(clippy::cast_possible_truncation, reason = "seven digits are enough")]
        let offset = |(offset_us, half_us)| ClockOffset { offset_us, half_us: half_us as f32 };
        self.clock = session.clock_offset_us().map(offset);
        if let Some((stages, health)) = session.pipeline_counters() {
            self.stages = stages;
            self.health = health;
        }
    }

    /// Why blocks and frames were not used: name and count.
    #[must_use]
    pub fn bad_frames(&self) -> [(&'static str, u32); 11] {
        let frames = &self.frames;
        [
            ("too_long", frames.too_long),
            ("cobs", frames.cobs),
            ("length", frames.length),
            ("crc", frames.crc),
            ("echo", frames.echo),
            ("version", frames.version),
            ("stale_session", frames.stale),
            ("duplicate", frames.duplicate),
            ("unknown_type", frames.unknown),
            ("malformed", self.malformed),
            ("unexpected", self.unexpected),
        ]
    }

    /// Why samples are missing: name and count.
    #[must_use]
    pub fn lost_samples(&self) -> [(&'static str, u64); 2] {
        let LossCount { lost, dropped_by_mcu, .. } = self.loss;
        [("dropped_by_gripper", dropped_by_mcu), ("line", lost.saturating_sub(dropped_by_mcu))]
    }

    /// Why readings could not be used: name and count.
    #[must_use]
    pub fn unusable_readings(&self) -> [(&'static str, u64); 6] {
        let health = &self.health;
        [
            ("not_finite", health.not_finite),
            ("saturated", health.saturated),
            ("glitch", health.glitches),
            ("force", health.forces),
            ("other_channel", health.other_channels),
            ("time", health.time_faults),
        ]
    }

    /// How often each stage ran: name and count.
    #[must_use]
    pub fn stages(&self) -> [(&'static str, u64); 6] {
        let stages = &self.stages;
        [
            ("bands", stages.bands),
            ("gate", stages.gate),
            ("methods", stages.methods),
            ("observation", stages.observation),
            ("inferences", stages.inferences),
            ("refused_estimates", stages.refused_estimates),
        ]
    }
}
