//! Session with a gripper: force commands, events and the state of the link from its bytes and the time.
//!
//! Joins the link and the pipeline, sans-IO: the daemon drives it with a serial port and a clock, the
//! grasp runs with a simulated gripper and simulated time, and both execute the same lines.

mod begin;
mod explain;
mod pace;
mod path;
mod time_base;

pub use crate::report::ClockHealth;
pub use begin::{Beginning, device_config};
pub use explain::explain;

use crate::{
    config::HostConfig,
    model::HostEstimator,
    report::{Condition, Event, EventLog},
    steady::SteadyAlarm,
};
use grip_link::{
    clock::ClockSync,
    frame::MAX_WIRE,
    host::{CloseReason, GripCommand, HostConfig as LinkSettings, HostEvent, HostLink},
    message::{ChannelKind, DeviceState, GripMode, Ident, Layout, Status},
};
use pace::{SlewLimiter, Wanted};
use path::{ClientSetpoints, OwnMotion, Path};
use slip_core::{
    ClientCommand, ConfigError, Pipeline, Sample, StageCounters, Step,
    freshness::Freshness,
    grip::{GripState, Trials},
    health::{HealthCounters, Sensor, SensorHealth},
    pressure::MAX_TAXELS,
    units::{Micros, Newtons},
};
use std::sync::Arc;
use time_base::TimeBase;

/// No usable row for longer than this (us), or than three frames last: the session is blind.
const BLIND_US: u64 = 50_000;
/// Other settings wait so long (us) for the end of a slip: many times what a slip takes that is answered with enough force.
const LONGEST_SWAP_US: u64 = 2_000_000;

/// How a session differs from the configuration file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SessionOptions {
    /// Never sends a force command.
    pub dry_run: bool,
    /// Only observes: no force command is computed. So it is with every board that has no actuator.
    pub observe: bool,
    /// Runs every stage in every scene.
    pub no_skip: bool,
    /// Only the gripper with this identity is commanded; where none is given, only the first one that answers.
    pub uid: Option<[u8; 16]>,
}

/// Why a session cannot be set up, or cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// The settings do not fit the sample rate the gripper works at.
    #[error("the gripper samples at {sample_rate_hz} Hz: {source}")]
    Pipeline {
        /// The rate in force.
        sample_rate_hz: u32,
        /// What does not fit.
        source: ConfigError,
    },
    /// The calibration was made for another rate or stylus.
    #[error(transparent)]
    Calibration(#[from] crate::config::HostConfigError),
    /// The link settings are refused.
    #[error("link: {0}")]
    Link(#[from] grip_link::host::HostConfigError),
}

/// What happened.
#[derive(Clone, Copy, Debug)]
pub enum Update<'a> {
    /// A pipeline begins: the next samples go through it.
    Began(&'a Beginning),
    /// A gripper has named itself.
    Gripper {
        /// What it reported.
        ident: &'a Ident,
        /// Whether it has restarted since it was seen last.
        rebooted: bool,
        /// Whether it is another one than the session is for: the link is closed, nothing was commanded.
        other: bool,
    },
    /// A sample was handled.
    Step {
        /// Number of its row on the device; wraps.
        index: u32,
        /// The sample.
        sample: &'a Sample,
        /// The frame of the taxel array that came with it, empty where none did.
        taxels: &'a [f32],
        /// What it led to.
        step: &'a Step,
    },
    /// Something worth a line; what a sample led to comes before its [`Update::Step`].
    Event(Event),
    /// Something about the link; never [`HostEvent::Samples`].
    Link(HostEvent),
}

/// Counts of a session.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SessionCounters {
    /// Samples handled.
    pub samples: u64,
    /// Force commands encoded.
    pub commands: u64,
}

