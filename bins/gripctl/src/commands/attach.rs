//! A gripper to listen to: attached as gripd does it, and never commanded.

use super::clock::Clock;
use anyhow::anyhow;
use grip_daemon::port_manager::usb_filter;
use grip_link::{frame::MAX_WIRE, host::HostEvent};
use grip_port::{DEFAULT_BAUD, Line, READ_TIMEOUT, Source, nonce};
use grip_session::{HostConfig, Session, SessionOptions, Update, model, session::explain};
use grip_sim::port::Simulator;
use slip_core::Sample;

/// A gripper at its line, or a simulated one.
#[derive(Debug)]
pub(super) struct Attached {
    pub(super) session: Session,
    pub(super) line: Line,
    pub(super) clock: Clock,
    simulator: Option<Simulator>,
}

impl Attached {
    /// At `port`, a serial device, `auto`, or `sim` with a scene and a `seed`.
    pub(super) fn open(
        port: &str,
        seed: Option<u64>,
        baud: Option<u32>,
        config: &HostConfig,
    ) -> anyhow::Result<Self> {
        let options = SessionOptions { dry_run: true, ..SessionOptions::default() };
        let mut session = Session::new(config.clone(), model::default_estimator()?, options)?;
        let clock = Clock::start();
        let baud = baud.or(config.baud).unwrap_or(DEFAULT_BAUD);
        let simulator = Simulator::at(port, seed, move || clock.now_us())?;
        let port = simulator.as_ref().map_or(port, Simulator::port);
        let line = Source::open(port, baud, usb_filter(&config.usb))?.line()?;
        session.open(clock.now_us(), nonce())?;
        Ok(Self { session, line, clock, simulator })
    }

    /// One look at the line; each sample that came goes to `take`. Gives the time (us) on [`Attached::clock`].
    pub(super) fn turn(&mut self, take: &mut dyn FnMut(&Sample)) -> anyhow::Result<u64> {
        let Self { session, line, clock, .. } = self;
        let (mut input, mut out) = ([0; 4096], [0; MAX_WIRE]);
        while let Some(len) = session.poll_transmit(clock.now_us(), &mut out) {
            line.write_frame(out.get(..len).unwrap_or(&out))?;
        }
        let count = line.read(&mut input, READ_TIMEOUT)?;
        let (now_us, mut bytes) = (clock.now_us(), input.get(..count).unwrap_or(&[]));
        let mut closed = None;
        while let Some(update) = session.receive(now_us, &mut bytes)? {
            match update {
                Update::Step { sample, .. } => take(sample),
                Update::Link(HostEvent::Closed(reason)) => closed = Some(reason),
                _ => {}
            }
        }
        closed.map_or(Ok(now_us), |reason| Err(anyhow!(explain(&reason))))
    }

    /// Ends the simulator, where there is one.
    pub(super) fn close(self) -> anyhow::Result<Session> {
        self.simulator.map(Simulator::stop).transpose()?;
        Ok(self.session)
    }
}
