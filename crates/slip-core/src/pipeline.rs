//! The data path on one page: `Sample -> health -> scene -> bands -> slip -> features -> estimate -> command`.
//!
//! [`Pipeline::handle`] costs a fixed time, allocates nothing, takes no lock, does not panic and reads no
//! clock; the same samples give the same steps everywhere.

use crate::{
    config::{ConfigError, PipelineConfig, Signal},
    detector::{KnownFloors, MotionInput, SlipDetector, SlipState},
    estimate::{Estimator, ForceEstimate},
    event::{Phase, SlipEvent, Step},
    features::Features,
    grip::{GripController, GripInput, GripState, SlipNow},
    health::{Health, HealthCheck, HealthCounters},
    observation::SlipObservation,
    sample::Sample,
    scene::{Contact, Scene},
    stages::StageCounters,
    units::{Micros, Newtons},
};

/// The whole signal path of one gripper. `W` holds the weights of the network.
#[derive(Clone, Debug)]
pub struct Pipeline<W> {
    config: PipelineConfig,
    health: HealthCheck,
    contact: Contact,
    detector: SlipDetector,
    observation: SlipObservation,
    estimator: Option<Estimator<W>>,
    grip: Option<GripController>,
    last_t: Option<Micros>,
    slip: Option<Slip>,
    scene: Scene,
    decides: bool,
    gap: Micros,
    evidence_every: Micros,
    counters: StageCounters,
}

/// The slip that goes on.
#[derive(Clone, Copy, Debug)]
struct Slip {
    since: Micros,
    gross: bool,
    next_evidence: Micros,
}

