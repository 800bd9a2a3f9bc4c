//! Detectors at thresholds for stated false-alarm rates: what a long run without slip shows of the thresholds, and how late each is then.

use super::{
    latency::Latency,
    ours::Ours,
    peers::Peer,
    robot::{Hand, RobotConfig},
    tail::Tail,
    trials::{Alarm, Slips, null_runs, slips_of_all},
};
use serde::Serialize;
use slip_core::{ConfigError, PipelineConfig, Sample, Signal, units::Hertz};

/// How a detector works.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Ours,
    Fft,
    Pad,
    Single,
}

/// A detector that takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contestant {
    /// Its name.
    pub name: &'static str,
    kind: Kind,
}

/// All of them.
pub const CONTESTANTS: [Contestant; 4] = [
    Contestant { name: "shipped", kind: Kind::Ours },
    Contestant { name: "block FFT 128", kind: Kind::Fft },
    Contestant { name: "force-scaled pad", kind: Kind::Pad },
    Contestant { name: "single threshold", kind: Kind::Single },
];

/// A threshold that no signal reaches.
const NEVER: f64 = 1e6;
/// Share of the seconds that make the tail which is continued.
const TAIL: f64 = 0.01;
/// A rate is counted where a run has this many of its intervals, otherwise the tail is continued.
const INTERVALS: f64 = 10.0;

/// Any detector with its threshold.
#[derive(Clone, Debug)]
pub enum Detector {
    /// The pipeline with `factor` times the configured interval.
    Ours {
        /// The pipeline.
        ours: Box<Ours>,
        /// Interval over the configured one.
        factor: f64,
    },
    /// An older one.
    Peer(Peer),
}

impl Alarm for Detector {
    #[inline]
    fn step(&mut self, sample: &Sample) -> bool {
        match self {
            Self::Ours { ours, .. } => ours.step(sample),
            Self::Peer(peer) => peer.step(sample),
        }
    }

    /// In the unit of the threshold that [`Contestant::make`] takes.
    fn statistic(&self) -> f64 {
        match self {
            Self::Ours { ours, factor } => factor * ours.statistic(),
            Self::Peer(peer) => peer.statistic(),
        }
    }
}

impl Contestant {
    /// The detector. `threshold` is a factor on the configured interval for the pipeline and has the unit of the statistic for the others.
    ///
    /// # Errors
    /// Where the configuration is refused: a factor below 1/600.
    pub fn make(&self, rate_hz: f64, threshold: f64) -> Result<Detector, ConfigError> {
        Ok(match self.kind {
            Kind::Ours => {
                let mut config =
                    PipelineConfig::observing(Signal::Displacement, Hertz(rate_hz as f32));
                config.detector.interval_s *= threshold as f32;
                Detector::Ours { ours: Box::new(Ours::new(config)?), factor: threshold }
            }
            Kind::Fft => Detector::Peer(Peer::fft(rate_hz, threshold)),
            Kind::Pad => Detector::Peer(Peer::pad(rate_hz, threshold)),
            Kind::Single => Detector::Peer(Peer::single(rate_hz, threshold)),
        })
    }
}

/// Every contestant with a threshold that nothing reaches.
///
/// # Errors
/// Never with the shipped configuration.
pub fn deaf(rate_hz: f64) -> Result<Vec<Detector>, ConfigError> {
    CONTESTANTS.iter().map(|contestant| contestant.make(rate_hz, NEVER)).collect()
}

/// Lets `detectors` learn their floors: two seconds.
pub fn warm_up(hand: &mut Hand, detectors: &mut [Detector]) {
    for _ in 0..(2.0 * hand.rate_hz()) as u64 {
        let sample = hand.sample();
        for detector in &mut *detectors {
            detector.step(&sample);
        }
    }
}

/// A detector at a threshold.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Working {
    /// Its name.
    pub detector: &'static str,
    /// False alarms an hour that were wanted.
    pub wanted_per_hour: f64,
    /// The threshold.
    pub threshold: f64,
    /// Whether the run without slip was shorter than ten intervals, so that its tail was continued.
    pub continued: bool,
    /// What a fresh run without slip showed.
    pub fresh: Option<Fresh>,
    /// Outcome for each kind of slip.
    pub slips: Vec<Outcome>,
}

/// False alarms counted on a run without slip that had no part in the threshold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fresh {
    /// Hours of signal.
    pub hours: f64,
    /// False alarms.
    pub alarms: u64,
}

/// How late a detector is for one kind of slip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Roughness (um).
    pub ra_um: f64,
    /// Whether the robot moves.
    pub moving: bool,
    /// How late it is.
    pub latency: Latency,
}

impl Working {
    /// The outcome for slips of this kind.
    #[must_use]
    pub fn outcome(&self, ra_um: f64, moving: bool) -> Option<&Outcome> {
        self.slips.iter().find(|o| (o.ra_um - ra_um).abs() < 1e-9 && o.moving == moving)
    }
}

