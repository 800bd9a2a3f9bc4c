//! Beginning of a pipeline from what the one before it knows, and what is asked of the gripper for it.

use super::{Session, SessionError, pace::SlewLimiter};
use crate::{config::HostConfig, replay::stylus_config};
use grip_link::message::{Channel, ChannelKind, Config, LossAction, SampleFormat, Unit};
use grip_record::StylusKind;
use slip_core::{
    Pipeline, PipelineConfig, Signal,
    alarm::Method,
    detector::DetectorConfig,
    floor::FloorConfig,
    grip::{GripConfig, GripState},
    units::{Hertz, Newtons},
};

/// What a pipeline begins with: enough to repeat it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beginning {
    /// Its settings, with the limits that the gripper has put in force and what was known of the noise.
    pub config: PipelineConfig,
    /// Force (N) at which the controller takes over a grip of the pipeline before it; `None` where the fingers may be open.
    pub carried_n: Option<f32>,
    /// Force (N) that a client asked for; 0 where none did.
    pub least_n: f32,
    /// Whether a client had let go of the object.
    pub released: bool,
    /// Taxels of the gripper's array; 0 where there is none.
    pub taxels: usize,
}

impl Beginning {
    /// The pipeline that begins so.
    ///
    /// # Errors
    /// Where a value of the configuration is outside its range.
    pub fn pipeline<W: AsRef<[f32]>>(
        &self,
        estimator: slip_core::estimate::Estimator<W>,
    ) -> Result<Pipeline<W>, slip_core::ConfigError> {
        let mut pipeline = Pipeline::resumed(self.config, Some(estimator), self.carried_n)?;
        pipeline.at_least(self.least_n);
        if self.released {
            pipeline.release();
        }
        Ok(pipeline)
    }

    /// What its samples hold of a stylus.
    #[must_use]
    pub fn stylus(&self) -> StylusKind {
        match self.config.signal {
            _ if !self.config.methods.has(Method::Stylus) => StylusKind::Absent,
            Signal::Displacement => StylusKind::Displacement,
            Signal::Vibration => StylusKind::Vibration,
        }
    }
}

/// What one pipeline leaves to the next.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Carried {
    force_n: Option<f32>,
    noise: Option<Noise>,
}

/// Noise at rest, and what it holds for.
#[derive(Clone, Copy, Debug)]
struct Noise {
    config: PipelineConfig,
    floor: Option<[f32; slip_core::detector::BANDS]>,
    reference: Option<[f32; 2]>,
}

impl Noise {
    /// `config` with this noise, where it holds for it and nothing better is known.
    fn known_to(self, config: PipelineConfig) -> PipelineConfig {
        let bands = |d: &DetectorConfig| (d.shear, d.vibration, d.octaves);
        let learned = |f: &FloorConfig| *f;
        let same = config.sample_rate == self.config.sample_rate
            && config.signal == self.config.signal
            && bands(&config.detector) == bands(&self.config.detector)
            && learned(&config.floor) == learned(&self.config.floor);
        if !same {
            return config;
        }
        PipelineConfig {
            known_floor: config.known_floor.or(self.floor),
            known_reference: config.known_reference.or(self.reference),
            ..config
        }
    }
}

impl Session {
    /// What the pipeline that runs leaves to the next one: the force that was sent last, or what the gripper was left with by a stop.
    pub(super) fn carried(&self) -> Carried {
        let Some((pipeline, begun)) = self.pipeline.as_ref().zip(self.begun.as_ref()) else {
            return Carried::default();
        };
        let gripping = pipeline
            .grip_state()
            .is_some_and(|state| !matches!(state, GripState::Open | GripState::Released));
        let left_n = self.latched_n.unwrap_or(f32::INFINITY);
        let detector = pipeline.detector();
        Carried {
            force_n: self.sent_n().filter(|_| gripping).map(|force_n| force_n.min(left_n)),
            noise: Some(Noise {
                config: begun.config,
                floor: detector.floor(),
                reference: detector.reference_floor(),
            }),
        }
    }

