//! Selection of slips whose force is known from both sides, from samples with what the pipeline made of them.

use slip_core::{
    Phase, Sample, SlipReport, Step,
    estimate::Features,
    grip::GripEvent,
    health::SensorHealth,
    units::{Micros, Newtons},
};

/// Forces are averaged over this time (s).
const SMOOTH_S: f32 = 0.005;
/// A force that was not reported anew for this long (s) is not known any more.
const STALE_S: f64 = 0.04;
/// Features of one slip that are kept; a slip that goes on for longer shows nothing new.
const MOST_FEATURES: usize = 4096;
/// With less than this share of the force at which it slipped, nothing is held any more.
const OPEN: f32 = 0.5;
/// It must stay at this much more than it slipped at, or nothing is known to have helped.
const LEAST_GAIN: f32 = 1.02;

/// A slip, and the forces at which it began and at which it was over.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredSlip {
    /// When it was noticed, on the clock of the device.
    pub t: Micros,
    /// What it looked like at one moment.
    pub features: Features,
    /// Force of one finger at which it began (N): too little.
    pub slipped_n: f32,
    /// Force at which the object then stayed (N): enough.
    pub stayed_n: f32,
}

slip_core::named! {
    /// What became of a slip.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Fate {
        fn name: "Its name in summaries.";
        fn text: "What it reports of slips, for people.";
    }
    Kept: "Both forces are known.", "kept", "kept";
    NoForce: "Neither a sensor nor a command reports the force.", "no_force", "without a force that is known";
    NoFeatures: "It was over before anything of it was measured.", "no_features", "over before anything was measured";
    Again: "It slipped again before it had stayed for long enough.", "again", "slipped again too soon";
    Unfinished:
        "The recording, the pipeline or the grip ended before that, the object was lost, or a sensor failed.",
        "unfinished", "not watched to their end";
    NoGain:
        "It stayed at no more force than that at which it slipped: a false alarm, or something that hit it.",
        "no_gain", "over without more force (false alarms, or hit)";
    Wide: "The forces are too far apart to show where between them the truth is.", "wide", "with forces too far apart";
    Incomplete: "A feature that was asked for is missing.", "incomplete", "without a required feature";
}

/// Which slips are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WatchConfig {
    /// How long an object must stay (s).
    pub stay_s: f32,
    /// Largest ratio of the two forces.
    pub widest: f32,
}

impl Default for WatchConfig {
    /// 1 s, and 2.
    fn default() -> Self {
        Self { stay_s: 1.0, widest: 2.0 }
    }
}

/// A slip that goes on.
#[derive(Clone, Debug)]
struct Sliding {
    t: Micros,
    slipped_n: Option<f32>,
    features: Vec<Features>,
}

#[derive(Clone, Debug, Default)]
enum State {
    #[default]
    Quiet,
    Sliding(Sliding),
    /// It is over since then; the least force since half of the time has gone by.
    Staying(Sliding, Micros, Option<f32>),
}

/// One pipeline, watched from its beginning to its end.
#[derive(Clone, Debug)]
pub struct SlipWatch {
    config: WatchConfig,
    state: State,
    force_n: Option<f32>,
    last: Option<Micros>,
    /// When the force was reported last.
    reported: Option<Micros>,
}

impl SlipWatch {
    /// A watch over a pipeline that begins.
    #[must_use]
    pub const fn new(config: WatchConfig) -> Self {
        Self { config, state: State::Quiet, force_n: None, last: None, reported: None }
    }

    /// Takes a sample with what it led to, and reports each slip as soon as it is known what became of it.
    pub fn take(
        &mut self,
        sample: &Sample,
        step: &Step,
        report: &mut dyn FnMut(Result<MeasuredSlip, Fate>),
    ) {
        self.smooth(sample, step.command);
        let touches = !matches!(step.grip, Some(GripEvent::Lost | GripEvent::Regrasped));
        if !touches || step.sensors[0] != SensorHealth::Good || self.is_open() {
            self.finish(report);
            return;
        }
        match step.event {
            Some(SlipReport { first: true, .. }) => {
                match core::mem::take(&mut self.state) {
                    State::Quiet => {}
                    State::Sliding(_) => report(Err(Fate::Unfinished)),
                    State::Staying(..) => report(Err(Fate::Again)),
                }
                let features = Vec::new();
                self.state =
                    State::Sliding(Sliding { t: step.t, slipped_n: self.force_n, features });
            }
            Some(SlipReport { phase: Phase::Ended, .. }) => {
                if let State::Sliding(slip) = core::mem::take(&mut self.state) {
                    self.state = State::Staying(slip, step.t, None);
                }
            }
            _ => {}
        }
        self.follow(step, report);
    }