/// Sets the threshold of every contestant for each of `per_hour` false alarms an hour, on `hours` without slip from `seed` on.
///
/// # Errors
/// As [`deaf`].
pub fn thresholds(
    robot: RobotConfig,
    hours: f64,
    seed: u64,
    per_hour: &[f64],
) -> Result<Vec<Working>, ConfigError> {
    let warm = deaf(robot.rate_hz)?;
    let runs = null_runs(robot, hours, seed, || warm.clone());
    let mut working = Vec::new();
    for (contestant, run) in CONTESTANTS.iter().zip(runs) {
        let mut seconds: Vec<f32> = run.seconds.iter().map(|level| *level as f32).collect();
        seconds.sort_by(f32::total_cmp);
        for &wanted_per_hour in per_hour {
            let (threshold, continued) = threshold(&seconds, run.hours * wanted_per_hour);
            working.push(Working {
                detector: contestant.name,
                wanted_per_hour,
                threshold,
                continued,
                fresh: None,
                slips: Vec::new(),
            });
        }
    }
    Ok(working)
}

/// The level that `passes` of the seconds exceed, and whether the tail was continued for it.
fn threshold(seconds: &[f32], passes: f64) -> (f64, bool) {
    if passes >= INTERVALS {
        let place = seconds.len().saturating_sub(passes.round() as usize + 1);
        return (seconds.get(place).map_or(NEVER, |level| f64::from(*level)), false);
    }
    let tail = (TAIL * seconds.len() as f64) as usize;
    let tail = Tail::of(seconds, tail, seconds.len());
    (tail.map_or(NEVER, |tail| f64::from(tail.level(seconds.len() as f64 / passes))), true)
}

/// Counts the false alarms of `working` on a fresh run of `hours` from `seed` on, at those rates an hour that are `wanted`.
///
/// # Errors
/// Where a threshold is too low for the configuration.
pub fn count_false(
    robot: RobotConfig,
    hours: f64,
    seed: u64,
    working: &mut [Working],
    wanted: &[f64],
) -> Result<(), ConfigError> {
    let is_wanted = |w: &Working| wanted.iter().any(|r| (w.wanted_per_hour / r - 1.0).abs() < 1e-9);
    let mut counted: Vec<&mut Working> = working.iter_mut().filter(|w| is_wanted(w)).collect();
    let warm = made(robot.rate_hz, counted.iter().map(|working| &**working))?;
    for (working, run) in counted.iter_mut().zip(null_runs(robot, hours, seed, || warm.clone())) {
        working.fresh = Some(Fresh { hours: run.hours, alarms: run.alarms });
    }
    Ok(())
}

/// Lets objects slip under all of `working`, which get the same samples.
///
/// # Errors
/// As [`count_false`].
pub fn let_slip(
    robot: RobotConfig,
    slips: Slips,
    working: &mut [Working],
) -> Result<(), ConfigError> {
    let warm = made(robot.rate_hz, working.iter())?;
    for (working, trials) in working.iter_mut().zip(slips_of_all(robot, slips, || warm.clone())) {
        let latency = Latency::of(&trials);
        working.slips.push(Outcome { ra_um: slips.ra_um, moving: slips.moving, latency });
    }
    Ok(())
}

fn made<'a>(
    rate_hz: f64,
    working: impl Iterator<Item = &'a Working>,
) -> Result<Vec<Detector>, ConfigError> {
    working
        .filter_map(|working| {
            let contestant = CONTESTANTS.iter().find(|c| c.name == working.detector)?;
            Some(contestant.make(rate_hz, working.threshold))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Alarm, CONTESTANTS, deaf, threshold};
    use crate::detection::{Hand, RobotConfig};

    /// The statistic is in the unit of the threshold, whatever the threshold.
    #[test]
    fn levels_do_not_depend_on_the_threshold() {
        let mut hand = Hand::new(RobotConfig::default(), 1.6, 5);
        let mut deaf = deaf(1e4).unwrap();
        let mut reception: Vec<_> = CONTESTANTS.iter().map(|c| c.make(1e4, 2.0).unwrap()).collect();
        let mut seen = [0.0_f64; CONTESTANTS.len()];
        for _ in 0..60_000 {
            let sample = hand.sample();
            for ((a, b), seen) in deaf.iter_mut().zip(&mut reception).zip(&mut seen) {
                assert!(!a.step(&sample));
                b.step(&sample);
                let (a, b) = (a.statistic(), b.statistic());
                *seen = seen.max(a);
                assert!((a - b).abs() <= 1e-4 * a.abs().max(b.abs()) + 1e-30, "{a} {b}");
            }
        }
        assert!(seen.iter().all(|level| *level > 0.0), "{seen:?}");
    }

    /// Levels 1 to 3600, one a second for an hour: counted where there are ten intervals, continued beyond, never lower.
    #[test]
    fn rarer_alarms_need_higher_thresholds_and_short_runs_say_so() {
        let seconds: Vec<f32> = (1..=3600_u16).map(f32::from).collect();
        let (often, counted) = threshold(&seconds, 60.0);
        assert!((often - 3540.0).abs() < 1.5 && !counted, "{often}");
        assert_eq!(seconds.iter().filter(|level| f64::from(**level) > often).count(), 60);
        let (seldom, continued) = threshold(&seconds, 1.0);
        assert!(seldom > often && seldom < 4000.0 && continued, "{seldom}");
        assert!(threshold(&seconds, 0.1).0 > seldom);
    }
}
