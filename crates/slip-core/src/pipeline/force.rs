//! What is known of the slip in, the commanded force out.

use super::{Pipeline, rest::Rest};
use crate::{
    course::Motion,
    estimate::{Estimator, ForceEstimate, G_M_S2, friction::FrictionMeter},
    event::{SlipEvent, Step},
    features::Features,
    grip::{Evidence, GripEvent, GripInput, Sliding, SlipNow},
    health::SensorHealth,
    methods::Method,
    need::{Alarm, Felt},
    sample::Sample,
    sample::Signal,
    turns::{Passing, Turns},
    units::{Micros, Newtons},
};

/// So early in a slip the stylus can still take over from the travel.
const CAUGHT_UP: Micros = Micros(50_000);

/// The power of a vibration is followed from this sample rate on (Hz).
const VIBRATION_HZ: f32 = 2000.0;

/// A mean over at most this long (s) says how an object slides now.
const LATELY_S: f32 = 0.01;

/// The slip as the controller sees it; the default where there is none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SlipNews {
    slip: SlipNow,
    moved_m: Option<f32>,
    evidence: Option<Evidence>,
    sliding: Option<Sliding>,
    motion: Option<Motion>,
    felt: Option<Felt>,
}

impl<W: AsRef<[f32]>> Pipeline<W> {
    /// The slip as of this sample.
    pub(super) fn slip_news(&self, sample: &Sample, step: &Step) -> SlipNews {
        if self.slip.is_none() {
            return SlipNews::default();
        }
        let motion = sample.travel_m.and_then(|_| self.course.motion(sample.t));
        let sigma_m = self.observation.travel_sigma_m();
        let slides = motion.is_some_and(|motion| motion.slides(sigma_m));
        let stands = self.observation.advancing() == Some(false) && !self.fusion.is_undecided();
        let goes_on = self.is_fresh(sample.t) && !stands;
        SlipNews {
            felt: self.felt(),
            motion,
            slip: if goes_on || slides { SlipNow::Evident } else { SlipNow::Fading },
            // Without estimates the controller must not wait for one.
            moved_m: self
                .observation
                .moved_m(sample)
                .filter(|_| self.estimator.as_ref().is_none_or(Estimator::is_trustworthy)),
            evidence: evidence_of(step),
            sliding: step.features.as_ref().and_then(sliding_of),
        }
    }

    /// Finds the needed force by the stylus alone, where that is the only sensor of the slip; else keeps what that takes, should the others fail.
    pub(super) fn weigh_need(&mut self, sample: &Sample, event: Option<SlipEvent>) {
        let begins = matches!(event, Some(SlipEvent::Slip { first: true, .. }));
        let force_n = sample.normal_force_n.unwrap_or(0.0);
        if begins {
            self.begin_need(sample, force_n);
        }
        let sound = self.health.feels() && !self.whiteness.is_noisy();
        let Some(slip) = self.slip.as_mut().filter(|slip| slip.feels) else { return };
        let measured = sample.travel_m.is_some();
        // What comes back in the middle of a slip has not been kept.
        slip.feels = sound && !(measured && slip.alone);
        slip.alone = !measured;
        if measured {
            self.need.keep(sample.stylus, force_n);
        } else {
            self.need.push(sample.stylus, force_n);
        }
    }

