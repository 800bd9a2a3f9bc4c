//! Scene of a sample, and what stylus, travel and pressure detect; with the guard that lets a sample pass by where nothing happens.

use super::{Pipeline, Step};
use crate::{
    Signal,
    alarm::Method,
    course::Turns,
    detector::SlipState,
    drift::Hold,
    fusion::Detection,
    grip::{GripController, GripState},
    health::SensorHealth,
    needed::NeededForce,
    sample::{Sample, Scene},
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
        let force_n = match &mut self.grip {
            Some(grip) => grip.drive_mut().touch(sample.normal_force_n, touches, slides),
            None => sample.normal_force_n,
        };
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
            if let Some(grip) = &mut self.grip {
                grip.drive_mut().prime();
            }
            self.fusion.prime();
            self.load.take(self.grip.and_then(|grip| grip.known_n()));
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
        if let Some(grip) = self.grip.as_mut().filter(|_| self.decides && self.slip.is_none()) {
            let command_n = grip.command_n();
            grip.drive_mut().hold(sample.normal_force_n, command_n, self.config.sample_rate.0);
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
            self.detector.step_ignored(sample);
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
        let verdict = self.detector.step(sample);
        self.counters.gate += u64::from(self.detector.is_moving() || self.config.no_skip);
        verdict
    }

    /// What stylus, travel and pressure state together, where the scene needs it.
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
            let rests = self.decides && self.slip.is_none();
            self.fusion.watch_taxels(sample.t, taxels, force_stands, rests);
        }
        if !self.decides {
            return None;
        }
        // Before a slip the methods are asked when the stylus has something new, or an array; the travel waits for them.
        let in_block = stylus.is_some() && self.detector.in_block();
        if !in_block || self.slip.is_some() || !taxels.is_empty() {
            self.detection = self.fusion.detect(stylus);
            self.grasp.step(sample.t, self.force_known(sample));
        }
        self.detection
    }

    // Always: a step is large, and made where the caller wants it (instructions on a Cortex-M4: idle 1950 -> 1570).
    #[inline(always)]
    pub(super) fn step_so_far(&self, t: Micros, statistic: f32) -> Step {
        let command = self.grip.map(|grip| Newtons(grip.command_n()));
        Step {
            t,
            scene: self.scene,
            statistic,
            event: None,
            features: None,
            velocity: None,
            estimate: None,
            need: self.needed(command),
            command,
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

    /// What the object needs by its slips so far, with what the command allows.
    #[inline]
    pub(super) fn needed(&self, command: Option<Newtons>) -> Option<NeededForce> {
        let lost = self.grip.as_ref().is_some_and(|grip| grip.has_lost());
        self.load.needed(command?.0).filter(|_| !lost)
    }

    /// The health of the stylus, and where nothing is wrong with that, whether it has a part.
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

// Guard for samples at which nothing happens: few stages have to look at them.

/// What a sample like the last one needs.
///
/// While no object is touched, the floor is known and the command stands, all that a sample can do is to wake
/// the pipeline: sensor, time and contact are checked, and that is all. While an object is held quietly, only the methods that may notice a slip
/// look at it: scene and command stay. The answer is the same as that of all stages together (test
/// `skipping_never_changes_a_step` compares every step).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Rest {
    /// Every stage of its scene.
    #[default]
    Awake,
    /// The methods that may notice a slip: an object is held and nothing happens.
    Holding,
    /// No stage: nothing is touched.
    Idle,
}

/// What the guard found.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rested {
    /// Every stage has to look at the sample.
    Not,
    /// Nothing happens; the statistic of the methods.
    Quiet {
        /// Evidence of a slip over the wanted interval.
        statistic: f32,
    },
    /// The rest ends: the stages up to the detection have looked at the sample.
    Woken {
        /// Time since the sample before.
        dt: Micros,
        /// Statistic and state of the stylus, where it counts.
        stylus: Option<(f32, SlipState)>,
        /// What the methods detect together.
        detection: Option<Detection>,
    },
}

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// Whether the noise floor of the stylus is still being learned: until then it shows no slip.
    #[must_use]
    #[inline]
    pub fn is_learning(&self) -> bool {
        self.fusion.uses(Method::Stylus) && self.detector.is_learning()
    }

    /// What samples like the last one need.
    #[inline]
    pub(super) fn rest_after(&self) -> Rest {
        let stylus = self.fusion.uses(Method::Stylus);
        let doubted = self.whiteness.is_noisy()
            || self.grip.as_ref().is_some_and(|grip| grip.drive().is_numb());
        let learning = self.contact.is_learning() || self.is_learning();
        let steady = !self.config.no_skip
            && self.slip.is_none()
            && self.health.health() == SensorHealth::Good
            && !doubted
            && !learning
            && self.grip.as_ref().is_none_or(GripController::is_steady);
        match self.scene {
            Scene::Idle if steady => Rest::Idle,
            // Fingers that let go, or closed on nothing.
            Scene::Moving if steady && !self.decides => Rest::Idle,
            Scene::Holding if steady && stylus && !self.detector.is_moving() => Rest::Holding,
            _ => Rest::Awake,
        }
    }

    /// The guard: what the few stages find that have to look at this `sample`, which the health check found plain.
    #[inline]
    pub(super) fn rested(&mut self, sample: &Sample, taxels: &[f32]) -> Rested {
        match self.rest_of(sample) {
            Rest::Idle => {
                self.last_t = Some(sample.t);
                Rested::Quiet { statistic: 0.0 }
            }
            Rest::Holding if taxels.is_empty() => self.hold(sample),
            Rest::Holding | Rest::Awake => Rested::Not,
        }
    }

    /// What this sample needs: [`Rest::Awake`] where it may end the rest.
    #[inline]
    fn rest_of(&self, sample: &Sample) -> Rest {
        let held = self.rest == Rest::Holding;
        let soon = self.last_t.is_some_and(|last| sample.t.since(last) <= self.gap);
        let measured = sample.travel_m.is_some();
        let updates = self.grip.as_ref().is_some_and(|grip| grip.follows_travel(measured));
        if soon && !updates && self.contact.would_touch(sample.normal_force_n) == held {
            self.rest
        } else {
            Rest::Awake
        }
    }

    /// A sample without taxels at which the object is still held.
    #[inline]
    fn hold(&mut self, sample: &Sample) -> Rested {
        let dt = self.since_last(sample.t);
        self.health.watch_drift(sample, Hold::Still);
        self.compare_force(sample);
        if self.health.health() != SensorHealth::Good {
            let stylus = self.detect(sample);
            return Rested::Woken { dt, stylus, detection: self.fuse(sample, &[], stylus) };
        }
        let stylus = self.step_detector(sample);
        if self.detector.is_moving() {
            self.rest = Rest::Awake;
        }
        if !(stylus.is_some() && self.detector.in_block()) {
            return self.ask(sample, dt, stylus);
        }
        if let Some(travel_m) = sample.travel_m {
            self.counters.methods += 1;
            self.fusion.put_by(sample.t, travel_m);
        }
        Rested::Quiet { statistic: self.detection.map_or(0.0, |detection| detection.statistic) }
    }

    /// The same where the stylus has a new block.
    #[inline(never)]
    fn ask(&mut self, sample: &Sample, dt: Micros, stylus: Option<(f32, SlipState)>) -> Rested {
        let detection = self.fuse(sample, &[], stylus);
        if detection.is_some_and(|detection| detection.state != SlipState::Quiet) {
            return Rested::Woken { dt, stylus, detection };
        }
        Rested::Quiet { statistic: detection.map_or(0.0, |detection| detection.statistic) }
    }
}
