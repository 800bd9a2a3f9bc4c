//! The hot thread: read -> decode -> pipeline -> write, paced by the data. Nothing it uses is shared under a lock.

use crate::{
    clock::Clock,
    notes::{Note, Outbox, Status},
};
use anyhow::{Context as _, anyhow};
use core::sync::atomic::{AtomicBool, Ordering};
use grip_host::{
    News, Session,
    session::{SessionCounters, explain},
};
use grip_link::{
    frame::MAX_WIRE,
    host::{CloseReason, HostEvent, LossCount},
};
use grip_port::{Line, READ_TIMEOUT, nonce};
use hdrhistogram::Histogram;
use slip_core::{health::HealthCounters, stages::StageCounters};

/// The status is sent to the service thread this often (us).
const STATUS_EVERY_US: u64 = 50_000;

/// The loop and its memory.
#[derive(Debug)]
pub(crate) struct Hot {
    session: Session,
    clock: Clock,
    outbox: Outbox,
    end_us: u64,
    next_status_us: u64,
    latency_ns: Histogram<u64>,
}

/// What the loop did.
#[derive(Debug)]
pub(crate) struct Report {
    pub(crate) counters: SessionCounters,
    pub(crate) loss: LossCount,
    pub(crate) slips: u64,
    pub(crate) stages: StageCounters,
    pub(crate) health: HealthCounters,
    pub(crate) command_n: Option<f32>,
    pub(crate) latency_ns: Histogram<u64>,
    pub(crate) bad_frames: u32,
}

impl Hot {
    pub(crate) fn new(
        session: Session,
        clock: Clock,
        outbox: Outbox,
        duration_s: Option<f64>,
    ) -> anyhow::Result<Self> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive, checked"
        )]
        let end_us = duration_s.map_or(u64::MAX, |s| clock.now_us() + (s * 1e6) as u64);
        let latency_ns = Histogram::new_with_bounds(1, 10_000_000_000, 3).context("histogram")?;
        Ok(Self { session, clock, outbox, end_us, next_status_us: 0, latency_ns })
    }

    /// Runs until `stop` is set, the duration is over or the link ends.
    pub(crate) fn run(&mut self, mut line: Line, stop: &AtomicBool) -> anyhow::Result<()> {
        self.session.open(self.clock.now_us(), nonce())?;
        let mut input = [0; 4096];
        while !stop.load(Ordering::Relaxed) && self.clock.now_us() < self.end_us {
            self.transmit(&mut line)?;
            let count = line.read(&mut input, READ_TIMEOUT)?;
            let received_ns = self.clock.now_ns();
            let closed = self.turn(&mut line, input.get(..count).unwrap_or(&[]), received_ns)?;
            if let Some(reason) = closed {
                return Err(anyhow!(explain(&reason)));
            }
        }
        Ok(())
    }

    /// Takes bytes and writes the command they lead to. Gives the reason where the link closed.
    fn turn(
        &mut self,
        line: &mut Line,
        bytes: &[u8],
        received_ns: u64,
    ) -> anyhow::Result<Option<CloseReason>> {
        let mut out = [0; MAX_WIRE];
        let (mut closed, mut configured) = (None, false);
        let Self { session, outbox, .. } = self;
        let command =
            session.receive(received_ns / 1000, bytes, &mut out, &mut |news| match news {
                News::Step { sample, taxels, .. } => outbox.sample(sample, taxels),
                News::Began(_) | News::Gripper { .. } => {}
                News::Event(line) => outbox.note(Note::Event(line)),
                News::Link(HostEvent::Closed(reason)) => closed = Some(*reason),
                News::Link(event) => {
                    configured |= matches!(event, HostEvent::Configured { .. });
                    outbox.link(event);
                }
            })?;
        if configured {
            outbox.set_taxels(session.taxels());
        }
        if let Some(len) = command {
            line.write_command(out.get(..len).unwrap_or(&out))?;
            let taken = self.clock.now_ns().saturating_sub(received_ns);
            self.latency_ns.saturating_record(taken);
        }
        if received_ns / 1000 >= self.next_status_us {
            self.next_status_us = received_ns / 1000 + STATUS_EVERY_US;
            self.status();
        }
        Ok(closed)
    }

    /// Writes what the link itself has to say, one frame a write.
    fn transmit(&mut self, line: &mut Line) -> anyhow::Result<()> {
        let mut out = [0; MAX_WIRE];
        while let Some(len) = self.session.poll_transmit(self.clock.now_us(), &mut out) {
            line.write_frame(out.get(..len).unwrap_or(&out))?;
        }
        Ok(())
    }

    fn status(&mut self) {
        let Some(step) = self.session.latest().copied() else { return };
        let (features, estimate) = self.session.log().evidence();
        let link = self.session.link();
        self.outbox.status(Status {
            t: step.t,
            scene: step.scene,
            statistic: step.statistic,
            health: step.health,
            command: step.command,
            esc: features.and_then(|features| features.esc),
            estimate,
            lost: link.loss().lost,
            rate_hz: link.in_force().map_or(0, |config| config.sample_rate_hz),
        });
    }

    /// Lets go of the rings, which tells the service thread that nothing more comes, and reports.
    pub(crate) fn finish(self) -> Report {
        let (stages, health) = self.session.pipeline_counters().unwrap_or_default();
        Report {
            counters: self.session.counters(),
            loss: self.session.link().loss(),
            slips: self.session.log().slips(),
            stages,
            health,
            command_n: self.session.latest().and_then(|step| step.command).map(|c| c.0),
            latency_ns: self.latency_ns,
            bad_frames: self.session.link().counters().crc,
        }
    }
}
