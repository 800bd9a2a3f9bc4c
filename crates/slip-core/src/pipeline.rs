//! The data path on one page: `Sample -> health -> scene -> bands -> slip -> features -> estimate -> command`.
//!
//! [`Pipeline::handle`] costs a fixed time, allocates nothing, takes no lock, does not panic and reads no
//! clock; the same samples give the same steps everywhere.

mod causes;
mod coarse;
mod evidence;
mod force;
mod grip_force;
mod host_time;
mod rest;

use crate::{
    ClientCommand, Phase, Signal,
    causes::Causes,
    confidence::confidence,
    config::PipelineConfig,
    course::Course,
    crosscheck::Whiteness,
    detector::{KnownFloors, MotionInput, SlipDetector, SlipState},
    distance::Fingers,
    drift::Hold,
    error::ConfigError,
    estimate::{Estimator, friction::FrictionMeter},
    event::{SlipEvent, Step},
    fusion::{Channels, Fusion, Told},
    grip::{GripController, GripState, Trials},
    health::{HealthCheck, HealthCounters, SensorHealth},
    methods::Method,
    need::Need,
    observation::SlipObservation,
    pressure::Standing,
    sample::Sample,
    scene::{Contact, Scene},
    stages::StageCounters,
    turns::Turns,
    units::{Micros, Newtons},
    velocity::VelocityMeter,
};
use causes::Grasp;
use coarse::TravelQuality;
use force::SlipNews;
use grip_force::GripForce;
use host_time::HostTime;
use rest::Rest;

/// A slip without touch ends after this long.
const LET_GO: Micros = Micros(30_000);

/// The whole signal path of one gripper. `W` holds the weights of the network.
#[derive(Clone, Debug)]
pub struct Pipeline<W> {
    config: PipelineConfig,
    health: HealthCheck,
    contact: Contact,
    detector: SlipDetector,
    fusion: Fusion,
    standing: Standing,
    grasp: Grasp,
    observation: SlipObservation,
    course: Course,
    velocity: VelocityMeter,
    friction: FrictionMeter,
    grip_force: GripForce,
    host_time: HostTime,
    whiteness: Whiteness,
    turns: Turns,
    need: Need,
    travel_quality: TravelQuality,
    /// When the last slip ended.
    ended: Option<Micros>,
    estimator: Option<Estimator<W>>,
    grip: Option<GripController>,
    last_t: Option<Micros>,
    slip: Option<Slip>,
    /// What the methods said when they were last asked.
    told: Option<Told>,
    scene: Scene,
    decides: bool,
    rest: Rest,
    gap: Micros,
    evidence_every: Micros,
    /// Since when nothing is touched, while a slip goes on.
    untouched: Option<Micros>,
    counters: StageCounters,
}

