//! Construction of a pipeline from its settings, before its first sample.

use super::{Pipeline, StageCounters, detect::Rest, slip::Grasp};
use crate::{
    Signal,
    config::PipelineConfig,
    course::{Course, TravelQuality, Turns},
    crosscheck::Whiteness,
    detector::{KnownFloors, SlipDetector},
    drift::Sink,
    error::ConfigError,
    estimate::{Estimator, FrictionMeter},
    freshness::Freshness,
    fusion::Fusion,
    grip::GripController,
    health::{self, HealthCheck},
    load::{Grid, Load},
    need::Need,
    observation::SlipObservation,
    pressure::Standing,
    sample::{Contact, Scene},
    units::Micros,
    velocity::VelocityMeter,
};

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// A pipeline that commands the grip force, or only observes where the configuration has no `grip`.
    ///
    /// # Errors
    /// Where a value of the configuration is outside its range; the error names it.
    pub fn new(
        config: PipelineConfig,
        estimator: Option<Estimator<W>>,
    ) -> Result<Self, ConfigError> {
        config.check()?;
        let rate_hz = config.sample_rate.0;
        let contact_n = config.grip.unwrap_or_default().contact_n;
        let health = match config.signal {
            Signal::Displacement => HealthCheck::new(config.health, config.sample_rate),
            Signal::Vibration => HealthCheck::uncalibrated(config.health, config.sample_rate),
        };
        Ok(Self {
            health: config.grip.map_or(health, |grip| health.of_gripper(grip.f_max_n)),
            contact: Contact::new(contact_n),
            detector: SlipDetector::new(
                &config.detector,
                config.floor,
                KnownFloors { stylus: config.known_floor, reference: config.known_reference },
                rate_hz,
            )?
            .with_no_skip(config.no_skip)
            .with_certificate(config.certificate.as_ref()),
            fusion: Fusion::new(config.methods, config.travel, config.pressure)?,
            standing: Standing::default(),
            grasp: Grasp::default(),
            observation: SlipObservation::new(config.observation, rate_hz)
                .with_travel_sigma(config.velocity.travel_sigma_m(config.travel.resolution_m)),
            course: Course::default(),
            velocity: VelocityMeter::new(config.velocity, rate_hz)?,
            friction: FrictionMeter::new(rate_hz),
            freshness: Freshness::new(Micros::from_ms(1e3 / rate_hz)),
            whiteness: Whiteness::default(),
            turns: Turns::default(),
            sink: Sink::default(),
            need: Need::default(),
            load: Load::new(Grid::MICRO),
            travel_quality: TravelQuality::default(),
            ended: None,
            estimator,
            grip: config.grip.map(GripController::new),
            last_t: None,
            slip: None,
            detection: None,
            scene: Scene::Idle,
            decides: false,
            rest: Rest::Awake,
            gap: health::gap(config.sample_rate),
            evidence_every: Micros(1000),
            untouched: None,
            counters: StageCounters::default(),
            config,
        })
    }

    /// The same where another pipeline has held the object before: the controller goes on with `carried_n` (N), where
    /// that is a force above 0.
    ///
    /// # Errors
    /// As [`Pipeline::new`].
    pub fn resumed(
        config: PipelineConfig,
        estimator: Option<Estimator<W>>,
        carried_n: Option<f32>,
    ) -> Result<Self, ConfigError> {
        let mut pipeline = Self::new(config, estimator)?;
        pipeline.grip =
            config.grip.map(|config| GripController::holding(config, carried_n.unwrap_or(0.0)));
        Ok(pipeline)
    }
}
