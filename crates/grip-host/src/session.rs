//! Bytes from a gripper and the time in; force commands for it, events and the state of the link out.
//!
//! Joins the link and the pipeline, sans-IO: the daemon drives it with a serial port and a clock, the
//! grasp runs with a simulated gripper and simulated time, and both execute the same lines.

use crate::{
    config::HostConfig,
    model::HostEstimator,
    motion::OwnMotion,
    report::{EventLine, EventLog},
};
use grip_link::{
    frame::MAX_WIRE,
    host::{CloseReason, GripCommand, HostConfig as LinkSettings, HostEvent, HostLink, HostState},
    message::{
        ChannelKind, Config, DeviceState, Kind, Layout, LossAction, Row, SampleFormat, Samples,
    },
};
use slip_core::{
    ConfigError, Pipeline, PipelineConfig, Sample, Step,
    grip::{GripConfig, GripState},
    health::HealthCounters,
    pressure::MAX_TAXELS,
    stages::StageCounters,
    units::{Hertz, Micros},
};

/// How a session differs from the configuration file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SessionOptions {
    /// Never sends a force command.
    pub dry_run: bool,
    /// Runs every stage in every scene.
    pub no_skip: bool,
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

/// What happened, told while bytes are taken.
#[derive(Debug)]
pub enum News<'a> {
    /// A sample was handled.
    Step {
        /// The sample.
        sample: &'a Sample,
        /// The frame of the taxel array that came with it, empty where none did.
        taxels: &'a [f32],
        /// What it led to.
        step: &'a Step,
    },
    /// Something worth a line.
    Event(EventLine),
    /// Something about the link; never [`HostEvent::Samples`].
    Link(&'a HostEvent<'a>),
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
    pipeline: Option<Pipeline<Box<[f32]>>>,
    tick_hz: u64,
    motion: OwnMotion,
    log: EventLog,
    latest: Option<Step>,
    cause_sample: u32,
    counters: SessionCounters,
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
            tick_hz: 1_000_000,
            motion: OwnMotion::new(!options.dry_run),
            log: EventLog::default(),
            latest: None,
            cause_sample: 0,
            counters: SessionCounters::default(),
        })
    }

    /// The port is open. `nonce` is random and not 0.
    ///
    /// # Errors
    /// Where `nonce` is 0.
    pub fn open(&mut self, now_us: u64, nonce: u16) -> Result<(), SessionError> {
        Ok(self.link.open(now_us, nonce)?)
    }

    /// Takes received bytes (none, to let time go on) and writes the next force command to `out`, if there is one: its length.
    ///
    /// # Errors
    /// Where the settings do not fit the rate the gripper works at.
    pub fn receive(
        &mut self,
        now_us: u64,
        mut bytes: &[u8],
        out: &mut [u8; MAX_WIRE],
        tell: &mut dyn FnMut(News<'_>),
    ) -> Result<Option<usize>, SessionError> {
        let mut fresh = false;
        let Self { link, pipeline, log, latest, counters, tick_hz, cause_sample, motion, .. } =
            self;
        let (mut configured, mut lost) = (false, false);
        while let Some(event) = link.receive(now_us, &mut bytes) {
            match &event {
                HostEvent::Samples { samples, .. } => {
                    let Some(pipeline) = pipeline else { continue };
                    let mut path =
                        Path { pipeline, log, latest, tick_hz: *tick_hz, motion: *motion };
                    *cause_sample = path.batch(samples, counters, tell);
                    fresh = true;
                }
                HostEvent::Configured { .. } => configured = true,
                HostEvent::Status(status) => {
                    lost = status.state == DeviceState::LossAction;
                    motion.hear(status);
                }
                HostEvent::Rebooted { .. } | HostEvent::Identified { rebooted: true } => {
                    *pipeline = None;
                    motion.forget();
                }
                _ => {}
            }
            if !matches!(event, HostEvent::Samples { .. }) {
                tell(News::Link(&event));
            }
        }
        if configured {
            self.build_pipeline()?;
        }
        if lost {
            self.arm_again(now_us)?;
        }
        Ok(if fresh { self.command(now_us, out) } else { None })
    }

    /// This program stalled so long that the gripper took the loss action, which is to hold: a new CONFIG lets it
    /// take commands again.
    fn arm_again(&mut self, now_us: u64) -> Result<(), SessionError> {
        if matches!(self.link.state(), HostState::Stream | HostState::Degraded) {
            self.link.reconfigure(now_us, device_config(&self.config))?;
        }
        Ok(())
    }

    /// The next frame of the link itself (requests, clock sync): its length.
    pub fn poll_transmit(&mut self, now_us: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        self.link.poll_transmit(now_us, out)
    }

    /// A new CONFIG is in force: device time and floor start again.
    fn build_pipeline(&mut self) -> Result<(), SessionError> {
        let sample_rate_hz = self.link.in_force().map_or(0, |config| config.sample_rate_hz);
        self.tick_hz = self.link.ident().map_or(1_000_000, |ident| u64::from(ident.tick_hz.max(1)));
        #[expect(clippy::cast_precision_loss, reason = "rates are below 2^24")]
        let rate = Hertz(sample_rate_hz as f32);
        self.config.check_signal(rate, false)?;
        let mut config =
            PipelineConfig { no_skip: self.options.no_skip, ..self.config.pipeline(rate) };
        config.grip =
            config.grip.zip(self.link.in_force()).map(|(grip, given)| limited(grip, given));
        let pipeline = Pipeline::new(config, Some(self.estimator.clone()))
            .map_err(|source| SessionError::Pipeline { sample_rate_hz, source })?;
        self.pipeline = Some(pipeline);
        Ok(())
    }

    /// Encodes the set point. Nothing is sent before the controller has closed the fingers: a command of
    /// 0 N would drop what a gripper already holds. While samples are stale the link itself keeps the force from rising.
    fn command(&mut self, now_us: u64, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        let pipeline = self.pipeline.as_ref()?;
        if self.options.dry_run || pipeline.grip_state()? == GripState::Open {
            return None;
        }
        let force_n = self.latest?.command?.0;
        let command = GripCommand {
            answers_slip: pipeline.grip_state()? == GripState::Slipping,
            cause_sample: self.cause_sample,
            ..GripCommand::newtons(force_n)?
        };
        let len = self.link.grip(now_us, &command, out)?;
        self.counters.commands += 1;
        Some(len)
    }

    /// The link, for its state, identity, clock and counters.
    #[must_use]
    pub fn link(&self) -> &HostLink {
        &self.link
    }

    /// Taxels of the gripper's array that its rows carry, as many as are looked at; 0 where there is none.
    #[must_use]
    pub fn taxels(&self) -> usize {
        let Some((ident, config)) = self.link.ident().zip(self.link.in_force()) else { return 0 };
        Layout::new(ident.channels(), config.channel_mask)
            .column(ChannelKind::PressureArray)
            .map_or(0, |column| usize::from(column.count).min(MAX_TAXELS))
    }

    /// The last step.
    #[must_use]
    pub fn latest(&self) -> Option<&Step> {
        self.latest.as_ref()
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

/// The part of a session that samples run through.
struct Path<'a> {
    pipeline: &'a mut Pipeline<Box<[f32]>>,
    log: &'a mut EventLog,
    latest: &'a mut Option<Step>,
    tick_hz: u64,
    motion: OwnMotion,
}

impl Path<'_> {
    /// Handles a batch; gives the index of its last sample.
    fn batch(
        &mut self,
        samples: &Samples<'_>,
        counters: &mut SessionCounters,
        tell: &mut dyn FnMut(News<'_>),
    ) -> u32 {
        let mut last = 0;
        for row in samples {
            let motion = self.motion.now(self.pipeline.grip_state());
            let sample = Sample { motion, ..sample_of(&row, self.tick_hz) };
            let mut frame = [f32::NAN; MAX_TAXELS];
            let taxels = taxels_of(&row, &mut frame);
            let step = self.pipeline.handle_with(&sample, taxels);
            counters.samples += 1;
            for line in self.log.lines(&step).into_iter().flatten() {
                tell(News::Event(line));
            }
            tell(News::Step { sample: &sample, taxels, step: &step });
            *self.latest = Some(step);
            last = row.index;
        }
        last
    }
}

/// The sample of a row; `NaN` in an optional channel means that there is no reading.
fn sample_of(row: &Row<'_>, tick_hz: u64) -> Sample {
    let channel = |kind| row.read(kind).filter(|value| !value.is_nan());
    Sample {
        t: Micros(micros(row.tick, tick_hz)),
        stylus: row.read(ChannelKind::Stylus).unwrap_or(f32::NAN),
        normal_force_n: channel(ChannelKind::NormalForce),
        tangential_n: channel(ChannelKind::TangentialForce),
        travel_m: channel(ChannelKind::Travel),
        velocity_m_s: channel(ChannelKind::Velocity),
        second_stylus: channel(ChannelKind::SecondStylus),
        reference: channel(ChannelKind::Reference),
        pressure: channel(ChannelKind::Pressure),
        motion: None,
    }
}

/// The frame of the taxel array in a row; empty where there is none, or where no taxel has a reading.
fn taxels_of<'a>(row: &Row<'_>, frame: &'a mut [f32; MAX_TAXELS]) -> &'a [f32] {
    let taxels = row.read_all(ChannelKind::PressureArray, frame);
    if taxels.iter().all(|value| value.is_nan()) { &[] } else { taxels }
}

/// Ticks in microseconds, rounded down; exact for any tick count that fits.
fn micros(tick: u64, tick_hz: u64) -> u64 {
    if tick_hz == 1_000_000 {
        return tick;
    }
    (tick / tick_hz).saturating_mul(1_000_000) + (tick % tick_hz) * 1_000_000 / tick_hz
}

/// The controller within the limits that the gripper has put in force.
fn limited(grip: GripConfig, given: &Config) -> GripConfig {
    #[expect(clippy::cast_precision_loss, reason = "limits need no more digits")]
    let (f_max_n, slew_n_s) = (given.force_max_mn as f32 / 1000.0, given.slew_mn_s as f32 / 1000.0);
    let slew_n_s = grip.slew_n_s.min(slew_n_s);
    let f_max_n = grip.f_max_n.min(f_max_n);
    GripConfig {
        f_max_n,
        slew_n_s,
        trial_force_n: grip.trial_force_n.min(f_max_n),
        close_rate_n_s: grip.close_rate_n_s.min(slew_n_s),
        backoff_n_s: grip.backoff_n_s.min(slew_n_s),
        ..grip
    }
}

/// The CONFIG that asks a gripper for these settings.
fn device_config(config: &HostConfig) -> Config {
    let milli = |newtons: f32| {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "checked: at most 1e9; the cast saturates"
        )]
        let value = (f64::from(newtons) * 1000.0).round() as i32;
        value
    };
    Config {
        sample_rate_hz: config.link.sample_rate_hz,
        batch: config.link.batch,
        format: SampleFormat::F32,
        ttl_ms: config.link.ttl_ms,
        channel_mask: u32::MAX,
        force_max_mn: milli(config.grip.f_max_n),
        slew_mn_s: u32::try_from(milli(config.grip.slew_n_s)).unwrap_or(1),
        hold_cap_mn: milli(config.grip.f_max_n),
        loss_after_ms: 1000,
        loss_action: LossAction::Hold,
    }
}

