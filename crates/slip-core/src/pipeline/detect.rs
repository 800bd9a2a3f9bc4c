//! A sample in; its scene, and what stylus, travel and pressure detect, out.

use super::Pipeline;
use crate::{
    Signal,
    detector::{MotionInput, SlipState},
    drift::Hold,
    event::Step,
    fusion::Detection,
    grip::GripState,
    health::SensorHealth,
    methods::Method,
    sample::Sample,
    scene::Scene,
    turns::Turns,
    units::{Micros, Newtons},
};

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// Time since the sample before; the next one counts from this.
    #[inline]
    pub(super) fn since_last(&mut self, t: Micros) -> Micros {
        self.last_t.replace(t).map_or(Micros(0), |last| t.since(last))
    }

    /// The scene of this sample; where it differs from the last one, the stages that start afresh do so.
    pub(super) fn enter_scene(&mut self, sample: &Sample, dt: Micros) {
        self.fusion.catch_up();
        self.contact.learn(sample.normal_force_n);
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
        if self.config.signal == Signal::Displacement && self.grip.is_some() && !decides {
            self.sink.close(sample, touching);
        }
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
            self.sink.settle();
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

    /// Follows the drift of the stylus and the error of the force sensor; `before` is the health at the sample before.
    #[inline]
    pub(super) fn watch_sensors(&mut self, sample: &Sample, before: SensorHealth) {
        self.health.watch_drift(sample, self.hand());
        self.compare_force(sample);
        if before != SensorHealth::Good && self.health.health() == SensorHealth::Good {
            // A sensor may come back with another zero, which is no slip.
            self.detector.prime();
        }
    }

    /// Compares the force sensor with the command while an object is held.
    #[inline]
    pub(super) fn compare_force(&mut self, sample: &Sample) {
        if let Some(grip) = self.grip.as_ref().filter(|_| self.decides && self.slip.is_none()) {
            self.grip_force.hold(sample.normal_force_n, grip.command_n());
        }
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
    pub(super) fn detect(&mut self, sample: &Sample) -> Option<(f32, SlipState)> {
        if !self.fusion.uses(Method::Stylus) {
            return None;
        }
        let learning = self.detector.is_learning();
        let trusted = self.health.feels();
        // The silence of a dead sensor is no noise floor.
        if self.decides || (learning && trusted) {
            let verdict = self.step_detector(sample);
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
            self.detector.step_ignored(sample.stylus, &motion_of(sample));
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
    pub(super) fn step_detector(&mut self, sample: &Sample) -> Option<(f32, SlipState)> {
        self.counters.bands += 1;
        self.detector.beside(sample);
        let verdict = self.detector.step(sample.stylus, &motion_of(sample));
        self.counters.gate += u64::from(self.detector.is_moving() || self.config.no_skip);
        verdict
    }

    /// What stylus, travel and pressure say together, where the scene needs it.
    #[inline]
    pub(super) fn fuse(
        &mut self,
        sample: &Sample,
        taxels: &[f32],
        stylus: Option<(f32, SlipState)>,
    ) -> Option<Detection> {
        if !(self.decides || self.config.no_skip) {
            return None;
        }
        self.counters.methods +=
            u64::from(sample.travel_m.is_some()) + u64::from(!taxels.is_empty());
        self.fusion.watch(sample, stylus, self.decides);
        if !taxels.is_empty() {
            // A controller knows when it closes, and what it does to the force in a slip is no reason to wait.
            let force_stands =
                self.grip.is_some() || self.standing.step(sample.t, sample.normal_force_n);
            self.fusion.watch_taxels(sample.t, taxels, force_stands, self.decides);
        }
        if !self.decides {
            return None;
        }
        // Before a slip the methods are asked when the stylus has news, or an array; the travel waits for them.
        let in_block = stylus.is_some() && self.detector.in_block();
        if !in_block || self.slip.is_some() || !taxels.is_empty() {
            self.detection = self.fusion.detect(stylus);
            self.grasp.step(sample.t, self.force_known(sample));
        }
        self.detection
    }

    // Always: a step is large, and made where the caller wants it (instructions on a Cortex-M4: idle 1950 -> 1570).
    #[inline(always)]
    pub(super) fn unchanged(&self, t: Micros, statistic: f32) -> Step {
        Step {
            t,
            scene: self.scene,
            statistic,
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
}

/// What a sample tells of the robot's motion.
#[inline]
fn motion_of(sample: &Sample) -> MotionInput {
    MotionInput {
        reference: sample.reference,
        commanded: sample.motion.is_some_and(|motion| motion != 0.0),
    }
}