    fn begin_need(&mut self, sample: &Sample, force_n: f32) {
        let rate_hz = self.config.sample_rate.0;
        let band = self.config.detector.vibration;
        let share = 2.0 * (band.high_hz.min(0.4 * rate_hz) - band.low_hz) / rate_hz;
        let sigma = self.detector.noise_rms() / libm::sqrtf(share.max(1e-3));
        let feels = self.grip.is_some()
            && sigma.is_normal()
            && rate_hz >= self.least_rate_hz()
            && self.fusion.uses(Method::Stylus)
            && !self.detector.is_moving();
        if let Some(slip) = self.slip.as_mut().filter(|_| feels) {
            (slip.feels, slip.alone) = (true, sample.travel_m.is_none());
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

    /// The travel (m) to measure a slip with: as far as it is believed, and not where it is so coarse that the stylus alone knows better.
    pub(super) fn travel_of(&mut self, sample: &Sample, event: Option<SlipEvent>) -> Option<f32> {
        let travel_m = self.fusion.believed_travel(sample.travel_m)?;
        let Some(slip) = self.slip else { return Some(travel_m) };
        if matches!(event, Some(SlipEvent::Slip { first: true, .. })) {
            self.travel_quality.begin();
        }
        let step_m = self.fusion.travel_step_m();
        self.travel_quality.read(travel_m, self.observation.configured_sigma_m(), step_m);
        // Later in a slip the readings before are no longer kept.
        let feels = slip.feels && (slip.alone || sample.t.since(slip.since) < CAUGHT_UP);
        Some(travel_m).filter(|_| !(feels && self.travel_quality.is_coarse()))
    }

    fn felt(&self) -> Option<Felt> {
        let slip = self.slip.filter(|slip| slip.feels && slip.alone);
        slip.and_then(|_| self.need.felt())
    }

    /// Holds with at least `force_n` (N) from the next sample on; see [`GripController::at_least`](crate::grip::GripController::at_least).
    pub fn at_least(&mut self, force_n: f32) {
        self.rest = Rest::Awake;
        if let Some(grip) = &mut self.grip {
            grip.at_least(force_n);
        }
    }

    /// Lets go of the object, until [`Pipeline::close_again`].
    pub fn release(&mut self) {
        self.rest = Rest::Awake;
        if let Some(grip) = &mut self.grip {
            grip.release();
        }
    }

    /// Ends a release: the fingers close to the trial force.
    pub fn close_again(&mut self) {
        self.rest = Rest::Awake;
        if let Some(grip) = &mut self.grip {
            grip.close_again();
        }
    }

    /// Whether the slip goes on right now: by the stylus, the fastest, where it sees the slip; else by the others.
    pub(super) fn is_fresh(&self, t: Micros) -> bool {
        match self.slip {
            Some(slip) if !slip.felt => self.fusion.is_fresh(t),
            _ => self.detector.is_fresh(),
        }
    }

    /// Peaks and valleys that the stylus passes, where they are those of the surface: not the robot's motion, and not folded by a low rate.
    fn passing(&self) -> Option<Passing> {
        let counts =
            self.config.sample_rate.0 >= Turns::LEAST_RATE_HZ && !self.detector.is_moving();
        self.turns.passing().filter(|_| counts)
    }

    /// Compares the force sensor with the command while an object is held.
    #[inline]
    pub(super) fn compare_force(&mut self, sample: &Sample) {
        if let Some(grip) = self.grip.as_ref().filter(|_| self.decides && self.slip.is_none()) {
            self.grip_force.hold(sample.normal_force_n, grip.command_n());
        }
    }

    /// The force of a finger in a slip (N): measured, or where the sensor has failed by the command; `None` where nothing is commanded and
    /// nothing measured.
    pub(super) fn force_of(&mut self, sample: &Sample, dt: Micros) -> Option<f32> {
        let Some(grip) = self.grip.as_ref().filter(|_| self.slip.is_some()) else {
            return sample.normal_force_n;
        };
        #[expect(clippy::cast_possible_truncation, reason = "seconds between two samples")]
        let times = (dt.as_seconds() as f32, grip.lag_s());
        Some(self.grip_force.step(sample.normal_force_n, grip.command_n(), times))
    }

    /// The command after this sample; `None` in a pipeline that only observes.
    #[inline]
    pub(super) fn command(
        &mut self,
        sample: &Sample,
        dt: Micros,
        news: SlipNews,
    ) -> (Option<Newtons>, Option<GripEvent>) {
        let passing = self.passing();
        let Some(grip) = self.grip.as_mut() else { return (None, None) };
        let stylus = self.fusion.uses(Method::Stylus);
        if !(stylus && self.detector.is_learning()) {
            grip.grasp(sample.normal_force_n);
        }
        let travel = self.fusion.believed_travel(sample.travel_m);
        let felt = stylus && self.health.feels() && !self.whiteness.is_noisy();
        // Before an object is held the other sensors are not looked at.
        let healthy = felt || if self.decides { self.fusion.is_usable(sample.t) } else { !stylus };
        let loaded_n = if healthy { None } else { loaded_n(&mut self.friction, sample) };
        let complete = felt && self.health.health() == SensorHealth::Good;
        let impaired = stylus && !complete || !self.fusion.healthy();
        #[expect(clippy::cast_possible_truncation, reason = "the controller limits both")]
        let (dt_s, late_s) = (
            dt.as_seconds() as f32,
            sample.arrival.map_or(0.0, |arrival| arrival.age.as_seconds() as f32),
        );
        let command = grip.step(&GripInput {
            dt_s,
            slip: news.slip,
            moved_m: news.moved_m,
            evidence: news.evidence,
            sliding: news.sliding,
            motion: news.motion,
            felt: news.felt,
            passing,
            undecided: self.fusion.is_undecided(),
            alone_n: self.fusion.alone_n(),
            drifts: self.fusion.drifts(),
            travel_sigma_m: self.observation.travel_sigma_m(),
            rise_s: self.host_time.rise_s(sample.t, dt),
            stale: self.host_time.is_stale(),
            late_s,
            travel: travel.is_some(),
            applied_n: sample.normal_force_n,
            touching: self.contact.is_touching(),
            healthy,
            loaded_n,
            impaired,
        });
        (Some(Newtons(command)), grip.event())
    }
}

/// The force (N) that the load needs by the tangential force, where that is all there is.
fn loaded_n(friction: &mut FrictionMeter, sample: &Sample) -> Option<f32> {
    friction.watch(sample.normal_force_n?, sample.tangential_n?);
    friction.loaded_n()
}

/// What the step says of the force that is needed. An answer that nothing vouches for must not move the fingers.
fn evidence_of(step: &Step) -> Option<Evidence> {
    let estimate = step.estimate.filter(ForceEstimate::is_trusted)?;
    Some(Evidence { estimate_n: estimate.force_n, sigma_n: estimate.sigma_n })
}

/// How the object slides. A mean over more than some milliseconds says too little of now.
fn sliding_of(features: &Features) -> Option<Sliding> {
    (features.contact_time_s <= LATELY_S).then(|| Sliding {
        force_n: features.trial_force_n,
        acceleration_g: features.slip_acceleration_m_s2 / G_M_S2,
    })
}