    /// The pipeline ends.
    pub fn finish(&mut self, report: &mut dyn FnMut(Result<MeasuredSlip, Fate>)) {
        if !matches!(core::mem::take(&mut self.state), State::Quiet) {
            report(Err(Fate::Unfinished));
        }
    }

    /// The force of one finger: as measured, else as commanded.
    fn smooth(&mut self, sample: &Sample, command: Option<Newtons>) {
        let measured = sample.normal_force_n.filter(|force| force.is_finite());
        let now_n = measured.or(command.map(|force| force.0));
        #[expect(clippy::cast_possible_truncation, reason = "a step in time")]
        let dt_s = self.last.map_or(0.0, |last| sample.t.since(last).as_seconds() as f32);
        self.last = Some(sample.t);
        self.reported = now_n.map(|_| sample.t).or(self.reported);
        if self.reported.is_none_or(|reported| sample.t.since(reported).as_seconds() > STALE_S) {
            self.force_n = None;
            return;
        }
        let share = (dt_s / SMOOTH_S).clamp(0.0, 1.0);
        self.force_n = match (self.force_n, now_n) {
            (Some(before_n), Some(now_n)) => Some(before_n + share * (now_n - before_n)),
            (before_n, now_n) => now_n.or(before_n),
        };
    }

    /// Whether the fingers have let go of what slipped.
    fn is_open(&self) -> bool {
        let slipped_n = match &self.state {
            State::Quiet => None,
            State::Sliding(slip) | State::Staying(slip, ..) => slip.slipped_n,
        };
        self.force_n.zip(slipped_n).is_some_and(|(now_n, slipped_n)| now_n < OPEN * slipped_n)
    }

    fn follow(&mut self, step: &Step, report: &mut dyn FnMut(Result<MeasuredSlip, Fate>)) {
        match &mut self.state {
            State::Quiet => {}
            State::Sliding(slip) => {
                if slip.features.len() < MOST_FEATURES {
                    slip.features.extend(step.features);
                }
            }
            State::Staying(slip, since, least_n) => {
                #[expect(clippy::cast_possible_truncation, reason = "seconds for a comparison")]
                let stayed_s = step.t.since(*since).as_seconds() as f32;
                if 2.0 * stayed_s >= self.config.stay_s {
                    *least_n = least_n.map_or(self.force_n, |least_n| {
                        self.force_n.map(|now_n| now_n.min(least_n))
                    });
                }
                if stayed_s >= self.config.stay_s {
                    report(judge(slip, *least_n, self.config.widest));
                    self.state = State::Quiet;
                }
            }
        }
    }
}

fn judge(slip: &Sliding, stayed_n: Option<f32>, widest: f32) -> Result<MeasuredSlip, Fate> {
    let known = slip.slipped_n.zip(stayed_n).filter(|(slipped_n, _)| *slipped_n > 0.0);
    let (slipped_n, stayed_n) = known.ok_or(Fate::NoForce)?;
    let features = *slip.features.get(slip.features.len() / 2).ok_or(Fate::NoFeatures)?;
    if stayed_n < LEAST_GAIN * slipped_n {
        return Err(Fate::NoGain);
    }
    if stayed_n > widest * slipped_n {
        return Err(Fate::Wide);
    }
    Ok(MeasuredSlip { t: slip.t, features, slipped_n, stayed_n })
}

#[cfg(test)]
mod tests {
    use super::{Fate, MeasuredSlip, SlipWatch, WatchConfig};
    use crate::collect::row::tests::features;
    use slip_core::{
        Phase, Sample, SlipReport, Step, grip::GripEvent, health::SensorHealth, sample::Scene,
        units::Micros,
    };

    const FIRST: SlipReport =
        SlipReport { phase: Phase::Gross, first: true, ..SlipReport::UNKNOWN };
    const ENDED: SlipReport = SlipReport::UNKNOWN;

