//! The data path on one page: `Sample -> health -> level (pads that sink) -> scene -> detect -> fuse -> event -> sensors judged -> observe
//! -> estimate -> need and load weighed -> control -> Step`. While nothing slips a guard does less (`rested` in `detect.rs`): it ends, with what
//! it has computed, at `detect` or behind `fuse`.
//!
//! [`Pipeline::handle`] costs a fixed time, allocates nothing, takes no lock, does not panic and reads no
//! clock; the same samples give the same steps everywhere.

mod build;
mod control;
mod detect;
mod slip;

use crate::{
    ClientCommand,
    config::PipelineConfig,
    course::{Course, TravelQuality, Turns},
    crosscheck::Whiteness,
    detector::{FloorHealth, SlipDetector},
    drift::Sink,
    esc::Esc,
    estimate::{Estimator, Features, ForceEstimate, FrictionMeter},
    freshness::Freshness,
    fusion::{Detection, Fusion},
    grip::{GripController, GripEvent, GripState, Trials},
    health::{HealthCheck, HealthCounters, Passed, SensorHealth},
    load::{CELLS, Load},
    need::Need,
    needed::NeededForce,
    observation::SlipObservation,
    pressure::Standing,
    sample::{Contact, Sample, Scene},
    units::{Micros, Newtons},
    velocity::{Velocity, VelocityMeter},
};
use detect::{Rest, Rested};
use slip::{Grasp, Slip};
use slip_msg::{EXTRAPOLATED, INFORMATIVE, PipelineState, Reading, SlipReport};

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
    freshness: Freshness,
    whiteness: Whiteness,
    turns: Turns,
    sink: Sink,
    need: Need,
    load: Load<CELLS>,
    travel_quality: TravelQuality,
    /// When the last slip ended.
    ended: Option<Micros>,
    estimator: Option<Estimator<W>>,
    grip: Option<GripController>,
    last_t: Option<Micros>,
    slip: Option<Slip>,
    /// What the methods detected when they were last asked.
    detection: Option<Detection>,
    scene: Scene,
    decides: bool,
    rest: Rest,
    gap: Micros,
    evidence_every: Micros,
    /// Since when nothing is touched, while a slip goes on.
    untouched: Option<Micros>,
    counters: StageCounters,
}

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// Takes one sample and gives what it led to. A sample that is not later than the one before is counted and changes nothing.
    #[inline]
    pub fn handle(&mut self, sample: &Sample) -> Step {
        self.handle_with(sample, &[])
    }

    /// [`Pipeline::handle`] for a gripper with a taxel array: `taxels` is the frame that came with the sample, empty where there is
    /// none. At most [`MAX_TAXELS`](crate::pressure::MAX_TAXELS) are looked at.
    #[inline]
    pub fn handle_with(&mut self, sample: &Sample, taxels: &[f32]) -> Step {
        self.counters.samples += 1;
        self.freshness.arrive(sample.arrival, sample.t);
        let before = self.health.health();
        self.health.set_slips(self.slip.is_some());
        let replaced;
        let sample = match self.health.passes(sample) {
            Passed::AsItIs => sample,
            Passed::As(sample) => {
                replaced = sample;
                &replaced
            }
            Passed::Not => {
                return match self.health.check(sample) {
                    Some(safe) => {
                        let levelled = self.sink.level(&safe);
                        self.stages(levelled.as_ref().unwrap_or(&safe), taxels, before, Rested::Not)
                    }
                    None => self.step_so_far(sample.t, 0.0),
                };
            }
        };
        let levelled = self.sink.level(sample);
        let sample = levelled.as_ref().unwrap_or(sample);
        // The guard: where nothing happens, few stages look at a sample.
        match self.rested(sample, taxels) {
            Rested::Quiet { statistic } => self.step_so_far(sample.t, statistic),
            rested => self.stages(sample, taxels, before, rested),
        }
    }

    /// Every stage after the sensor's health, which was `before`: `sample` is safe to compute with.
    #[inline]
    fn stages(
        &mut self,
        sample: &Sample,
        taxels: &[f32],
        before: SensorHealth,
        rested: Rested,
    ) -> Step {
        // Scene and detection, where the rest has not just ended with one.
        let (dt, stylus, detection) = match rested {
            Rested::Woken { dt, stylus, detection } => (dt, stylus, detection),
            Rested::Not | Rested::Quiet { .. } => {
                let dt = self.since_last(sample.t);
                self.enter_scene(sample, dt);
                self.watch_sensors(sample, before);
                let stylus = self.detect(sample);
                (dt, stylus, self.fuse(sample, taxels, stylus))
            }
        };
        let event = self.slip_event(sample, stylus, detection);
        let begins = event.as_ref().is_some_and(|slip| slip.first);

        let statistic = detection.map_or(0.0, |detection| detection.statistic);
        let slips = self.slip.is_some() || self.config.no_skip;
        // Evidence, while the object slips: force and travel only as far as they are believed.
        let believed = if slips { &self.judge_sensors(sample, dt, stylus, begins) } else { sample };
        // One step, made where the caller wants it: an event is large, and rare.
        let mut step = self.step_so_far(sample.t, statistic);
        if event.is_some() {
            step.event = event;
        }
        if slips {
            self.observe(believed);
            self.estimate(believed, &mut step);
            self.weigh_need(believed, begins);
            self.weigh_load(believed, sample.travel_m, begins);
        }
        (step.command, step.grip) = self.control(believed, dt, slips.then_some(&step));
        step.need = self.needed(step.command);
        self.rest = self.rest_after();
        step
    }

    /// Carries out what concerns the controller; `false` where the command is none of that or its force is no force.
    pub fn obey(&mut self, command: ClientCommand) -> bool {
        match command {
            ClientCommand::AtLeast(force_n) if force_n >= 0.0 => self.at_least(force_n),
            ClientCommand::Expect(force_n) if force_n >= 0.0 => self.expect(force_n),
            ClientCommand::Release => self.release(),
            ClientCommand::Grasp => self.close_again(),
            ClientCommand::AtLeast(_)
            | ClientCommand::Expect(_)
            | ClientCommand::Stop
            | ClientCommand::ClearFault(_) => return false,
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

/// Everything one sample led to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Device time of the sample.
    pub t: Micros,
    /// The scene the sample was handled in.
    pub scene: Scene,
    /// Evidence of a slip over the wanted interval: 1 and above is a slip. 0 where the bands were not needed.
    pub statistic: f32,
    /// A change in the slip state: what is known of it at once. Features, velocity and estimate come with the steps of the slip.
    pub event: Option<SlipReport>,
    /// Features of the slip, when there is new evidence.
    pub features: Option<Features>,
    /// Slip speed with its uncertainty, when there is new evidence.
    pub velocity: Option<Velocity>,
    /// The network's answer to these features.
    pub estimate: Option<ForceEstimate>,
    /// What the object in hand needs, and what the command allows, by the posterior of [`load`](crate::load), which commands nothing (the
    /// controller has its own, [`need`](crate::need)); `None` where nothing is known of it.
    pub need: Option<NeededForce>,
    /// The commanded force; `None` in a pipeline that only observes.
    pub command: Option<Newtons>,
    /// What the controller found out about the object in hand.
    pub grip: Option<GripEvent>,
    /// State of stylus, travel, pressure and reference; of all but the stylus while an object was last held.
    pub sensors: [SensorHealth; 4],
    /// State of the noise floor of the stylus.
    pub floor_health: FloorHealth,
}

impl Step {
    /// The state after this step with the last E_sc and the last estimate; what the daemon knows besides is added by it.
    #[must_use]
    pub fn state(
        &self,
        grip: Option<GripState>,
        esc: Option<Esc>,
        estimate: Option<ForceEstimate>,
    ) -> PipelineState {
        let note = |bit, applies| if applies { bit } else { 0 };
        #[expect(clippy::cast_possible_truncation, reason = "shown with seven digits")]
        let value = |esc: Esc| esc.value as f32;
        PipelineState {
            t: self.t,
            scene: self.scene,
            grip: grip.unwrap_or_default(),
            sensors: self.sensors,
            notes: note(INFORMATIVE, esc.is_some_and(|esc| esc.informative()))
                | note(EXTRAPOLATED, estimate.is_some_and(|estimate| estimate.extrapolated)),
            esc_flags: esc.map_or(0, |esc| esc.flags.bits()),
            esc_kind: esc.map_or(Reading::None, |esc| esc.reading),
            statistic: Some(self.statistic),
            command_n: self.command.map(|command| command.0),
            esc: esc.map(value),
            estimate_n: estimate.map(|estimate| estimate.force_n),
            need_low_n: self.need.map(|need| need.low_n),
            need_n: self.need.map(|need| need.median_n),
            need_high_n: self.need.map(|need| need.high_n),
            admissible_m_s2: self.need.map(|need| need.admissible_m_s2),
            ..PipelineState::UNKNOWN
        }
    }
}

/// How often each stage ran since the pipeline was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageCounters {
    /// Samples handled.
    pub samples: u64,
    /// Samples that went through the filter bank and the detector.
    pub bands: u64,
    /// Samples that also went through the bands of the motion reference and the gate.
    pub gate: u64,
    /// Travel readings and taxel frames that were looked at.
    pub methods: u64,
    /// Samples of slips, measured for speed, irregularities and E_sc.
    pub observation: u64,
    /// Answers asked of the network.
    pub inferences: u64,
    /// Answers the network could not give.
    pub refused_estimates: u64,
    /// Times a quieter second has lowered the noise floor.
    pub floor_lowered: u64,
}