    /// Whether a pipeline could begin with these settings at the rate of the last one.
    pub(super) fn fits(&self) -> Result<(), SessionError> {
        let Some(begun) = &self.begun else { return Ok(()) };
        let rate = begun.config.sample_rate;
        let stylus = begun.stylus();
        self.config.check_signal(rate, stylus == StylusKind::Vibration)?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a rate that was in force, below 2^24"
        )]
        let sample_rate_hz = rate.0 as u32;
        Beginning { config: stylus_config(stylus, rate, &self.config), ..*begun }
            .pipeline(self.estimator.clone())
            .map(drop)
            .map_err(|source| SessionError::Pipeline { sample_rate_hz, source })
    }

    /// What the stylus channel in the gripper's rows holds, by its unit; heights where no gripper is known.
    fn stylus(&self) -> StylusKind {
        let Some(ident) = self.link.ident() else { return StylusKind::Displacement };
        let mask = self.link.in_force().map_or(u32::MAX, |config| config.channel_mask);
        let is_stylus = |(place, channel): &(usize, &Channel)| {
            channel.kind == ChannelKind::Stylus && mask >> place & 1 == 1
        };
        let mut channels = ident.channels().iter().enumerate();
        match channels.find(is_stylus).map(|(_, channel)| channel.unit) {
            None => StylusKind::Absent,
            Some(Unit::Metre) => StylusKind::Displacement,
            Some(_) => StylusKind::Vibration,
        }
    }

    /// Whether nothing is commanded: by choice, or because there is no actuator, or no stylus or vibration.
    fn only_observes(&self) -> bool {
        let has_actuator = self.link.ident().is_none_or(|ident| ident.limits.has_actuator());
        self.options.observe || !has_actuator || self.stylus() == StylusKind::Absent
    }

    /// Begins a pipeline with the settings and limits in force.
    pub(super) fn begin(&mut self, carried: Carried) -> Result<(), SessionError> {
        let sample_rate_hz = self.link.in_force().map_or(0, |config| config.sample_rate_hz);
        let rate = Hertz(sample_rate_hz as f32);
        let stylus = self.stylus();
        self.config.check_signal(rate, stylus == StylusKind::Vibration)?;
        let mut config = PipelineConfig {
            no_skip: self.options.no_skip,
            ..stylus_config(stylus, rate, &self.config)
        };
        config.grip = config
            .grip
            .zip(self.link.in_force())
            .filter(|_| !self.only_observes())
            .map(|(grip, given)| limited(grip, given));
        let beginning = Beginning {
            config: carried.noise.map_or(config, |noise| noise.known_to(config)),
            carried_n: carried.force_n,
            least_n: self.setpoints.least_n(),
            released: self.setpoints.released(),
            taxels: self.taxels(),
        };
        let pipeline = beginning
            .pipeline(self.estimator.clone())
            .map_err(|source| SessionError::Pipeline { sample_rate_hz, source })?;
        self.pipeline = Some(pipeline);
        self.begun = Some(beginning);
        self.latched_n = None;
        self.limiter = SlewLimiter::begin(carried.force_n);
        Ok(())
    }
}

/// The controller within the limits that the gripper has put in force.
pub(super) fn limited(grip: GripConfig, given: &Config) -> GripConfig {
    let slew_mn_s = i32::try_from(given.slew_mn_s).unwrap_or(i32::MAX);
    let (Newtons(f_max_n), Newtons(slew_n_s)) =
        (Newtons::from_mn(given.force_max_mn), Newtons::from_mn(slew_mn_s));
    let slew_n_s = grip.slew_n_s.min(slew_n_s);
    let f_max_n = grip.f_max_n.min(f_max_n);
    GripConfig {
        f_max_n,
        slew_n_s,
        trial_force_n: grip.trial_force_n.min(f_max_n),
        least_force_n: grip.least_force_n.min(f_max_n),
        contact_n: grip.contact_n.min(0.5 * grip.least_force_n.min(f_max_n)),
        close_rate_n_s: grip.close_rate_n_s.min(slew_n_s),
        backoff_n_s: grip.backoff_n_s.min(slew_n_s),
        ..grip
    }
}

/// The CONFIG that asks a gripper for these settings.
#[must_use]
pub fn device_config(config: &HostConfig) -> Config {
    // Checked: at most 1e9.
    let milli = |newtons| Newtons(newtons).to_mn().unwrap_or(i32::MAX);
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
