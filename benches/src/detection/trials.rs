//! Detectors on simulated hands: false alarms without slip, latency and misses with it.

use super::robot::{Hand, INCIPIENT_S, RobotConfig};
use rayon::prelude::*;
use slip_core::Sample;

/// Anything that states with each sample whether it sees a slip.
pub trait Alarm {
    /// Takes the next sample; true while it sees a slip.
    fn step(&mut self, sample: &Sample) -> bool;

    /// The statistic over its threshold, for detectors that have one.
    fn statistic(&self) -> f64 {
        0.0
    }

    /// What its tests see before their thresholds, for detectors that have several.
    fn levels(&self) -> [f64; 7] {
        [0.0; 7]
    }
}

/// What a run without any slip showed.
#[derive(Clone, Debug, Default)]
pub struct NullRun {
    /// Hours of signal.
    pub hours: f64,
    /// False alarms: begins of a slip.
    pub alarms: u64,
    /// Seed of the robot and time of each alarm (s).
    pub places: Vec<(u64, f64)>,
    /// Highest statistic of each second.
    pub seconds: Vec<f64>,
    /// Highest statistic of each minute.
    pub peaks: Vec<f64>,
    /// Highest level of each test in each minute.
    pub levels: Vec<[f64; 7]>,
}

/// Warm-up that is not counted (s): the floor is learned.
const WARM_UP_S: f64 = 2.0;
/// Length of a piece (s): each is another robot.
const PIECE_S: f64 = 600.0;

/// `hours` of a held object that never slips, in pieces of ten minutes, each another robot with another seed.
pub fn null_run<A: Alarm>(
    robot: RobotConfig,
    hours: f64,
    seed: u64,
    make: impl Fn() -> A + Sync,
) -> NullRun {
    null_runs(robot, hours, seed, || vec![make()]).pop().unwrap_or_default()
}

/// The same for several detectors that get the same samples: one result for each that `make` gives.
pub fn null_runs<A: Alarm>(
    robot: RobotConfig,
    hours: f64,
    seed: u64,
    make: impl Fn() -> Vec<A> + Sync,
) -> Vec<NullRun> {
    let pieces = (hours * 3600.0 / PIECE_S).ceil().max(1.0) as u64;
    let runs: Vec<Vec<NullRun>> =
        (0..pieces).into_par_iter().map(|piece| null_piece(robot, seed + piece, make())).collect();
    let mut runs = runs.into_iter();
    let mut totals = runs.next().unwrap_or_default();
    for piece in runs {
        for (total, run) in totals.iter_mut().zip(piece) {
            total.hours += run.hours;
            total.alarms += run.alarms;
            total.places.extend(run.places);
            total.seconds.extend(run.seconds);
            total.peaks.extend(run.peaks);
            total.levels.extend(run.levels);
        }
    }
    totals
}

/// A detector in a run without slip, and what it has shown.
struct Watched<A> {
    alarm: A,
    on: bool,
    second: f64,
    minute: f64,
    levels: [f64; 7],
    run: NullRun,
}

impl<A: Alarm> Watched<A> {
    fn new(alarm: A) -> Self {
        let run = NullRun { hours: PIECE_S / 3600.0, ..NullRun::default() };
        Self { alarm, on: false, second: 0.0, minute: 0.0, levels: [0.0; 7], run }
    }

    /// Takes a sample; true where an alarm begins.
    fn step(&mut self, sample: &Sample) -> bool {
        let before = core::mem::replace(&mut self.on, self.alarm.step(sample));
        self.second = self.second.max(self.alarm.statistic());
        for (most, level) in self.levels.iter_mut().zip(self.alarm.levels()) {
            *most = most.max(level);
        }
        self.on && !before
    }

    fn end_second(&mut self) {
        let second = core::mem::take(&mut self.second);
        self.minute = self.minute.max(second);
        self.run.seconds.push(second);
    }

    fn end_minute(&mut self) {
        self.run.peaks.push(core::mem::take(&mut self.minute));
        self.run.levels.push(core::mem::take(&mut self.levels));
    }
}

fn null_piece<A: Alarm>(robot: RobotConfig, seed: u64, alarms: Vec<A>) -> Vec<NullRun> {
    let mut hand = Hand::new(robot, 1.6, seed);
    let samples = |s: f64| (s * robot.rate_hz) as u64;
    let mut watched: Vec<_> = alarms.into_iter().map(Watched::new).collect();
    for _ in 0..samples(WARM_UP_S) {
        let sample = hand.sample();
        for watched in &mut watched {
            watched.alarm.step(&sample);
        }
    }
    for i in 1..=samples(PIECE_S) {
        let sample = hand.sample();
        for watched in &mut watched {
            if watched.step(&sample) {
                watched.run.alarms += 1;
                watched.run.places.push((seed, WARM_UP_S + i as f64 / robot.rate_hz));
            }
        }
        if i % samples(1.0) == 0 {
            watched.iter_mut().for_each(Watched::end_second);
        }
        if i % samples(60.0) == 0 {
            watched.iter_mut().for_each(Watched::end_minute);
        }
    }
    watched.into_iter().map(|watched| watched.run).collect()
}

