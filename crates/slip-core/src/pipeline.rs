//! The data path on one page: `Sample -> health -> scene -> bands -> slip -> features -> estimate -> command`.
//!
//! [`Pipeline::handle`] costs a fixed time, allocates nothing, takes no lock, does not panic and reads no
//! clock; the same samples give the same steps everywhere.

use crate::{
    confidence::confidence,
    config::{ConfigError, PipelineConfig, Signal},
    detector::{KnownFloors, MotionInput, SlipDetector, SlipState},
    distance::Fingers,
    drift::Hold,
    estimate::{Estimator, ForceEstimate},
    event::{Phase, SlipEvent, Step},
    features::Features,
    fusion::{Channels, Fusion, Told},
    grip::{GripController, GripInput, GripState, SlipNow},
    health::{Health, HealthCheck, HealthCounters},
    methods::Method,
    observation::SlipObservation,
    sample::Sample,
    scene::{Contact, Scene},
    stages::StageCounters,
    units::{Micros, Newtons},
    velocity::{Measured, Velocity, VelocityMeter},
};

/// The whole signal path of one gripper. `W` holds the weights of the network.
#[derive(Clone, Debug)]
pub struct Pipeline<W> {
    config: PipelineConfig,
    health: HealthCheck,
    contact: Contact,
    detector: SlipDetector,
    fusion: Fusion,
    observation: SlipObservation,
    velocity: VelocityMeter,
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
    /// Whether the stylus sees it now.
    felt: bool,
    next_evidence: Micros,
}