/// The slip that goes on.
#[derive(Clone, Copy, Debug)]
struct Slip {
    since: Micros,
    gross: bool,
    /// Whether the stylus sees it now.
    felt: bool,
    /// Whether the stylus can tell the needed force, and whether it is the only sensor that does.
    feels: bool,
    alone: bool,
    next_evidence: Micros,
    /// The interval it is certified with (s).
    certified_s: Option<f32>,
    /// What was known of the grip when it was noticed.
    grip_causes: Causes,
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
            grip_force: GripForce::new(rate_hz),
            host_time: HostTime::new(config.sample_rate),
            whiteness: Whiteness::default(),
            turns: Turns::default(),
            need: Need::default(),
            travel_quality: TravelQuality::default(),
            ended: None,
            estimator,
            grip: config.grip.map(GripController::new),
            last_t: None,
            slip: None,
            told: None,
            scene: Scene::Idle,
            decides: false,
            rest: Rest::Awake,
            gap: Micros((period_us * 5).max(10_000)),
            evidence_every: Micros(1000),
            untouched: None,
            counters: StageCounters::default(),
            config,
        })
    }

    /// The same where another pipeline has held the object before: the controller goes on with `carried_n` (N), where that is a force above 0.
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
        self.host_time.arrive(sample.arrival, self.last_t);
        let before = self.health.health();
        let plain = self.health.passes(sample);
        match self.rest_of(sample) {
            Rest::Idle if plain => {
                self.last_t = Some(sample.t);
                return self.unchanged(sample.t);
            }
            Rest::Holding if plain && taxels.is_empty() => return self.hold(sample),
            _ => {}
        }
        let mended;
        let sample = if plain {
            sample
        } else if let Some(safe) = self.health.check(sample) {
            mended = safe;
            &mended
        } else {
            return self.unchanged(sample.t);
        };
        self.look(sample, taxels, before != SensorHealth::Good)
    }

    /// Every stage after the sensor's health: `sample` is safe to compute with, `ailed` says whether the one before was not.
    fn look(&mut self, sample: &Sample, taxels: &[f32], ailed: bool) -> Step {
        let dt = self.since_last(sample.t);
        self.fusion.catch_up();
        self.enter_scene(sample, dt);
        self.health.watch_drift(sample, self.hand());
        self.compare_force(sample);
        if ailed && self.health.health() == SensorHealth::Good {
            // A sensor may come back with another zero, which is no slip.
            self.detector.prime();
        }
        self.examine(sample, taxels, dt)
    }

    /// Every stage of the scene.
    fn examine(&mut self, sample: &Sample, taxels: &[f32], dt: Micros) -> Step {
        let felt = self.detect(sample);
        let told = self.join(sample, taxels, felt);
        self.conclude(sample, dt, felt, told)
    }

    /// The step of a sample on which the methods have spoken.
    fn conclude(
        &mut self,
        sample: &Sample,
        dt: Micros,
        felt: Option<(f32, SlipState)>,
        told: Option<Told>,
    ) -> Step {
        let certified_s =
            felt.filter(|_| !self.fusion.doubts_stylus()).and_then(|_| self.detector.certified_s());
        let event = self.slip_event(sample, told, certified_s);
        let statistic = told.map_or(0.0, |told| told.statistic);
        if self.slip.is_some() || self.config.no_skip {
            self.feel(felt);
            let sample = &Sample { normal_force_n: self.force_of(sample, dt), ..*sample };
            if self.slip.is_some() {
                #[expect(clippy::cast_possible_truncation, reason = "a step of time")]
                self.turns.step(sample.stylus, self.detector.noise_rms(), dt.as_seconds() as f32);
                let statistic =
                    |(statistic, _)| if self.detector.is_fresh() { statistic } else { 0.0 };
                let noise = (self.observation.travel_sigma_m(), self.detector.noise_rms());
                // Behind the motion gate a stylus may be silent in a slip: nothing is weighed against the force then.
                let normal_force_n = sample.normal_force_n.filter(|_| !self.detector.is_moving());
                let seen = Sample { normal_force_n, ..*sample };
                self.fusion.compare(&seen, dt, noise, felt.map(statistic));
            }
            let travel_m = self.travel_of(sample, event);
            let step = Step { statistic, event, ..self.unchanged(sample.t) };
            return self.follow(&Sample { travel_m, ..*sample }, dt, step);
        }
        let (command, grip) = self.command(sample, dt, SlipNews::default());
        self.rest = self.rest_after();
        Step { statistic, event, command, grip, ..self.unchanged(sample.t) }
    }

    /// Adds to the `step` of a slip what is known of it, and the command.
    fn follow(&mut self, sample: &Sample, dt: Micros, mut step: Step) -> Step {
        self.observe(sample, &mut step);
        self.weigh_need(sample, step.event);
        let news = self.slip_news(sample, &step);
        (step.command, step.grip) = self.command(sample, dt, news);
        self.rest = Rest::Awake;
        step
    }

    /// Time since the sample before; the next one counts from this.
    #[inline]
    fn since_last(&mut self, t: Micros) -> Micros {
        self.last_t.replace(t).map_or(Micros(0), |last| t.since(last))
    }

    /// The scene of this sample; where it differs from the last one, the stages that start afresh do so.
    fn enter_scene(&mut self, sample: &Sample, dt: Micros) {
        let touches = self.contact.would_touch(sample.normal_force_n);
        let slides = !touches && self.slides_on(sample.t);
        let force_n = self.grip_force.touch(sample.normal_force_n, touches, slides);
        let touching = self.contact.update(force_n);
        let grip = self.grip.map_or(GripState::Holding, |grip| grip.state());
        let closing =
            matches!(grip, GripState::Closing | GripState::Settling | GripState::Released);
        self.untouched =
            (self.slip.is_some() && !touching).then(|| self.untouched.unwrap_or(sample.t));
        let decides = self.slip.is_some() || (touching && !closing);
        let wakes = decides && !self.decides;
        if wakes || dt > self.gap {
            self.detector.prime();
            self.travel_quality.begin();
        }
        if wakes {
            self.friction.prime();
            self.grip_force.prime();
            self.fusion.prime();
            self.standing.prime();
            self.grasp.begin(sample.t);
        }
        self.decides = decides;
        self.scene = match decides {
            _ if self.slip.is_some() => Scene::Slipping,
            true if self.detector.is_moving() => Scene::Moving,
            true => Scene::Holding,
            false if closing => Scene::Moving,
            false => Scene::Idle,
        };
    }

    /// Whether the travel shows that the object slides.
    #[cold]
    fn slides_on(&self, t: Micros) -> bool {
        let sigma_m = self.observation.travel_sigma_m();
        let motion = self.course.motion(t).filter(|_| self.slip.is_some());
        motion.is_some_and(|motion| motion.slides(sigma_m))
    }

    /// What the hand does, for the drift of the stylus.
    #[inline]
    fn hand(&self) -> Hold {
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
        let trusted = self.health.feels();
        // The silence of a dead sensor is no noise floor.
        if self.decides || (learning && trusted) {
            let verdict = self.feel_for_slip(sample);
            if learning && self.slip.is_some() {
                // Another method sees a slip: this is no rest.
                self.detector.forget_floor();
            }
            let sound = self.is_sound(sample);
            return (self.decides && trusted && sound).then_some(verdict).flatten();
        }
        if self.config.no_skip && !learning {
            self.counters.bands += 1;
            self.counters.gate += 1;
            self.detector.beside(sample);
            self.detector.step_unheard(sample.stylus, &motion_of(sample));
        }
        None
    }

    /// Whether the stylus shows a surface, and not the noise of its electronics. Asked in a slip, and from then on until it does.
    fn is_sound(&mut self, sample: &Sample) -> bool {
        let asked = self.slip.is_some() || self.whiteness.is_noisy();
        let heights = self.config.signal == Signal::Displacement;
        if asked && heights && self.config.sample_rate.0 >= Turns::LEAST_RATE_HZ {
            self.whiteness.step(sample.stylus, self.detector.noise_rms());
        }
        !self.whiteness.is_noisy()
    }

    /// Statistic and state of the slip detector.
    #[inline]
    fn feel_for_slip(&mut self, sample: &Sample) -> Option<(f32, SlipState)> {
        self.counters.bands += 1;
        self.detector.beside(sample);
        let verdict = self.detector.step(sample.stylus, &motion_of(sample));
        self.counters.gate += u64::from(self.detector.is_moving() || self.config.no_skip);
        verdict
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
        // A controller knows when it closes, and what it does to the force in a slip is no reason to wait.
        let force_stands = self.grip.is_some()
            || taxels.is_empty()
            || self.standing.step(sample.t, sample.normal_force_n);
        let (t, travel_m) = (sample.t, sample.travel_m);
        let seen = Channels { t, travel_m, taxels, fingers, force_stands, stylus: felt };
        self.fusion.watch(&seen, self.decides);
        if !self.decides {
            return None;
        }
        // Before a slip the methods are asked when the stylus has news, or an array; the travel waits for them.
        let in_block = felt.is_some() && self.detector.in_block();
        if !in_block || self.slip.is_some() || !taxels.is_empty() {
            self.told = self.fusion.tell(felt);
            self.grasp.step(sample.t, self.force_known(sample));
        }
        self.told
    }

    /// Remembers whether the stylus sees the slip that goes on.
    #[inline]
    fn feel(&mut self, felt: Option<(f32, SlipState)>) {
        if let Some(slip) = &mut self.slip {
            slip.felt = felt.is_some_and(|(_, state)| state != SlipState::Quiet);
        }
    }

    #[inline]
    fn slip_event(
        &mut self,
        sample: &Sample,
        told: Option<Told>,
        certified_s: Option<f32>,
    ) -> Option<SlipEvent> {
        let state = told.map_or(SlipState::Quiet, |told| told.state);
        let method = told.map_or(Method::Stylus, |told| told.method);
        if self.has_let_go(sample.t) {
            return self.end_slip(sample.t);
        }
        let phase = |gross| if gross { Phase::Gross } else { Phase::Incipient };
        let (phase, first, certified_s) = match (&mut self.slip, state) {
            (None, SlipState::Incipient | SlipState::Gross) => {
                let gross = state == SlipState::Gross;
                let heights = self.config.signal == Signal::Displacement;
                self.observation.begin(heights.then(|| self.detector.noise_rms()));
                self.course.reset();
                self.fusion.slip_began();
                self.whiteness.begin();
                self.turns = Turns::default();
                self.velocity.begin();
                self.friction.begin();
                let command_n = self.grip.map_or(0.0, |grip| grip.command_n());
                self.grip_force.begin(command_n, sample.normal_force_n);
                self.slip = Some(Slip {
                    since: sample.t,
                    gross,
                    felt: false,
                    feels: false,
                    alone: false,
                    next_evidence: sample.t.plus(self.evidence_every),
                    certified_s,
                    grip_causes: Causes::default(),
                });
                (phase(gross), true, certified_s)
            }
            (Some(slip), SlipState::Gross) if !slip.gross => {
                slip.gross = true;
                slip.certified_s = slip.certified_s.or(certified_s);
                (Phase::Gross, false, slip.certified_s)
            }
            (Some(_), SlipState::Quiet) if self.scene == Scene::Slipping => {
                return self.end_slip(sample.t);
            }
            (Some(slip), _) if certified_s.is_some() && slip.certified_s.is_none() => {
                slip.certified_s = certified_s;
                (phase(slip.gross), false, certified_s)
            }
            _ => return None,
        };
        let causes = self.causes(sample, told, (first, certified_s.is_some()));
        let confidence = confidence(told.map_or(0.0, |t| t.statistic), self.config.detector.tail);
        Some(SlipEvent::Slip { phase, first, method, confidence, certified_s, causes })
    }

    /// Whether nothing has been touched for [`LET_GO`] while a slip goes on: the object is gone, whatever the sensors still show.
    #[inline]
    fn has_let_go(&self, t: Micros) -> bool {
        self.untouched.is_some_and(|since| t.since(since) >= LET_GO)
    }

    #[cold]
    fn end_slip(&mut self, t: Micros) -> Option<SlipEvent> {
        let slip = self.slip.take()?;
        self.ended = Some(t);
        self.fusion.slip_ended();
        self.untouched = None;
        Some(SlipEvent::Ended { duration: t.since(slip.since), certified_s: slip.certified_s })
    }

    #[inline]
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
            grip: None,
            sensors: [
                self.stylus_health(),
                self.travel_health(),
                self.fusion.healths().1,
                self.detector.reference_health(),
            ],
            floor_health: self.detector.floor_health(),
        }
    }

    /// The health of the sensor, and where nothing is wrong with that, whether it has a say.
    #[inline]
    fn stylus_health(&self) -> SensorHealth {
        match self.health.health() {
            SensorHealth::Good if self.fusion.doubts_stylus() || self.whiteness.is_noisy() => {
                SensorHealth::Doubted
            }
            health => health,
        }
    }

    #[inline]
    fn travel_health(&self) -> SensorHealth {
        match self.fusion.healths().0 {
            SensorHealth::Good if self.fusion.doubts_travel() => SensorHealth::Doubted,
            SensorHealth::Good if self.travel_quality.is_coarse() => SensorHealth::Coarse,
            health => health,
        }
    }

    /// Carries out what concerns the controller; `false` where the command is none of that or its force is no force.
    pub fn obey(&mut self, command: ClientCommand) -> bool {
        match command {
            ClientCommand::AtLeast(force_n) if force_n >= 0.0 => self.at_least(force_n),
            ClientCommand::Release => self.release(),
            ClientCommand::Grasp => self.close_again(),
            ClientCommand::AtLeast(_) | ClientCommand::Stop | ClientCommand::ClearFault(_) => {
                return false;
            }
        }
        true
    }

    /// What the force controller is doing; `None` in a pipeline that only observes.
    #[must_use]
    pub fn grip_state(&self) -> Option<GripState> {
        self.grip.map(|grip| grip.state())
    }

    /// How the object in hand was tried so far; `None` in a pipeline that only observes.
    #[must_use]
    pub fn trials(&self) -> Option<Trials> {
        self.grip.map(|grip| grip.trials())
    }

    /// The slip detector, for what it has learned and sees.
    #[must_use]
    pub fn detector(&self) -> &SlipDetector {
        &self.detector
    }

    /// How often each stage ran.
    #[must_use]
    pub fn stage_counters(&self) -> StageCounters {
        StageCounters { floor_lowered: self.detector.floor_lowered().into(), ..self.counters }
    }

    /// Unusable readings so far.
    #[must_use]
    pub fn health_counters(&self) -> HealthCounters {
        self.health.counters()
    }
}

/// What a sample tells of the robot's motion.
#[inline]
fn motion_of(sample: &Sample) -> MotionInput {
    MotionInput {
        reference: sample.reference,
        commanded: sample.motion.is_some_and(|motion| motion != 0.0),
    }
}