#[derive(Clone, Copy, Debug, Default)]
struct Evidence {
    features: Option<Features>,
    estimate: Option<ForceEstimate>,
}

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
        let period_us = (1e6 / rate_hz).max(1.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "1 to 1e6, checked"
        )]
        let period_us = period_us as u64;
        Ok(Self {
            health: match config.signal {
                Signal::Displacement => HealthCheck::new(config.health),
                Signal::Vibration => HealthCheck::uncalibrated(config.health),
            },
            contact: Contact::new(contact_n),
            detector: SlipDetector::new(
                &config.detector,
                config.floor,
                KnownFloors { stylus: config.known_floor, reference: config.known_reference },
                rate_hz,
            )?
            .with_no_skip(config.no_skip),
            observation: SlipObservation::new(config.observation, rate_hz),
            estimator,
            grip: config.grip.map(GripController::new),
            last_t: None,
            slip: None,
            scene: Scene::Idle,
            decides: false,
            gap: Micros((period_us * 5).max(10_000)),
            evidence_every: Micros(1000),
            counters: StageCounters::default(),
            config,
        })
    }

    /// Takes one sample and says what it led to. A sample that is not later than the one before is counted and changes nothing.
    #[inline]
    pub fn handle(&mut self, sample: &Sample) -> Step {
        self.counters.samples += 1;
        let before = self.health.health();
        let Some(sample) = self.health.check(sample) else { return self.unchanged(sample.t) };
        let dt = self.last_t.map_or(Micros(0), |last| sample.t.since(last));
        self.last_t = Some(sample.t);
        let recovered = before != Health::Good && self.health.health() == Health::Good;
        let scene = self.enter_scene(&sample, dt);
        if recovered {
            // A sensor may come back with another zero, which is no slip.
            self.detector.prime();
        }
        let detected = self.detect(&sample);
        let statistic = detected.map_or(0.0, |(statistic, _)| statistic);
        let event = self.slip_event(scene, &sample, detected);
        let evidence = self.observe(&sample);
        let command = self.command(&sample, dt, self.detector.is_fresh(), evidence.estimate);
        Step {
            t: sample.t,
            scene,
            statistic,
            event,
            features: evidence.features,
            estimate: evidence.estimate,
            command,
            health: self.health.health(),
        }
    }

    /// The scene of this sample; where it differs from the last one, the stages that start afresh do so.
    fn enter_scene(&mut self, sample: &Sample, dt: Micros) -> Scene {
        let touching = self.contact.update(sample.normal_force_n);
        let grip = self.grip.map_or(GripState::Holding, |grip| grip.state());
        let closing = matches!(grip, GripState::Closing | GripState::Settling);
        let decides = self.slip.is_some() || (touching && !closing);
        if (decides && !self.decides) || dt > self.gap {
            self.detector.prime();
        }
        self.decides = decides;
        self.scene = match decides {
            _ if self.slip.is_some() => Scene::Slipping,
            true if self.detector.is_moving() => Scene::Moving,
            true => Scene::Holding,
            false if closing => Scene::Moving,
            false => Scene::Idle,
        };
        self.scene
    }

    /// Statistic and state of the slip detector, where the scene needs it: while the floor is being
    /// learned and while an object is held.
    fn detect(&mut self, sample: &Sample) -> Option<(f32, SlipState)> {
        let learning = self.detector.is_learning();
        let trusted = self.health.health() == Health::Good;
        let motion = MotionInput {
            reference: sample.reference,
            commanded: sample.motion.is_some_and(|motion| motion != 0.0),
        };
        // The silence of a dead sensor is no noise floor.
        if self.decides || (learning && trusted) {
            self.counters.bands += 1;
            let verdict = self.detector.step(sample.stylus, &motion);
            self.counters.gate += u64::from(self.detector.is_moving() || self.config.no_skip);
            return (self.decides && trusted).then_some(verdict).flatten();
        }
        if self.config.no_skip && !learning {
            self.counters.bands += 1;
            self.counters.gate += 1;
            self.detector.step_unheard(sample.stylus, &motion);
        }
        None
    }

    fn slip_event(
        &mut self,
        scene: Scene,
        sample: &Sample,
        detected: Option<(f32, SlipState)>,
    ) -> Option<SlipEvent> {
        let state = detected.map_or(SlipState::Quiet, |(_, state)| state);
        match (&mut self.slip, state) {
            (None, SlipState::Incipient | SlipState::Gross) => {
                let gross = state == SlipState::Gross;
                let heights = self.config.signal == Signal::Displacement;
                self.observation.begin(heights.then(|| self.detector.noise_rms()));
                self.slip = Some(Slip {
                    since: sample.t,
                    gross,
                    next_evidence: sample.t.plus(self.evidence_every),
                });
                let phase = if gross { Phase::Gross } else { Phase::Incipient };
                Some(SlipEvent::Slip { phase, first: true })
            }
            (Some(slip), SlipState::Gross) if !slip.gross => {
                slip.gross = true;
                Some(SlipEvent::Slip { phase: Phase::Gross, first: false })
            }
            (Some(slip), SlipState::Quiet) if scene == Scene::Slipping => {
                let duration = sample.t.since(slip.since);
                self.slip = None;
                Some(SlipEvent::Ended { duration })
            }
            _ => None,
        }
    }
}

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// Follows a slip: speed, irregularities and E_sc with every sample, features and the network's
    /// answer once a millisecond.
    fn observe(&mut self, sample: &Sample) -> Evidence {
        let Some(slip) = &mut self.slip else {
            if self.config.no_skip {
                self.counters.observation += 1;
                self.observation.push(sample);
            }
            return Evidence::default();
        };
        self.counters.observation += 1;
        self.observation.push(sample);
        if sample.t < slip.next_evidence {
            return Evidence::default();
        }
        slip.next_evidence = sample.t.plus(self.evidence_every);
        let Some(features) = self.observation.features() else { return Evidence::default() };
        let estimate = self.estimator.as_ref().and_then(|estimator| {
            self.counters.inferences += 1;
            let answer = estimator.estimate(&features);
            self.counters.refused_estimates += u64::from(answer.is_err());
            answer.ok()
        });
        Evidence { features: Some(features), estimate }
    }

    fn command(
        &mut self,
        sample: &Sample,
        dt: Micros,
        fresh: bool,
        estimate: Option<ForceEstimate>,
    ) -> Option<Newtons> {
        let grip = self.grip.as_mut()?;
        if !self.detector.is_learning() {
            grip.grasp(sample.normal_force_n);
        }
        // An answer from outside the range the network knows must not move the fingers.
        let estimate_n = estimate.filter(|e| !e.extrapolated).map(|e| e.force_n);
        #[expect(clippy::cast_possible_truncation, reason = "the controller limits the step")]
        let dt_s = dt.as_seconds() as f32;
        let command = grip.step(&GripInput {
            dt_s,
            slip: match self.slip {
                None => SlipNow::No,
                Some(_) if fresh && self.observation.advancing() != Some(false) => SlipNow::Evident,
                Some(_) => SlipNow::Fading,
            },
            moved_m: self.slip.and_then(|_| self.observation.moved_m(sample)),
            estimate_n,
            applied_n: sample.normal_force_n,
            healthy: self.health.health() == Health::Good,
        });
        Some(Newtons(command))
    }

    fn unchanged(&self, t: Micros) -> Step {
        Step {
            t,
            scene: self.scene,
            statistic: 0.0,
            event: None,
            features: None,
            estimate: None,
            command: self.grip.map(|grip| Newtons(grip.command_n())),
            health: self.health.health(),
        }
    }

    /// What the force controller is doing; `None` in a pipeline that only observes.
    #[must_use]
    pub fn grip_state(&self) -> Option<GripState> {
        self.grip.map(|grip| grip.state())
    }

    /// The slip detector, for what it has learned and sees.
    #[must_use]
    pub fn detector(&self) -> &SlipDetector {
        &self.detector
    }

    /// How often each stage ran.
    #[must_use]
    pub fn stage_counters(&self) -> StageCounters {
        self.counters
    }

    /// Unusable readings so far.
    #[must_use]
    pub fn health_counters(&self) -> HealthCounters {
        self.health.counters()
    }
}
