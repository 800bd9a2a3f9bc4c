//! The detector on simulated hands: false alarms without slip, latency and misses with it.

use super::{
    ours::Ours,
    robot::{Hand, INCIPIENT_S, RobotConfig},
};
use rayon::prelude::*;

/// What a run without any slip showed.
#[derive(Clone, Debug, Default)]
pub struct NullRun {
    /// Hours of signal.
    pub hours: f64,
    /// Seed of the robot and time of each false alarm (s): where a slip begins.
    pub alarms: Vec<(u64, f64)>,
    /// Highest statistic of each minute.
    pub peaks: Vec<f64>,
}

/// Warm-up that is not counted (s): the floor is learned.
const WARM_UP_S: f64 = 2.0;
/// Length of a piece (s): each is another robot.
const PIECE_S: f64 = 600.0;

/// `hours` of a held object that never slips, in pieces of ten minutes, each another robot with another seed.
#[must_use]
pub fn null_run(robot: RobotConfig, hours: f64, seed: u64, ours: &Ours) -> NullRun {
    let pieces = (hours * 3600.0 / PIECE_S).ceil().max(1.0) as u64;
    let runs: Vec<NullRun> = (0..pieces)
        .into_par_iter()
        .map(|piece| null_piece(robot, seed + piece, ours.clone()))
        .collect();
    runs.into_iter().fold(NullRun::default(), |mut total, run| {
        total.hours += run.hours;
        total.alarms.extend(run.alarms);
        total.peaks.extend(run.peaks);
        total
    })
}

fn null_piece(robot: RobotConfig, seed: u64, mut alarm: Ours) -> NullRun {
    let mut hand = Hand::new(robot, 1.6, seed);
    let samples = |s: f64| (s * robot.rate_hz) as u64;
    for _ in 0..samples(WARM_UP_S) {
        alarm.step(&hand.sample());
    }
    let mut run = NullRun { hours: PIECE_S / 3600.0, ..NullRun::default() };
    let (mut on, mut peak) = (false, 0.0_f64);
    for i in 1..=samples(PIECE_S) {
        let before = core::mem::replace(&mut on, alarm.step(&hand.sample()));
        peak = peak.max(alarm.statistic());
        if on && !before {
            run.alarms.push((seed, WARM_UP_S + i as f64 / robot.rate_hz));
        }
        if i % samples(60.0) == 0 {
            run.peaks.push(core::mem::take(&mut peak));
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
pub(super) const SESSION: u64 = 20;
/// Robot before the first slip (s).
const BEFORE_S: f64 = 6.0;
/// Gross slip after which it is missed (s).
pub(super) const LATE_S: f64 = 0.2;
/// The robot counts as moving from this part of full motion on.
pub(super) const MOVES: f64 = 0.25;

/// Lets `slips.count` objects slip, twenty with each robot.
#[must_use]
pub fn slips(robot: RobotConfig, slips: Slips, ours: &Ours) -> Vec<Trial> {
    let robot = slips.robot(robot);
    (0..slips.count.div_ceil(SESSION))
        .into_par_iter()
        .flat_map_iter(|session| slip_session(robot, slips, slips.seed + session, ours.clone()))
        .collect()
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

fn slip_session(robot: RobotConfig, slips: Slips, seed: u64, mut alarm: Ours) -> Vec<Trial> {
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

fn one_slip(hand: &mut Hand, alarm: &mut Ours, rate_hz: f64) -> Trial {
    hand.begin_slip();
    let mut outcome = Trial::Missed;
    for i in 1..=((INCIPIENT_S + LATE_S) * rate_hz) as u64 {
        if alarm.step(&hand.sample()) && outcome == Trial::Missed {
            let t = i as f64 / rate_hz - INCIPIENT_S;
            outcome = if i == 1 { Trial::Early } else { Trial::Found(1e3 * t) };
        }
    }
    outcome
}