/// A conversation with one gripper.
#[derive(Debug)]
pub struct Session {
    link: HostLink,
    config: HostConfig,
    options: SessionOptions,
    estimator: HostEstimator,
    pipeline: Option<Pipeline<Arc<[f32]>>>,
    /// The gripper that the session is for, once it is known.
    uid: Option<[u8; 16]>,
    /// What the pipeline began with.
    begun: Option<Beginning>,
    setpoints: ClientSetpoints,
    time: TimeBase,
    freshness: Freshness,
    /// The state of the clock that was reported last.
    clock_health: ClockHealth,
    /// Host time (us) at which the device took the settings.
    configured_us: u64,
    /// Why the settings that the gripper put in force cannot be worked with.
    refusal: Option<SessionError>,
    motion: OwnMotion,
    log: EventLog,
    steady: SteadyAlarm,
    /// When an alarm was found steady that was not asked for yet.
    steady_at: Option<Micros>,
    path: Path,
    due: Due,
    /// Force (N) that the gripper has while a stop or a fault is latched: no command is sent meanwhile.
    latched_n: Option<f32>,
    /// Least time between two commands (us), and when the last one was made.
    interval_us: u64,
    commanded_us: u64,
    limiter: SlewLimiter,
    counters: SessionCounters,
    /// Rows lost before the link was opened last.
    lost_before: u64,
}

/// What has to be done once the bytes are taken.
#[derive(Clone, Copy, Debug, Default)]
struct Due {
    /// Whether the gripper that has named itself has restarted.
    identified: Option<bool>,
    configured: bool,
    /// A stop or a fault has been cleared.
    unlatched: bool,
    lost: bool,
    fresh: bool,
}

impl Session {
    /// A session that is not open yet.
    ///
    /// # Errors
    /// Where the configuration does not give a possible CONFIG.
    pub fn new(
        config: HostConfig,
        estimator: HostEstimator,
        options: SessionOptions,
    ) -> Result<Self, SessionError> {
        let link = HostLink::new(LinkSettings::new(device_config(&config)))?;
        Ok(Self {
            link,
            config,
            options,
            estimator,
            pipeline: None,
            uid: options.uid,
            begun: None,
            setpoints: ClientSetpoints::default(),
            time: TimeBase::new(1_000_000, 1),
            freshness: Freshness::default(),
            clock_health: ClockHealth::Good,
            configured_us: 0,
            refusal: None,
            motion: OwnMotion::new(!(options.dry_run || options.observe)),
            log: EventLog::default(),
            steady: SteadyAlarm::default(),
            steady_at: None,
            path: Path::default(),
            due: Due::default(),
            latched_n: None,
            interval_us: 0,
            commanded_us: 0,
            limiter: SlewLimiter::default(),
            counters: SessionCounters::default(),
            lost_before: 0,
        })
    }

    /// The port is open, for the first time or again. `nonce` is random and not 0.
    ///
    /// # Errors
    /// Where `nonce` is 0.
    pub fn open(&mut self, now_us: u64, nonce: u16) -> Result<(), SessionError> {
        self.lost_before += self.link.loss().lost;
        self.path.forget_frame();
        self.due = Due::default();
        Ok(self.link.open(now_us, nonce)?)
    }

    /// The least time between two force commands (us), so that a slow line is not filled with them; 0 for none.
    pub fn set_least_interval(&mut self, interval_us: u64) {
        self.interval_us = interval_us;
    }

    /// Whether other settings that have waited for so long (us) can take over now: not while a slip is being stopped, unless it does not end
    /// by the settings in force.
    #[must_use]
    pub fn can_swap(&self, waited_us: u64) -> bool {
        self.grip_state() != Some(GripState::Slipping) || waited_us >= LONGEST_SWAP_US
    }

    /// The port is gone. The gripper holds by itself; what the pipeline knows is kept for when the port is back.
    pub fn close(&mut self) {
        self.link.close();
    }

