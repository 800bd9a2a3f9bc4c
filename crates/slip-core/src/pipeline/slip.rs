//! The slip, its causes, and what is measured of it, from what the methods detect.

use super::{Pipeline, Step};
use crate::{
    Phase, Signal, SlipReport,
    alarm::{Cause, Causes, Method, confidence},
    course::Turns,
    crosscheck::Seen,
    detector::SlipState,
    fusion::Detection,
    load,
    need::Alarm,
    pressure::Standing,
    sample::{Sample, Scene},
    units::Micros,
    velocity::{Measured, Velocity},
};

/// A slip without touch ends after this long.
const LET_GO: Micros = Micros(30_000);
/// So early in a slip the stylus can still take over from the travel.
const CAUGHT_UP: Micros = Micros(50_000);
/// The power of a vibration is followed from this sample rate on (Hz).
const VIBRATION_HZ: f32 = 2000.0;

/// The slip that goes on.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "what is seen, each by itself")]
pub(super) struct Slip {
    pub(super) since: Micros,
    pub(super) gross: bool,
    /// Whether the stylus sees it now.
    pub(super) felt: bool,
    /// Whether the stylus can show the needed force, whether it is the only sensor that does, and whether it has been in this slip.
    pub(super) feels: bool,
    pub(super) alone: bool,
    followed: bool,
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
        let received = stylus.filter(|_| !self.fusion.doubts_stylus());
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
        self.course.reset();
        self.fusion.slip_began();
        self.whiteness.begin();
        self.turns = Turns::default();
        self.velocity.begin();
        self.friction.begin();
        let line_s = self.freshness.line_late_s();
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
            feels: false,
            alone: false,
            followed: false,
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

    /// The sample of a slip with its force and its travel as far as they are believed; stylus and travel are compared.
    pub(super) fn judge_sensors(
        &mut self,
        sample: &Sample,
        dt: Micros,
        stylus: Option<(f32, SlipState)>,
        begins: bool,
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
        if self.slip.is_some() {
            let noise = self.detector.noise_rms();
            self.turns.step(sample.stylus, noise, dt_s);
            self.fusion.compare(Seen {
                t: sample.t,
                dt_s: dt_s.min(0.01),
                travel_m: sample.travel_m,
                sigma_m: self.observation.travel_sigma_m(),
                leaps: 0,
                // Behind the motion gate a stylus may be silent in a slip: nothing is weighed against the force then.
                force_n: sample.normal_force_n.filter(|_| !self.detector.is_moving()),
                stylus: stylus.map(|_| self.detector.loudness()),
                reading: self.sink.raw(),
                noise,
                holds_alone: self.holds_alone(sample.t),
            });
        }
        sample.travel_m = self.travel_of(&sample, begins);
        sample
    }

    /// Whether the stylus alone can give the force from here on: nothing of the slip has been lost, and what it feels is the surface.
    fn holds_alone(&self, t: Micros) -> bool {
        let kept = |slip: Slip| slip.feels && (slip.followed || t.since(slip.since) < CAUGHT_UP);
        let surface = self.whiteness.is_known() && !self.whiteness.is_noisy();
        self.slip.is_some_and(kept) && surface && !self.detector.is_moving()
    }

    /// The force of a finger in a slip (N): measured, or where the sensor has failed by the command; `None` where nothing is commanded and
    /// nothing measured.
    fn force_of(&mut self, sample: &Sample, dt_s: f32) -> Option<f32> {
        let Some(grip) = self.grip.as_mut().filter(|_| self.slip.is_some()) else {
            return sample.normal_force_n;
        };
        let motion = self.course.motion(sample.t);
        let speeds_up = motion.and_then(|motion| motion.acceleration_m_s2).is_some_and(|a| a > 0.0);
        let drive = grip.drive_mut();
        Some(drive.measure(sample.normal_force_n, dt_s, self.freshness.line_late_s(), speeds_up))
    }