#[derive(Clone, Copy, Debug, Default)]
struct Evidence {
    features: Option<Features>,
    velocity: Option<Velocity>,
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
            fusion: Fusion::new(config.methods, config.travel, config.pressure)?,
            observation: SlipObservation::new(config.observation, rate_hz),
            velocity: VelocityMeter::new(config.velocity, rate_hz)?,
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
        self.handle_with(sample, &[])
    }

    /// [`Pipeline::handle`] for a gripper with a taxel array: `taxels` is the frame that came with the sample, empty where there is
    /// none. At most [`MAX_TAXELS`](crate::pressure::MAX_TAXELS) are looked at.
    #[inline]
    pub fn handle_with(&mut self, sample: &Sample, taxels: &[f32]) -> Step {
        self.counters.samples += 1;
        let before = self.health.health();
        let Some(sample) = self.health.check(sample) else { return self.unchanged(sample.t) };
        let dt = self.last_t.map_or(Micros(0), |last| sample.t.since(last));
        self.last_t = Some(sample.t);
        let scene = self.enter_scene(&sample, dt);
        self.health.watch_drift(&sample, self.hold());
        let recovered = before != Health::Good && self.health.health() == Health::Good;
        if recovered {
            // A sensor may come back with another zero, which is no slip.
            self.detector.prime();
        }
        let felt = self.detect(&sample);
        let told = self.join(&sample, taxels, felt);
        let sample = Sample { travel_m: self.fusion.believed_travel(sample.travel_m), ..sample };
        let statistic = told.map_or(0.0, |told| told.statistic);
        let event = self.slip_event(scene, &sample, told);
        self.feel(felt);
        let evidence = self.observe(&sample);
        let command = self.command(&sample, dt, self.is_fresh(sample.t), evidence.estimate);
        let (travel_health, pressure_health) = self.fusion.healths();
        Step {
            t: sample.t,
            scene,
            statistic,
            event,
            features: evidence.features,
            velocity: evidence.velocity,
            estimate: evidence.estimate,
            command,
            health: self.health.health(),
            travel_health,
            pressure_health,
        }
    }

    /// The scene of this sample; where it differs from the last one, the stages that start afresh do so.
    fn enter_scene(&mut self, sample: &Sample, dt: Micros) -> Scene {
        let touching = self.contact.update(sample.normal_force_n);
        let grip = self.grip.map_or(GripState::Holding, |grip| grip.state());
        let closing = matches!(grip, GripState::Closing | GripState::Settling);
        let decides = self.slip.is_some() || (touching && !closing);
        let wakes = decides && !self.decides;
        if wakes || dt > self.gap {
            self.detector.prime();
        }
        if wakes {
            self.fusion.prime();
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

    /// What the hand does, for the drift of the stylus.
    #[inline]
    fn hold(&self) -> Hold {
        match self.slip {
            Some(_) => Hold::Slipping,
            None if self.decides => Hold::Still,
            None => Hold::None,
        }
    }

    /// Statistic and state of the slip detector, where the scene needs it: while the floor is being
    /// learned and while an object is held.
    fn detect(&mut self, sample: &Sample) -> Option<(f32, SlipState)> {
        if !self.fusion.uses(Method::Stylus) {
            return None;
        }
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

    /// What stylus, travel and pressure say together, where the scene needs it.
    #[inline]
    fn join(
        &mut self,
        sample: &Sample,
        taxels: &[f32],
        felt: Option<(f32, SlipState)>,
    ) -> Option<Told> {
        if !(self.decides || self.config.no_skip) {
            return None;
        }
        self.counters.methods +=
            u64::from(sample.travel_m.is_some()) + u64::from(!taxels.is_empty());
        // An arm that moves carries fingers and object alike.
        let fingers = if self.decides { Fingers::Still } else { Fingers::Moving };
        let seen =
            Channels { t: sample.t, travel_m: sample.travel_m, taxels, fingers, stylus: felt };
        self.fusion.step(&seen, self.decides)
    }

    /// Remembers whether the stylus sees the slip that goes on.
    #[inline]
    fn feel(&mut self, felt: Option<(f32, SlipState)>) {
        if let Some(slip) = &mut self.slip {
            slip.felt = felt.is_some_and(|(_, state)| state != SlipState::Quiet);
        }
    }

    /// Whether the slip goes on right now: by the stylus, the fastest, where it sees the slip; else by the others.
    fn is_fresh(&self, t: Micros) -> bool {
        match self.slip {
            Some(slip) if !slip.felt => self.fusion.is_fresh(t),
            _ => self.detector.is_fresh(),
        }
    }

    fn slip_event(
        &mut self,
        scene: Scene,
        sample: &Sample,
        told: Option<Told>,
    ) -> Option<SlipEvent> {
        let state = told.map_or(SlipState::Quiet, |told| told.state);
        let method = told.map_or(Method::Stylus, |told| told.method);
        let sure = || confidence(told.map_or(0.0, |t| t.statistic), self.config.detector.tail);
        match (&mut self.slip, state) {
            (None, SlipState::Incipient | SlipState::Gross) => {
                let gross = state == SlipState::Gross;
                let heights = self.config.signal == Signal::Displacement;
                self.observation.begin(heights.then(|| self.detector.noise_rms()));
                self.velocity.begin();
                self.slip = Some(Slip {
                    since: sample.t,
                    gross,
                    felt: false,
                    next_evidence: sample.t.plus(self.evidence_every),
                });
                let phase = if gross { Phase::Gross } else { Phase::Incipient };
                Some(SlipEvent::Slip { phase, first: true, method, confidence: sure() })
            }
            (Some(slip), SlipState::Gross) if !slip.gross => {
                slip.gross = true;
                let confidence = sure();
                Some(SlipEvent::Slip { phase: Phase::Gross, first: false, method, confidence })
            }
            (Some(slip), SlipState::Quiet) if scene == Scene::Slipping => {
                let duration = sample.t.since(slip.since);
                self.slip = None;
                self.fusion.slip_ended();
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
        if self.slip.is_some() || self.config.no_skip {
            self.counters.observation += 1;
            self.velocity.push(sample);
            self.observation.push(&self.with_speed(sample));
        }
        let Some(slip) = &mut self.slip else { return Evidence::default() };
        if sample.t < slip.next_evidence {
            return Evidence::default();
        }
        slip.next_evidence = sample.t.plus(self.evidence_every);
        let since = sample.t.since(slip.since);
        let velocity = self.velocity.velocity(self.measured(sample), since);
        let Some(features) = self.observation.features() else {
            return Evidence { velocity, ..Evidence::default() };
        };
        let estimate = self.estimator.as_ref().and_then(|estimator| {
            self.counters.inferences += 1;
            let answer = estimator.estimate(&features);
            self.counters.refused_estimates += u64::from(answer.is_err());
            answer.ok()
        });
        Evidence { features: Some(features), velocity, estimate }
    }

    /// The sample with the speed of the two styli, where no other sensor tells it.
    #[inline]
    fn with_speed(&self, sample: &Sample) -> Sample {
        let known = sample.travel_m.is_some() || sample.velocity_m_s.is_some();
        if known || sample.second_stylus.is_none() {
            return *sample;
        }
        let velocity_m_s = self.velocity.two_styli().map(|velocity| velocity.speed_m_s);
        Sample { velocity_m_s, ..*sample }
    }

    fn measured(&self, sample: &Sample) -> Measured {
        let travel = self.observation.travel_speed();
        Measured {
            fixed_m_s: self.config.observation.speed.fixed_m_s,
            direct_m_s: sample.velocity_m_s,
            travel: travel.map(|(speed, window)| (speed, window, self.config.travel.resolution_m)),
        }
    }

    fn command(
        &mut self,
        sample: &Sample,
        dt: Micros,
        fresh: bool,
        estimate: Option<ForceEstimate>,
    ) -> Option<Newtons> {
        let grip = self.grip.as_mut()?;
        if !(self.fusion.uses(Method::Stylus) && self.detector.is_learning()) {
            grip.grasp(sample.normal_force_n);
        }
        // An answer from outside the range the network knows must not move the fingers.
        let estimate_n = estimate.filter(|e| !e.extrapolated).map(|e| e.force_n);
        #[expect(clippy::cast_possible_truncation, reason = "the controller limits the step")]
        let dt_s = dt.as_seconds() as f32;
        let healthy = if self.fusion.uses(Method::Stylus) {
            self.health.health() == Health::Good
        } else {
            self.fusion.healthy()
        };
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
            healthy,
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
            velocity: None,
            estimate: None,
            command: self.grip.map(|grip| Newtons(grip.command_n())),
            health: self.health.health(),
            travel_health: self.fusion.healths().0,
            pressure_health: self.fusion.healths().1,
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
