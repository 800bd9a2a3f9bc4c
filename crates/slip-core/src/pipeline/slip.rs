//! What the methods detect in; the slip, its causes, and what is measured of it, out.

use super::{Pipeline, Step};
use crate::{
    Phase, Signal, SlipReport,
    alarm::{Cause, Causes, Method, confidence},
    detector::SlipState,
    drive::Drive,
    fusion::Detection,
    grip::GripController,
    load::{Alarm, Reading},
    pressure::Standing,
    sample::{Sample, Scene},
    units::Micros,
    velocity::{Measured, Velocity},
};

/// A slip without touch ends after this long.
const LET_GO: Micros = Micros(30_000);
/// Below this sample rate (Hz) a stylus does not resolve a fast surface.
pub(super) const LEAST_RATE_HZ: f32 = 6000.0;
/// The power of a vibration is followed from this sample rate on (Hz).
const VIBRATION_HZ: f32 = 2000.0;

/// The slip that goes on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slip {
    pub(super) since: Micros,
    pub(super) gross: bool,
    /// Whether the stylus sees it now.
    pub(super) felt: bool,
    pub(super) next_evidence: Micros,
    /// The interval it is certified with (s).
    pub(super) certified_s: Option<f32>,
    /// What was known of the grip when it was noticed.
    pub(super) grip_causes: Causes,
}

/// What is remembered of the grip.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Grasp {
    force: Standing,
    stands: bool,
    since: Micros,
}

impl Grasp {
    /// An object is held from `t` on.
    pub(super) fn begin(&mut self, t: Micros) {
        *self = Self { since: t, ..Self::default() };
    }