    /// The travel (m) to measure a slip with: as far as it is believed, and not where it is so coarse that the stylus alone knows better.
    pub(super) fn travel_of(&mut self, sample: &Sample, begins: bool) -> Option<f32> {
        let travel_m = self.fusion.believed_travel(sample.travel_m)?;
        let Some(slip) = self.slip else { return Some(travel_m) };
        if begins {
            self.travel_quality.begin();
        }
        let step_m = self.fusion.travel_step_m();
        let (rest_m, read) = self.fusion.travel_noise();
        let least_m = self.observation.configured_sigma_m().max(rest_m);
        self.travel_quality.read(travel_m, least_m, step_m, read);
        // Later in a slip the readings before are no longer kept.
        let feels = slip.feels && (slip.alone || sample.t.since(slip.since) < CAUGHT_UP);
        Some(travel_m).filter(|_| !(feels && self.travel_quality.is_coarse()))
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
        if let Some(travel_m) = sample.travel_m {
            self.course.push(sample.t, travel_m);
        }
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

    /// Finds the needed force by the stylus alone, where that is the only sensor of the slip; else keeps what that takes,
    /// should the others fail.
    pub(super) fn weigh_need(&mut self, sample: &Sample, begins: bool) {
        let force_n = sample.normal_force_n.unwrap_or(0.0);
        if begins {
            self.begin_need(sample, force_n);
        }
        let sound = self.health.feels() && !self.whiteness.is_noisy();
        let Some(slip) = self.slip.as_mut().filter(|slip| slip.feels) else { return };
        (slip.feels, slip.alone) = (sound, sample.travel_m.is_none());
        // Once begun it goes on: a travel that comes back in the middle of a slip may go again.
        slip.followed |= slip.alone;
        if !slip.followed {
            self.need.keep(sample.stylus, force_n);
        } else {
            self.need.push(sample.stylus, force_n);
        }
    }

    /// What the sample shows of the load, beside the controller: reported, and commands nothing. `travel_m` is the travel whether it is believed or not.
    pub(super) fn weigh_load(&mut self, sample: &Sample, travel_m: Option<f32>, begins: bool) {
        let Some(grip) = self.grip else { return };
        let force_n = sample.normal_force_n.unwrap_or(grip.command_n());
        if begins {
            let rested_s = self.ended.map_or(f64::INFINITY, |t| sample.t.since(t).as_seconds());
            let held_s = sample.t.since(self.grasp.since).as_seconds();
            let travel = self.fusion.travel_sensor(sample.t);
            let feels = self.slip.is_some_and(|slip| slip.feels);
            #[expect(clippy::cast_possible_truncation, reason = "times of one grasp")]
            let (held_s, rested_s) = (held_s as f32, rested_s as f32);
            self.load.begin(&load::Alarm {
                signal: self.config.signal,
                sigma: feels.then(|| self.stylus_sigma()),
                dt_s: 1.0 / self.config.sample_rate.0,
                force_n,
                most_n: grip.ceiling_n(),
                travel: travel.map(|(sensor, _)| sensor),
                moved_m: travel.map_or(0.0, |(_, moved_m)| moved_m),
                by_stylus: self.detection.is_some_and(|now| now.method == Method::Stylus),
                searched: grip.is_searching(),
                held_s,
                rested_s,
            });
        }
        if self.slip.is_none() {
            return;
        }
        let sound = self.health.feels() && !self.whiteness.is_noisy();
        self.load.push(&load::Reading {
            stylus: Some(sample.stylus).filter(|_| sound),
            travel_m: self.fusion.travel_m(travel_m),
            force_n,
            sinks_per_n: self.sink.per_n().abs(),
            dead_s: grip.drive().dead_s(),
            evident: self.is_fresh(sample.t),
        });
    }

    /// White noise of the readings of the stylus (rms, their unit).
    fn stylus_sigma(&self) -> f32 {
        let rate_hz = self.config.sample_rate.0;
        let band = self.config.detector.vibration;
        let share = 2.0 * (band.high_hz.min(0.4 * rate_hz) - band.low_hz) / rate_hz;
        self.detector.noise_rms() / libm::sqrtf(share.max(1e-3))
    }

    fn begin_need(&mut self, sample: &Sample, force_n: f32) {
        let rate_hz = self.config.sample_rate.0;
        let sigma = self.stylus_sigma();
        let feels = self.grip.is_some()
            && sigma.is_normal()
            && rate_hz >= self.least_rate_hz()
            && self.fusion.uses(Method::Stylus)
            && !self.detector.is_moving();
        if let Some(slip) = self.slip.as_mut().filter(|_| feels) {
            (slip.feels, slip.alone, slip.followed) = (true, sample.travel_m.is_none(), false);
            let rested_s = self.ended.map_or(f64::INFINITY, |t| sample.t.since(t).as_seconds());
            #[expect(clippy::cast_possible_truncation, reason = "a time between two slips")]
            let rested_s = rested_s as f32;
            let signal = self.config.signal;
            self.need.begin(&Alarm { signal, sigma, force_n, dt_s: 1.0 / rate_hz, rested_s });
        }
    }

    /// Sample rate (Hz) from which on the signal alone gives the needed force.
    fn least_rate_hz(&self) -> f32 {
        match self.config.signal {
            Signal::Displacement => Turns::LEAST_RATE_HZ,
            Signal::Vibration => VIBRATION_HZ,
        }
    }
}