/// What a closed link means to the person at the keyboard, and what to do about it.
#[must_use]
pub fn explain(reason: &CloseReason) -> String {
    match *reason {
        CloseReason::Requested => "the link was closed".to_owned(),
        CloseReason::NoAnswer { hellos, bytes: 0, .. } => format!(
            "no gripper answered: {hellos} HELLOs were sent and not one byte came back. Is it powered, and is this its port?"
        ),
        CloseReason::NoAnswer { echoes, .. } if echoes > 0 => format!(
            "no gripper answered: the line echoed {echoes} of our own frames. Turn the echo off, or check that TX and RX are not joined"
        ),
        CloseReason::NoAnswer { hellos, bytes, garbage_bytes, .. } => format!(
            "no gripper answered: {hellos} HELLOs were sent, {bytes} bytes came back, {garbage_bytes} of them no frames. \
             Another kind of device, or a wrong --baud"
        ),
        CloseReason::VersionMismatch { min, max } => format!(
            "the gripper speaks protocol versions {min} to {max}, this program speaks {}. Update the older of the two",
            grip_link::PROTOCOL
        ),
        CloseReason::NoStylus => {
            "the gripper has no stylus channel; slip cannot be felt".to_owned()
        }
        CloseReason::BadIdent => {
            "the gripper describes itself in a way the protocol does not allow; its firmware needs an update"
                .to_owned()
        }
        CloseReason::Unanswered { kind } => {
            format!(
                "the gripper did not answer {}, sent three times; restart it, and update its firmware if that does not help",
                request_name(kind)
            )
        }
        CloseReason::Refused { kind, reason } => {
            format!("the gripper refused {}: {reason:?}", request_name(kind))
        }
        CloseReason::Lost { silent_us } => {
            format!("the gripper fell silent ({} ms without a frame)", silent_us / 1000)
        }
    }
}

/// A request by the name it has in the protocol.
fn request_name(kind: u8) -> String {
    let name = match Kind(kind) {
        Kind::CONFIG => "CONFIG",
        Kind::START => "START",
        Kind::STOP => "STOP",
        Kind::CLEAR_FAULT => "CLEAR_FAULT",
        _ => return format!("a request of type {kind:02X}"),
    };
    name.to_owned()
}