/// The outcome of one slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trial {
    /// An alarm stood already when the slip began.
    Early,
    /// Time from gross slip to the alarm (ms); negative while the slip was incipient.
    Found(f64),
    /// No alarm within 200 ms of gross slip.
    Missed,
}

/// Slips to make.
#[derive(Clone, Copy, Debug)]
pub struct Slips {
    /// Roughness of the objects (um).
    pub ra_um: f64,
    /// Whether the robot moves at the time of each slip.
    pub moving: bool,
    /// How many.
    pub count: u64,
    /// First seed.
    pub seed: u64,
}

/// Slips of one robot.
const SESSION: u64 = 20;
/// Robot before the first slip (s).
const BEFORE_S: f64 = 6.0;
/// Gross slip after which it is missed (s).
pub(super) const LATE_S: f64 = 0.2;
/// The robot counts as moving from this part of full motion on.
pub(super) const MOVES: f64 = 0.25;

/// Lets `slips.count` objects slip, twenty with each robot.
pub fn slips<A: Alarm>(
    robot: RobotConfig,
    slips: Slips,
    make: impl Fn() -> A + Sync,
) -> Vec<Trial> {
    slips_of_all(robot, slips, || vec![make()]).pop().unwrap_or_default()
}

/// The same for several detectors that get the same samples: the trials of each that `make` gives.
pub fn slips_of_all<A: Alarm>(
    robot: RobotConfig,
    slips: Slips,
    make: impl Fn() -> Vec<A> + Sync,
) -> Vec<Vec<Trial>> {
    let robot = slips.robot(robot);
    let sessions: Vec<Vec<Vec<Trial>>> = (0..slips.count.div_ceil(SESSION))
        .into_par_iter()
        .map(|session| slip_session(robot, slips, slips.seed + session, make()))
        .collect();
    let mut sessions = sessions.into_iter();
    let mut totals = sessions.next().unwrap_or_default();
    for session in sessions {
        for (total, trials) in totals.iter_mut().zip(session) {
            total.extend(trials);
        }
    }
    totals
}

impl Slips {
    /// `robot`, kept still where the slips are those of a still one.
    #[must_use]
    pub fn robot(&self, robot: RobotConfig) -> RobotConfig {
        let level = if self.moving { robot.level } else { 0.0 };
        let taps_per_s = if self.moving { robot.taps_per_s } else { 0.0 };
        RobotConfig { level, taps_per_s, ..robot }
    }
}

fn slip_session<A: Alarm>(
    robot: RobotConfig,
    slips: Slips,
    seed: u64,
    mut alarms: Vec<A>,
) -> Vec<Vec<Trial>> {
    let mut hand = Hand::new(robot, slips.ra_um, seed);
    let samples = |s: f64| (s * robot.rate_hz) as u64;
    let mut all: Vec<Vec<Trial>> = alarms.iter().map(|_| Vec::new()).collect();
    let step_all = |hand: &mut Hand, alarms: &mut Vec<A>| {
        let sample = hand.sample();
        for alarm in alarms {
            alarm.step(&sample);
        }
    };
    for _ in 0..samples(BEFORE_S) {
        step_all(&mut hand, &mut alarms);
    }
    for _ in 0..SESSION {
        for _ in 0..samples(1.0 + hand.uniform()) {
            step_all(&mut hand, &mut alarms);
        }
        while slips.moving && hand.envelope() < MOVES {
            step_all(&mut hand, &mut alarms);
        }
        let trials = one_slip(&mut hand, &mut alarms, robot.rate_hz);
        all.iter_mut().zip(trials).for_each(|(all, trial)| all.push(trial));
        hand.end_slip();
    }
    all
}

fn one_slip<A: Alarm>(hand: &mut Hand, alarms: &mut [A], rate_hz: f64) -> Vec<Trial> {
    hand.begin_slip();
    let mut outcomes = vec![Trial::Missed; alarms.len()];
    let count = ((INCIPIENT_S + LATE_S) * rate_hz) as u64;
    for i in 1..=count {
        let sample = hand.sample();
        for (alarm, outcome) in alarms.iter_mut().zip(&mut outcomes) {
            let now = alarm.step(&sample);
            if now && *outcome == Trial::Missed {
                let t = i as f64 / rate_hz - INCIPIENT_S;
                *outcome = if i == 1 { Trial::Early } else { Trial::Found(1e3 * t) };
            }
        }
    }
    outcomes
}