    /// Takes received bytes (none, to let time go on) off `input` up to the next thing that happened; `None` when they are used up and
    /// nothing waits: then [`Session::command`] has what they lead to. A gripper that puts in force what the settings cannot work with
    /// closes the link, with [`CloseReason::BadConfig`]: see [`Session::refusal`].
    ///
    /// # Errors
    /// Where the configuration does not give a possible CONFIG.
    pub fn receive(
        &mut self,
        now_us: u64,
        input: &mut &[u8],
    ) -> Result<Option<Update<'_>>, SessionError> {
        loop {
            if self.path.has_updates() || self.handle_row(now_us) {
                return Ok(self.path.updates());
            }
            match self.link.receive(now_us, input) {
                None => return self.settle(now_us),
                Some(HostEvent::Samples { header, .. }) => self.begin_frame(now_us, header),
                Some(event) => {
                    self.take(&event);
                    return Ok(Some(Update::Link(event)));
                }
            }
        }
    }

    /// What is due once the bytes are used up.
    fn settle(&mut self, now_us: u64) -> Result<Option<Update<'_>>, SessionError> {
        if let Some(rebooted) = self.due.identified.take()
            && let Some(uid) = self.link.ident().map(|ident| ident.uid)
        {
            // Another gripper than this session is for is left alone.
            let other = *self.uid.get_or_insert(uid) != uid;
            if other {
                self.link.close();
            }
            return Ok(self.link.ident().map(|ident| Update::Gripper { ident, rebooted, other }));
        }
        let configured = core::mem::take(&mut self.due.configured);
        if configured {
            self.time_rows(now_us);
        }
        let unlatched = core::mem::take(&mut self.due.unlatched);
        if configured || (unlatched && self.link.in_force().is_some()) {
            let carried = self.carried();
            return match self.begin(carried) {
                Ok(()) => Ok(self.begun.as_ref().map(Update::Began)),
                Err(error) => {
                    self.refuse(error);
                    self.receive(now_us, &mut &[][..])
                }
            };
        }
        if core::mem::take(&mut self.due.lost) {
            self.arm_again(now_us)?;
        }
        Ok(self.watch_clock(now_us).map(Update::Event))
    }

    /// Takes everything in `bytes`, whatever happens, and writes the next force command to `out`, if there is one: its length.
    ///
    /// # Errors
    /// As [`Session::receive`].
    pub fn answer(
        &mut self,
        now_us: u64,
        mut bytes: &[u8],
        out: &mut [u8; MAX_WIRE],
    ) -> Result<Option<usize>, SessionError> {
        while self.receive(now_us, &mut bytes)?.is_some() {}
        Ok(self.command(now_us, out))
    }

    /// The device took the settings: its rows are timed at the rate in force, from where they were if it has not restarted.
    fn time_rows(&mut self, now_us: u64) {
        self.configured_us = now_us;
        let rate_hz = self.link.in_force().map_or(0, |config| config.sample_rate_hz);
        if self.pipeline.is_some() {
            self.time.set_rate(rate_hz);
        } else {
            let tick_hz = self.link.ident().map_or(1_000_000, |ident| u64::from(ident.tick_hz));
            self.time = TimeBase::new(tick_hz, rate_hz);
        }
        self.freshness = Freshness::new(Micros(self.rows_us(1)));
    }

    /// Closes the link to a gripper whose limits or rate cannot be worked with.
    fn refuse(&mut self, error: SessionError) {
        let Some(&config) = self.link.in_force() else { return };
        self.refusal = Some(error);
        self.link.refuse(CloseReason::BadConfig {
            sample_rate_hz: config.sample_rate_hz,
            force_max_mn: config.force_max_mn,
            slew_mn_s: config.slew_mn_s,
        });
    }

    /// The change of the device's clock, if there is one; has the clocks related anew where it jumped.
    fn watch_clock(&mut self, now_us: u64) -> Option<Event> {
        if self.time.take_resync() {
            self.link.resync(now_us);
            self.freshness.forget();
        }
        self.time.set_rate_error(self.link.clock().and_then(ClockSync::rate_error));
        let health = self.time.health();
        let changed = core::mem::replace(&mut self.clock_health, health) != health;
        let t = self.time.newest().map_or(Micros(0), |(_, t, _)| t);
        changed.then_some(Event::Health { t, condition: Condition::Clock(health) })
    }

    /// What an event of the link means to the session.
    fn take(&mut self, event: &HostEvent) {
        match event {
            HostEvent::Configured { .. } => self.due.configured = true,
            HostEvent::Status(status) => {
                self.due.lost = status.state == DeviceState::LossAction;
                self.setpoints.receive(status.state);
                self.due.unlatched = latch(&mut self.latched_n, status);
                self.motion.receive(status);
            }
            HostEvent::Rebooted { .. } => self.forget_boot(),
            HostEvent::Identified { rebooted } => {
                self.due.identified = Some(*rebooted);
                if *rebooted {
                    self.forget_boot();
                }
            }
            _ => {}
        }
    }

    /// The gripper has restarted.
    fn forget_boot(&mut self) {
        self.pipeline = None;
        self.motion.forget();
    }

    /// This program stalled so long that the gripper took the loss action, which is to hold: a new CONFIG lets it
    /// take commands again.
    fn arm_again(&mut self, now_us: u64) -> Result<(), SessionError> {
        if self.link.state().streams() {
            self.link.reconfigure(now_us, device_config(&self.config))?;
        }
        Ok(())
    }

    /// The next frame of the link itself (requests, clock sync) or of a stop that was asked for: its length.
    pub fn poll_transmit(&mut self, now_us: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        if self.setpoints.stop_due(now_us) {
            return self.link.estop(out);
        }
        self.link.poll_transmit(now_us, out)
    }

    /// Puts other settings in force, between two frames; what they replace is left in `config` and `estimator`. What is asked of the
    /// gripper itself changes when it is attached next. The object stays held: the new pipeline goes on where the old one was. Gives what it
    /// begins with; `None` where there is none yet.
    ///
    /// # Errors
    /// Where they do not fit the rate the gripper works at, or did when it was there last; then the old ones stay in force.
    pub fn swap(
        &mut self,
        config: &mut HostConfig,
        estimator: &mut HostEstimator,
    ) -> Result<Option<&Beginning>, SessionError> {
        let carried = self.carried();
        core::mem::swap(&mut self.config, config);
        core::mem::swap(&mut self.estimator, estimator);
        if self.pipeline.is_none() {
            return Ok(None);
        }
        // Without a gripper there is nothing to begin: its next CONFIG does that.
        let begins = self.link.in_force().is_some();
        if let Err(error) = if begins { self.begin(carried) } else { self.fits() } {
            core::mem::swap(&mut self.config, config);
            core::mem::swap(&mut self.estimator, estimator);
            return Err(error);
        }
        Ok(self.begun.as_ref().filter(|_| begins))
    }

    /// Carries out what a client asks for, between two frames. `false` where it cannot be: nothing is held yet, or nothing is commanded.
    pub fn obey(&mut self, now_us: u64, command: ClientCommand) -> bool {
        if let ClientCommand::ClearFault(fault) = command {
            self.link.clear_fault(now_us, fault);
            return true;
        }
        if command == ClientCommand::Stop {
            self.setpoints.stop(now_us);
            return true;
        }
        let controls = self.begun.as_ref().is_some_and(|begun| begun.config.grip.is_some());
        // What is asked for while a stop is latched must not wait for its end.
        let free = controls && !self.options.dry_run && self.latched_n.is_none();
        match &mut self.pipeline {
            Some(pipeline) if free => self.setpoints.apply(command, pipeline),
            _ => false,
        }
    }

    /// Writes the next force command to `out`, if the bytes that were taken last lead to one: its length.
    pub fn command(&mut self, now_us: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        if !core::mem::take(&mut self.due.fresh) {
            return None;
        }
        self.set_point(now_us, out)
    }

    /// Encodes the set point. Nothing is sent before the controller begins to close the fingers: a command of
    /// 0 N would drop what a gripper already holds. While samples are stale the link itself keeps the force from rising.
    fn set_point(&mut self, now_us: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        let pipeline = self.pipeline.as_ref()?;
        let state = pipeline.grip_state()?;
        let latched = self.latched_n.is_some();
        if self.options.dry_run || latched || state == GripState::Open {
            return None;
        }
        let force_n = self.paced(now_us)?;
        // A slow line must not fill up with old commands; an answer to a slip waits as little as possible.
        let pause_us = self.interval_us / if state == GripState::Slipping { 2 } else { 1 };
        if now_us < self.commanded_us.saturating_add(pause_us) {
            return None;
        }
        let mode = if state == GripState::Released { GripMode::Open } else { GripMode::Force };
        let command = GripCommand {
            mode,
            answers_slip: state == GripState::Slipping,
            cause_sample: self.path.index,
            ..GripCommand::newtons(force_n)?
        };
        let len = self.link.grip(now_us, &command, out)?;
        if let Some(sent_n) = self.sent_n() {
            self.limiter.was_held_to(sent_n);
        }
        self.commanded_us = now_us;
        self.counters.commands += 1;
        Some(len)
    }

    /// The controller's set point within the slew rate, by the host's clock.
    fn paced(&mut self, now_us: u64) -> Option<f32> {
        let slew_n_s = self.begun.as_ref()?.config.grip?.slew_n_s;
        let rise_n = slew_n_s * self.freshness.take_s();
        let wanted = Wanted {
            force_n: self.path.step?.command?.0,
            applied_n: self.applied_n(),
            rise_n: (!self.is_late(now_us)).then_some(rise_n),
        };
        self.limiter.force(&wanted)
    }

    /// Age (us) of the newest usable row at host time `now_us`, by the host's clock; `None` where the clocks are not related.
    #[must_use]
    pub fn evidence_age_us(&self, now_us: u64) -> Option<u64> {
        let (tick, ..) = self.time.newest().filter(|_| self.time.follows_ticks())?;
        Some(now_us.saturating_sub(self.link.clock()?.host_us(tick)?))
    }

    /// Whether the newest row is older than 20 ms beyond what its line usually takes: after a pause of this program, or on a line that holds
    /// bytes back. The force is not raised on it. Clocks that are not related judge nothing.
    #[must_use]
    pub fn is_late(&self, now_us: u64) -> bool {
        self.evidence_age_us(now_us).is_some_and(|age_us| age_us > self.freshness.limit().0)
    }

    /// Whether no usable row has come for more than 50 ms, or three frames where they last longer, while samples should flow.
    #[must_use]
    pub fn is_blind(&self, now_us: u64) -> bool {
        let usable_us =
            self.time.newest().map_or(0, |(.., host_us)| host_us).max(self.configured_us);
        let frame_us = self.link.in_force().map_or(0, |config| self.rows_us(config.batch));
        let streams = self.link.state().streams();
        streams && now_us.saturating_sub(usable_us) > BLIND_US.max(3 * frame_us)
    }

    /// Time that so many rows cover (us), at the rate in force.
    fn rows_us(&self, rows: u8) -> u64 {
        let rate_hz = self.link.in_force().map_or(1, |config| config.sample_rate_hz.max(1));
        u64::from(rows) * 1_000_000 / u64::from(rate_hz)
    }

    /// State of the device's clock.
    #[must_use]
    pub fn clock_health(&self) -> ClockHealth {
        self.clock_health
    }

    /// Why the gripper's answer to CONFIG closed the link last, where it did.
    pub fn refusal(&mut self) -> Option<SessionError> {
        self.refusal.take()
    }

    /// The force that was sent last (N).
    fn sent_n(&self) -> Option<f32> {
        self.link.last_grip().map(|grip| Newtons::from_mn(grip.force_mn).0)
    }

    /// The link, for its state, identity, clock and counters.
    #[must_use]
    pub fn link(&self) -> &HostLink {
        &self.link
    }

    /// Host time minus device time of the newest sample, and what that may be off (us); `None` while the clocks are not related.
    #[must_use]
    pub fn clock_offset_us(&self) -> Option<(i64, f64)> {
        let (tick, t, _) = self.time.newest().filter(|_| self.time.follows_ticks())?;
        let clock = self.link.clock()?;
        let offset_us = clock.host_us(tick)?.cast_signed().wrapping_sub(t.0.cast_signed());
        Some((offset_us, clock.uncertainty_us()))
    }

    /// Rows lost since the session began, over all openings of the port.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.lost_before + self.link.loss().lost
    }

    /// What the controller does; `None` before there is a pipeline.
    #[must_use]
    pub fn grip_state(&self) -> Option<GripState> {
        self.pipeline.as_ref()?.grip_state()
    }

    /// How the object in hand was tried so far; `None` before there is a pipeline.
    #[must_use]
    pub fn trials(&self) -> Option<Trials> {
        self.pipeline.as_ref()?.trials()
    }

    /// Taxels of the gripper's array that its rows carry, as many as are looked at; 0 where there is none.
    #[must_use]
    pub fn taxels(&self) -> usize {
        let Some((ident, config)) = self.link.ident().zip(self.link.in_force()) else { return 0 };
        Layout::new(ident.channels(), config.channel_mask)
            .column(ChannelKind::PressureArray)
            .map_or(0, |column| usize::from(column.count).min(MAX_TAXELS))
    }

    /// The health of each sensor with the last sample; `Absent` where the gripper sends nothing of it.
    #[must_use]
    pub fn sensors(&self) -> Option<[SensorHealth; 4]> {
        let mut sensors = self.latest()?.sensors;
        let Some((ident, config)) = self.link.ident().zip(self.link.in_force()) else {
            return Some(sensors);
        };
        let sent = |wanted: &[ChannelKind]| {
            let mut channels = ident.channels().iter().enumerate();
            channels.any(|(i, c)| config.channel_mask >> i & 1 == 1 && wanted.contains(&c.kind))
        };
        for (sensor, health) in Sensor::ALL.into_iter().zip(&mut sensors) {
            let present = match sensor {
                Sensor::Stylus => sent(&[ChannelKind::Stylus, ChannelKind::SecondStylus]),
                Sensor::Travel => sent(&[ChannelKind::Travel]),
                Sensor::Pressure => sent(&[ChannelKind::Pressure, ChannelKind::PressureArray]),
                Sensor::Reference => sent(&[ChannelKind::Reference]),
                Sensor::Other(_) => true,
            };
            if !present && *health == SensorHealth::Good {
                *health = SensorHealth::Absent;
            }
        }
        Some(sensors)
    }

    /// The last step.
    #[must_use]
    pub fn latest(&self) -> Option<&Step> {
        self.path.step.as_ref()
    }

    /// The normal force (N) that was measured with the last sample; `None` where no sensor shows.
    #[must_use]
    pub fn applied_n(&self) -> Option<f32> {
        self.path.sample.normal_force_n
    }

    /// What was printed so far.
    #[must_use]
    pub fn log(&self) -> &EventLog {
        &self.log
    }

    /// Counts so far.
    #[must_use]
    pub fn counters(&self) -> SessionCounters {
        self.counters
    }

    /// Counts of the pipeline's stages and of unusable readings, once there is a pipeline.
    #[must_use]
    pub fn pipeline_counters(&self) -> Option<(StageCounters, HealthCounters)> {
        self.pipeline
            .as_ref()
            .map(|pipeline| (pipeline.stage_counters(), pipeline.health_counters()))
    }
}

/// Remembers the force a gripper has while a stop or a fault is latched; whether that is over now.
fn latch(latched_n: &mut Option<f32>, status: &Status) -> bool {
    if matches!(status.state, DeviceState::Estop | DeviceState::Fault) {
        *latched_n = Some(Newtons::from_mn(status.applied_mn).0);
        return false;
    }
    latched_n.is_some()
}
