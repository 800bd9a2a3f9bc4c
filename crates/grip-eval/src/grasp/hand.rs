//! Interface of whoever commands the force: bytes of a gripper and the time to frames for it.

use grip_link::frame::MAX_WIRE;
use grip_session::{
    config::HostConfig,
    model::HostEstimator,
    session::{Session, SessionError, SessionOptions, Update},
};
use grip_sim::Truth;
use slip_core::{ClientCommand, estimate::ForceEstimate, grip::Trials};

/// Who commands the force.
pub trait Hand {
    /// Takes the bytes that have arrived at `now_us` (none, to let time go on) and gives every frame for the gripper to `send`.
    ///
    /// # Errors
    /// Where settings and gripper do not fit.
    fn serve(
        &mut self,
        now_us: u64,
        bytes: &[u8],
        send: &mut dyn FnMut(&[u8]),
    ) -> Result<(), SessionError>;

    /// Takes the truth behind the samples of a turn, before they are sent. A controller that could be built does not look at it.
    fn witness(&mut self, _truth: &Truth) {}

    /// The force commanded last (N); 0 before the first.
    fn command_n(&self) -> f32;

    /// Slips that were noticed.
    fn slips(&self) -> u64;

    /// Samples handled, and lost.
    fn samples(&self) -> (u64, u64);

    /// How the object was tried, and the last estimate of the adequate force; nothing from a law without either.
    fn tried(&self) -> (Trials, Option<ForceEstimate>) {
        (Trials::default(), None)
    }
}

/// A session of gripd.
pub struct Own<'a> {
    session: Session,
    /// What the object is known to be held with (N); 0 where nothing is.
    expected_n: f32,
    report: &'a mut dyn FnMut(Update<'_>),
    /// Sees the truth behind the samples, which the session does not.
    watch: Option<&'a mut dyn FnMut(&Truth)>,
}

impl core::fmt::Debug for Own<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Own").field("session", &self.session).finish_non_exhaustive()
    }
}

impl<'a> Own<'a> {
    /// A session that hands everything that happens to `report`.
    ///
    /// # Errors
    /// Where the configuration does not make a session.
    pub fn new(
        config: &HostConfig,
        estimator: HostEstimator,
        report: &'a mut dyn FnMut(Update<'_>),
    ) -> Result<Self, SessionError> {
        let mut session = Session::new(config.clone(), estimator, SessionOptions::default())?;
        session.open(0, 1)?;
        Ok(Self { session, expected_n: 0.0, report, watch: None })
    }

    /// That expects an object which is known to be held with `expected_n` (N).
    #[must_use]
    pub fn expecting(self, expected_n: f32) -> Self {
        Self { expected_n, ..self }
    }

    /// With `watch` beside it, which gets the truth before the samples that show it.
    #[must_use]
    pub fn watched(self, watch: &'a mut dyn FnMut(&Truth)) -> Self {
        Self { watch: Some(watch), ..self }
    }
}

/// Sends the command and all that is due.
pub fn send_all(session: &mut Session, now_us: u64, send: &mut dyn FnMut(&[u8])) {
    let mut out = [0; MAX_WIRE];
    let command = session.command(now_us, &mut out);
    let mut next = command.or_else(|| session.poll_transmit(now_us, &mut out));
    while let Some(len) = next {
        send(out.get(..len).unwrap_or(&out));
        next = session.poll_transmit(now_us, &mut out);
    }
}

impl Hand for Own<'_> {
    fn serve(
        &mut self,
        now_us: u64,
        bytes: &[u8],
        send: &mut dyn FnMut(&[u8]),
    ) -> Result<(), SessionError> {
        let mut left = bytes;
        let mut begun = false;
        while let Some(updates) = self.session.receive(now_us, &mut left)? {
            begun |= matches!(updates, Update::Began(_));
            (self.report)(updates);
        }
        if begun && self.expected_n > 0.0 {
            self.session.obey(now_us, ClientCommand::Expect(self.expected_n));
        }
        send_all(&mut self.session, now_us, send);
        Ok(())
    }

    fn witness(&mut self, truth: &Truth) {
        if let Some(watch) = &mut self.watch {
            watch(truth);
        }
    }

    fn command_n(&self) -> f32 {
        self.session.latest().and_then(|step| step.command).map_or(0.0, |command| command.0)
    }

    fn slips(&self) -> u64 {
        self.session.log().slips()
    }

    fn samples(&self) -> (u64, u64) {
        (self.session.counters().samples, self.session.link().loss().lost)
    }

    fn tried(&self) -> (Trials, Option<ForceEstimate>) {
        (self.session.trials().unwrap_or_default(), self.session.log().evidence().1)
    }
}