    /// Takes the measured, or commanded, grip force (N).
    #[inline]
    pub(super) fn step(&mut self, t: Micros, force_n: Option<f32>) {
        self.stands = self.force.step(t, force_n);
    }
}

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// The change in the slip state at this sample.
    #[inline]
    pub(super) fn slip_event(
        &mut self,
        sample: &Sample,
        stylus: Option<(f32, SlipState)>,
        detection: Option<Detection>,
    ) -> Option<SlipReport> {
        let received = stylus;
        let certified_s = received.and_then(|_| self.detector.certified_s());
        let state = detection.map_or(SlipState::Quiet, |detection| detection.state);
        let method = detection.map_or(Method::Stylus, |detection| detection.method);
        if self.has_let_go(sample.t) {
            return self.end_slip(sample.t);
        }
        let phase = |gross| if gross { Phase::Gross } else { Phase::Incipient };
        let (phase, first, certified_s) = match (&mut self.slip, state) {
            (None, SlipState::Incipient | SlipState::Gross) => {
                let gross = state == SlipState::Gross;
                self.begin_slip(sample, gross, certified_s);
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
        let causes = self.causes(sample, detection, first, certified_s.is_some());
        let statistic = detection.map_or(0.0, |detection| detection.statistic);
        Some(SlipReport {
            t: sample.t,
            phase,
            method,
            statistic: Some(statistic),
            confidence: Some(confidence(statistic)),
            certified_s,
            ruled_out: causes.ruled_out.bits(),
            possible: causes.possible.bits(),
            first,
            ..SlipReport::UNKNOWN
        })
    }

    /// A slip has been noticed.
    fn begin_slip(&mut self, sample: &Sample, gross: bool, certified_s: Option<f32>) {
        let heights = self.config.signal == Signal::Displacement;
        self.observation.begin(heights.then(|| self.detector.noise_rms()));
        self.whiteness.begin();
        self.velocity.begin();
        self.friction.begin();
        let line_s = self.freshness.late_s();
        let modelled_n = self.grip.as_mut().map_or(0.0, |grip| {
            let command_n = grip.command_n();
            grip.drive_mut().begin(command_n, sample.normal_force_n, line_s);
            grip.drive().modelled_as_read_n()
        });
        self.sink.begin(
            sample.normal_force_n,
            modelled_n,
            self.detector.noise_rms(),
            1.0 / self.config.sample_rate.0,
        );
        self.slip = Some(Slip {
            since: sample.t,
            gross,
            felt: false,
            next_evidence: sample.t.plus(self.evidence_every),
            certified_s,
            grip_causes: Causes::default(),
        });
    }

    /// Whether nothing has been touched for [`LET_GO`] while a slip goes on: the object is gone, whatever the sensors still show.
    #[inline]
    fn has_let_go(&self, t: Micros) -> bool {
        self.untouched.is_some_and(|since| t.since(since) >= LET_GO)
    }

    #[cold]
    fn end_slip(&mut self, t: Micros) -> Option<SlipReport> {
        let slip = self.slip.take()?;
        self.ended = Some(t);
        self.load.end();
        self.fusion.trust_travel(self.load.trusts_travel());
        self.fusion.slip_ended();
        self.sink.end();
        self.untouched = None;
        let duration_s = Some(t.since(slip.since).as_seconds());
        Some(SlipReport { t, duration_s, certified_s: slip.certified_s, ..SlipReport::UNKNOWN })
    }

    /// The measured grip force (N), or the commanded one.
    #[inline]
    pub(super) fn force_known(&self, sample: &Sample) -> Option<f32> {
        sample.normal_force_n.or_else(|| self.grip.map(|grip| grip.command_n()))
    }

    /// What is known of the causes of an alarm at this sample; of the grip only what was known when the slip was `first` noticed.
    #[cold]
    pub(super) fn causes(
        &mut self,
        sample: &Sample,
        detection: Option<Detection>,
        first: bool,
        certified: bool,
    ) -> Causes {
        let grip = match &mut self.slip {
            Some(slip) if !first => slip.grip_causes,
            slip => {
                let measured = sample.normal_force_n.is_some() || self.grip.is_some();
                let held = sample.t.since(self.grasp.since) >= Standing::WAIT;
                let causes = Causes::default()
                    .with(Cause::GripChange, measured.then_some(self.grasp.stands))
                    .with(Cause::Closing, measured.then_some(held));
                if let Some(slip) = slip {
                    slip.grip_causes = causes;
                }
                causes
            }
        };
        let feels = detection.is_some_and(|detection| detection.method == Method::Stylus);
        self.detector.add_causes(grip, feels, certified, sample.motion.is_some())
    }

    /// The sample of a slip with its force and its travel as far as they are believed.
    pub(super) fn believe(
        &mut self,
        sample: &Sample,
        dt: Micros,
        stylus: Option<(f32, SlipState)>,
    ) -> Sample {
        if let Some(slip) = &mut self.slip {
            slip.felt = stylus.is_some_and(|(_, state)| state != SlipState::Quiet);
        }
        #[expect(clippy::cast_possible_truncation, reason = "a step of time")]
        let dt_s = dt.as_seconds() as f32;
        let mut sample = *sample;
        sample.normal_force_n = self.force_of(&sample, dt_s);
        if let (Some(_), Some(force_n), Some(grip)) = (self.slip, sample.normal_force_n, &self.grip)
        {
            let drive = grip.drive();
            self.sink.follow(drive.as_read(force_n), drive.modelled_as_read_n(), dt_s);
        }
        sample.travel_m = self.fusion.believed_travel(sample.travel_m);
        sample
    }

    /// The force of a finger in a slip (N): measured, or where the sensor has failed by the command; `None` where nothing is commanded and
    /// nothing measured.
    fn force_of(&mut self, sample: &Sample, dt_s: f32) -> Option<f32> {
        let Some(grip) = self.grip.as_mut().filter(|_| self.slip.is_some()) else {
            return sample.normal_force_n;
        };
        let speeds_up = self.load.forecast().speeds_up();
        let drive = grip.drive_mut();
        Some(drive.measure(sample.normal_force_n, dt_s, self.freshness.late_s(), speeds_up))
    }

    /// Whether the slip goes on right now: by the stylus, the fastest, where it sees the slip; else by the others.
    pub(super) fn is_fresh(&self, t: Micros) -> bool {
        match self.slip {
            Some(slip) if !slip.felt => self.fusion.is_fresh(t),
            _ => self.detector.is_fresh(),
        }
    }

    /// Follows a slip: speed, irregularities and E_sc.
    pub(super) fn observe(&mut self, sample: &Sample) {
        self.counters.observation += 1;
        self.velocity.push(sample);
        if let (Some(normal_n), Some(tangential_n)) = (sample.normal_force_n, sample.tangential_n) {
            self.friction.push(normal_n, tangential_n, self.is_fresh(sample.t));
        }
        match self.speed_of_two_styli(sample) {
            Some(Velocity { speed_m_s, sigma_m_s, .. }) => {
                self.observation.trust_speed(Some(sigma_m_s));
                self.observation.push(&Sample { velocity_m_s: Some(speed_m_s), ..*sample });
            }
            None => {
                let direct = sample.velocity_m_s.map(|_| self.config.velocity.direct_sigma_m_s);
                let configured = self.config.observation.speed.fixed_m_s.is_some();
                self.observation.trust_speed(direct.filter(|_| !configured));
                self.observation.push(sample);
            }
        }
    }

    /// Features and the network's answer, once a millisecond of a slip.
    pub(super) fn estimate(&mut self, sample: &Sample, step: &mut Step) {
        let Some(slip) = &mut self.slip else { return };
        if sample.t < slip.next_evidence {
            return;
        }
        slip.next_evidence = sample.t.plus(self.evidence_every);
        let since = sample.t.since(slip.since);
        step.velocity = self.velocity.velocity(self.measured(sample), since);
        step.features = self.observation.features();
        if let (Some(features), Some(estimator)) = (&step.features, &self.estimator) {
            self.counters.inferences += 1;
            let answer = estimator.estimate(features);
            self.counters.refused_estimates += u64::from(answer.is_err());
            step.estimate = answer.ok();
        }
        // Where the network has nothing to go by.
        if !step.estimate.is_some_and(|estimate| estimate.is_trusted()) {
            step.estimate = self.friction.estimate().or(step.estimate);
        }
    }

    /// The speed of the two styli, where no other sensor shows it.
    #[inline]
    fn speed_of_two_styli(&self, sample: &Sample) -> Option<Velocity> {
        if sample.travel_m.is_some() || sample.velocity_m_s.is_some() {
            return None;
        }
        sample.second_stylus?;
        self.velocity.two_styli()
    }

    fn measured(&self, sample: &Sample) -> Measured {
        let travel = self.observation.travel_speed();
        Measured {
            fixed_m_s: self.config.observation.speed.fixed_m_s,
            direct_m_s: sample.velocity_m_s,
            travel: travel.map(|(speed, window)| (speed, window, self.config.travel.resolution_m)),
        }
    }

    /// What the sample shows of the needed force; `travel_m` is the travel whether it is believed or not.
    pub(super) fn weigh(&mut self, sample: &Sample, travel_m: Option<f32>, begins: bool) {
        if self.grip.is_none() {
            return;
        }
        if begins {
            self.begin_load(sample);
        }
        if self.slip.is_none() {
            return;
        }
        let sound = self.health.feels() && !self.whiteness.is_noisy();
        let late_s = self.freshness.late_s();
        let drive = self.grip.as_ref().map(GripController::drive);
        self.load.push(&Reading {
            stylus: Some(sample.stylus).filter(|_| sound),
            travel_m: self.fusion.travel_m(travel_m),
            force_n: sample.normal_force_n.unwrap_or(0.0),
            sinks_per_n: self.sink.per_n().abs(),
            dead_s: drive.map_or(0.0, |drive| drive.line_dead_s(late_s)),
            lag_s: drive.map_or(0.0, Drive::drive_lag_s),
            on_way_n: drive.map_or(0.0, Drive::on_way_n),
            evident: self.is_fresh(sample.t),
        });
    }

    /// A slip was noticed at this sample.
    fn begin_load(&mut self, sample: &Sample) {
        let rate_hz = self.config.sample_rate.0;
        let band = self.config.detector.vibration;
        let share = 2.0 * (band.high_hz.min(0.4 * rate_hz) - band.low_hz) / rate_hz;
        let sigma = self.detector.noise_rms() / libm::sqrtf(share.max(1e-3));
        let feels = sigma.is_normal()
            && rate_hz >= self.least_rate_hz()
            && self.fusion.uses(Method::Stylus)
            && self.health.feels()
            && !self.whiteness.is_noisy()
            && !self.detector.is_moving();
        let rested_s = self.ended.map_or(f64::INFINITY, |t| sample.t.since(t).as_seconds());
        let travel = self.fusion.travel_sensor(sample.t);
        let by_stylus = self.detection.is_some_and(|now| now.method == Method::Stylus);
        let held_s = sample.t.since(self.grasp.since).as_seconds();
        #[expect(clippy::cast_possible_truncation, reason = "times of one grasp")]
        let (rested_s, held_s) = (rested_s as f32, held_s as f32);
        self.load.begin(&Alarm {
            signal: self.config.signal,
            sigma: feels.then_some(sigma),
            dt_s: 1.0 / rate_hz,
            force_n: sample.normal_force_n.unwrap_or(0.0),
            most_n: self.grip.map_or(0.0, |grip| grip.ceiling_n()),
            travel: travel.map(|(sensor, _)| sensor),
            moved_m: travel.map_or(0.0, |(_, moved_m)| moved_m),
            by_stylus,
            searched: self.grip.is_some_and(|grip| grip.is_searching()),
            held_s,
            rested_s,
        });
    }

    /// Sample rate (Hz) from which on the signal shows the course of a slip.
    fn least_rate_hz(&self) -> f32 {
        match self.config.signal {
            Signal::Displacement => LEAST_RATE_HZ,
            Signal::Vibration => VIBRATION_HZ,
        }
    }
}