    /// A millisecond for each force (N), with what happens then.
    fn play(
        forces: impl Iterator<Item = Option<f32>>,
        change: &dyn Fn(u64, &mut Step),
    ) -> Vec<Result<MeasuredSlip, Fate>> {
        let (mut watch, mut reported) =
            (SlipWatch::new(WatchConfig { stay_s: 0.2, widest: 2.0 }), Vec::new());
        for (ms, normal_force_n) in (0..).zip(forces) {
            let t = Micros(1000 * ms);
            let sample = Sample { normal_force_n, ..Sample::stylus(t, 0.0) };
            let mut step = Step {
                t,
                scene: Scene::Holding,
                statistic: 0.0,
                event: None,
                features: None,
                velocity: None,
                estimate: None,
                need: None,
                command: None,
                grip: None,
                sensors: [SensorHealth::Good; 4],
                floor_health: slip_core::detector::FloorHealth::Good,
            };
            change(ms, &mut step);
            watch.take(&sample, &step, &mut |slip| reported.push(slip));
        }
        watch.finish(&mut |slip| reported.push(slip));
        reported
    }

    /// Slips from 50 to 60 ms, features from 52 on.
    fn slip(ms: u64, step: &mut Step) {
        match ms {
            50 => step.event = Some(FIRST),
            52..60 => step.features = Some(features(4.0 + ms as f32)),
            60 => step.event = Some(ENDED),
            _ => {}
        }
    }

    fn held(after_n: f32) -> impl Iterator<Item = Option<f32>> {
        (0..400).map(move |ms| Some(if ms < 55 { 4.0 } else { after_n }))
    }

    fn fates(reported: &[Result<MeasuredSlip, Fate>]) -> Vec<Fate> {
        reported.iter().map(|slip| slip.as_ref().err().copied().unwrap_or(Fate::Kept)).collect()
    }

    #[test]
    fn a_slip_is_between_the_force_at_which_it_began_and_that_at_which_it_stayed() {
        let reported = play(held(5.0), &slip);
        let [Ok(slip)] = &reported[..] else { panic!("{reported:?}") };
        assert_eq!((slip.t, slip.features), (Micros(50_000), features(60.0)));
        assert!((slip.slipped_n - 4.0).abs() < 1e-3 && (slip.stayed_n - 5.0).abs() < 1e-3);
    }

    #[test]
    fn what_states_too_little_is_left_out_by_its_reason() {
        let of = |forces: &mut dyn Iterator<Item = Option<f32>>,
                  change: &dyn Fn(u64, &mut Step)| {
            fates(&play(forces, change))
        };
        assert_eq!(of(&mut held(9.0), &slip), [Fate::Wide]);
        assert_eq!(of(&mut held(4.0), &slip), [Fate::NoGain]);
        assert_eq!(of(&mut held(5.0).take(200), &slip), [Fate::Unfinished]);
        assert_eq!(of(&mut (0..400).map(|_| None), &slip), [Fate::NoForce]);
        // The sensor fails before the slip, and in the end: what it said before is no force.
        let mut before =
            held(5.0).enumerate().map(|(ms, force)| force.filter(|_| ms == 0 || ms > 51));
        assert_eq!(of(&mut before, &slip), [Fate::NoForce]);
        let mut after = held(5.0).enumerate().map(|(ms, force)| force.filter(|_| ms < 190));
        assert_eq!(of(&mut after, &slip), [Fate::NoForce]);
        let mut sparse = held(5.0).enumerate().map(|(ms, force)| force.filter(|_| ms % 20 == 0));
        assert_eq!(of(&mut sparse, &slip), [Fate::Kept]);
        let short = |ms, step: &mut Step| {
            slip(ms, step);
            step.features = None;
        };
        assert_eq!(of(&mut held(5.0), &short), [Fate::NoFeatures]);
        let twice = |ms, step: &mut Step| {
            slip(ms, step);
            slip(ms.saturating_sub(50), step);
        };
        assert_eq!(of(&mut held(5.0), &twice), [Fate::Again, Fate::NoGain]);
        let lost = |ms, step: &mut Step| {
            slip(ms, step);
            step.grip = (ms == 100).then_some(GripEvent::Lost);
        };
        assert_eq!(of(&mut held(5.0), &lost), [Fate::Unfinished]);
        let mut opened = (0..400).map(|ms| Some(if ms < 100 { 4.0 } else { 0.0 }));
        assert_eq!(of(&mut opened, &slip), [Fate::Unfinished]);
        assert_eq!(of(&mut held(5.0), &|_, _| ()), []);
    }
}
