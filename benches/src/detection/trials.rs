//! Detectors on simulated hands: false alarms without slip, latency and misses with it.

use super::robot::{Hand, INCIPIENT_S, RobotConfig};
use rayon::prelude::*;
use slip_core::Sample;

/// Anything that says with each sample whether it sees a slip.
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
    let pieces = (hours * 3600.0 / PIECE_S).ceil().max(1.0) as u64;
    let runs: Vec<NullRun> =
        (0..pieces).into_par_iter().map(|piece| null_piece(robot, seed + piece, make())).collect();
    let mut total = NullRun::default();
    for run in runs {
        total.hours += run.hours;
        total.alarms += run.alarms;
        total.places.extend(run.places);
        total.peaks.extend(run.peaks);
        total.levels.extend(run.levels);
    }
    total
}

fn null_piece<A: Alarm>(robot: RobotConfig, seed: u64, mut alarm: A) -> NullRun {
    let mut hand = Hand::new(robot, 1.6, seed);
    let samples = |s: f64| (s * robot.rate_hz) as u64;
    for _ in 0..samples(WARM_UP_S) {
        alarm.step(&hand.sample());
    }
    let mut run = NullRun { hours: PIECE_S / 3600.0, ..NullRun::default() };
    let mut on = false;
    let minute = samples(60.0);
    let mut peak = 0.0_f64;
    let mut levels = [0.0_f64; 7];
    for i in 1..=samples(PIECE_S) {
        let now = alarm.step(&hand.sample());
        if now && !on {
            run.alarms += 1;
            run.places.push((seed, WARM_UP_S + i as f64 / robot.rate_hz));
        }
        on = now;
        peak = peak.max(alarm.statistic());
        for (most, level) in levels.iter_mut().zip(alarm.levels()) {
            *most = most.max(level);
        }
        if i % minute == 0 {
            run.peaks.push(peak);
            run.levels.push(levels);
            peak = 0.0;
            levels = [0.0; 7];
        }
    }
    run
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
const LATE_S: f64 = 0.2;
/// The robot counts as moving from this part of full motion on.
const MOVES: f64 = 0.25;

/// Lets `slips.count` objects slip, twenty with each robot.
pub fn slips<A: Alarm>(
    robot: RobotConfig,
    slips: Slips,
    make: impl Fn() -> A + Sync,
) -> Vec<Trial> {
    let level = if slips.moving { robot.level } else { 0.0 };
    let taps_per_s = if slips.moving { robot.taps_per_s } else { 0.0 };
    let robot = RobotConfig { level, taps_per_s, ..robot };
    (0..slips.count.div_ceil(SESSION))
        .into_par_iter()
        .flat_map_iter(|session| slip_session(robot, slips, slips.seed + session, make()))
        .collect()
}

fn slip_session<A: Alarm>(robot: RobotConfig, slips: Slips, seed: u64, mut alarm: A) -> Vec<Trial> {
    let mut hand = Hand::new(robot, slips.ra_um, seed);
    let samples = |s: f64| (s * robot.rate_hz) as u64;
    for _ in 0..samples(BEFORE_S) {
        alarm.step(&hand.sample());
    }
    let mut trials = Vec::new();
    for _ in 0..SESSION {
        for _ in 0..samples(1.0 + hand.uniform()) {
            alarm.step(&hand.sample());
        }
        while slips.moving && hand.envelope() < MOVES {
            alarm.step(&hand.sample());
        }
        trials.push(one_slip(&mut hand, &mut alarm, robot.rate_hz));
        hand.end_slip();
    }
    trials
}

fn one_slip<A: Alarm>(hand: &mut Hand, alarm: &mut A, rate_hz: f64) -> Trial {
    hand.begin_slip();
    let mut outcome = Trial::Missed;
    let count = ((INCIPIENT_S + LATE_S) * rate_hz) as u64;
    for i in 1..=count {
        let now = alarm.step(&hand.sample());
        if now && outcome == Trial::Missed {
            let t = i as f64 / rate_hz - INCIPIENT_S;
            outcome = if i == 1 { Trial::Early } else { Trial::Found(1e3 * t) };
        }
    }
    outcome
}
