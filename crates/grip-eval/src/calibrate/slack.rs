//! The blocks that the detector decides on in, the slack with which noise of their kind keeps the wanted interval out.

use crate::poisson;
use grip_session::calibration::StylusCalibration;
use slip_core::{
    ConfigError, PipelineConfig,
    detector::{AlarmSum, BANDS, Block, COMPONENTS, DetectorConfig, SlipDetector},
};

/// Slack is taken from 1.25 times the powers of 1.25, as many of them; the factor on all from the powers.
const STEP: f32 = 1.25;
const STEPS: usize = 31;
/// Stretches of the recording that serve one purpose by turns: their length at most (s), and their number at least.
const STRETCH_S: f64 = 10.0;
const STRETCHES: f64 = 8.0;
/// A scene has slack of its own from so much of it (s) on.
const LEAST_S: f32 = 2.0;
/// Time after which the filters start afresh (s), and the same in samples.
const GAP_S: f64 = 0.01;
const GAP_SAMPLES: f64 = 5.0;
/// Two-sided confidence whose upper bound is one-sided 95 %: 3.0 where nothing was seen.
const ONE_SIDED: f64 = 0.9;

/// Time between samples (s), `period_s` apart, from which there is a gap between them.
pub(super) fn gap_s(period_s: f32) -> f64 {
    (GAP_SAMPLES * f64::from(period_s)).max(GAP_S) + f64::from(period_s)
}

/// Consecutive blocks that serve one purpose.
struct Run {
    /// Whether they judge the slack that the others have given.
    judges: bool,
    blocks: Vec<Block>,
}

/// All that decides.
pub(super) struct Heard {
    config: PipelineConfig,
    readings: [f32; BANDS],
    block_s: f32,
    stretch_blocks: usize,
    runs: Vec<Run>,
    blocks: usize,
    /// Number and time (s) of the last block.
    last: Option<(u32, f64)>,
}

impl Heard {
    /// Nothing yet of a recording of `seconds` (s).
    pub(super) fn new(config: PipelineConfig, seconds: f64) -> Result<Self, ConfigError> {
        let (readings, block_s) = config.detector.readings_at(config.sample_rate.0)?;
        let stretch_s = STRETCH_S.min(seconds / STRETCHES);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let stretch_blocks = ((stretch_s / f64::from(block_s)) as usize).max(1);
        Ok(Self {
            config,
            readings,
            block_s,
            stretch_blocks,
            runs: Vec::new(),
            blocks: 0,
            last: None,
        })
    }

    /// Takes the block that `detector` has decided on since the last call, if there is one, at `at_s` (s).
    pub(super) fn push(&mut self, detector: &SlipDetector, at_s: f64) {
        let number = detector.decisions();
        let is_new = self.last.is_none_or(|(last, _)| last != number);
        let Some(block) = detector.block().filter(|_| is_new) else { return };
        let goes_on = self.last.is_some_and(|(_, last_s)| at_s - last_s <= gap_s(self.block_s));
        self.last = Some((number, at_s));
        let judges = self.blocks / self.stretch_blocks % 2 == 1;
        self.blocks += 1;
        match self.runs.last_mut().filter(|run| goes_on && run.judges == judges) {
            Some(run) => run.blocks.push(*block),
            None => self.runs.push(Run { judges, blocks: vec![*block] }),
        }
    }

    /// Whether the sum decides at this rate.
    pub(super) fn decides(&self) -> bool {
        self.config.detector.reaches_above_motion(self.config.sample_rate.0)
    }

    /// The sum with the slack of `calibration`.
    pub(super) fn sum(&self, calibration: &StylusCalibration) -> AlarmSum {
        let StylusCalibration { slack_still, slack_moving, .. } = *calibration;
        #[expect(clippy::cast_possible_truncation, reason = "1 to 1e9")]
        let interval_s = calibration.evidence.wanted_interval_s as f32;
        let config =
            DetectorConfig { interval_s, slack_still, slack_moving, ..self.config.detector };
        AlarmSum::new(&config, &self.readings, self.block_s)
    }

    /// Sets the slack: for each component and scene the least with which its sum alone keeps the interval in one half
    /// of the stretches, times one factor for the other half.
    pub(super) fn fit(&self, calibration: &mut StylusCalibration) {
        let shipped = [calibration.slack_still, calibration.slack_moving];
        // All at once, each by bisection: more slack is never more evidence.
        let (mut low, mut high) = ([[0; COMPONENTS]; 2], [[STEPS - 1; COMPONENTS]; 2]);
        while low != high {
            let middle = midpoints(&low, &high);
            let slack = middle.map(|scene| scene.map(|step| STEP * power(step)));
            [calibration.slack_still, calibration.slack_moving] = slack;
            let quiet = self.keep_the_interval(calibration);
            for scene in 0..2 {
                for i in 0..COMPONENTS {
                    if quiet[scene][i] {
                        high[scene][i] = middle[scene][i];
                    } else {
                        low[scene][i] = (middle[scene][i] + 1).min(high[scene][i]);
                    }
                }
            }
        }
        let fitted = high.map(|scene| scene.map(|step| STEP * power(step)));
        let sum = self.sum(calibration);
        let known = [false, true].map(|moving| {
            let enough = self.seconds(|run, block| !run.judges && block.moving == moving)
                >= LEAST_S
                && (!moving || calibration.gain.is_some());
            sum.decides(moving).map(|decides| decides && enough)
        });
        let slack: [[f32; COMPONENTS]; 2] = core::array::from_fn(|scene| {
            core::array::from_fn(|i| match (known[scene][i], known[1 - scene][i]) {
                (true, _) => fitted[scene][i],
                // What was not heard is as in the other scene at best.
                (false, true) => shipped[scene][i].max(fitted[1 - scene][i]),
                (false, false) => shipped[scene][i],
            })
        });
        [calibration.slack_still, calibration.slack_moving] = slack;
        let mut factor = 0..STEPS;
        while !factor.is_empty() {
            let middle = usize::midpoint(factor.start, factor.end);
            let mut tried = *calibration;
            raise(&mut tried, middle);
            let alarms = self.alarms(&tried);
            factor = if alarms > 0 { middle + 1..factor.end } else { factor.start..middle };
        }
        raise(calibration, factor.start);
    }

    /// Counts the alarms of the slack in the half that it was not taken from, and states what they promise.
    pub(super) fn judge(&self, calibration: &mut StylusCalibration) {
        if !self.decides() {
            return;
        }
        let judged_s = f64::from(self.seconds(|run, _| run.judges));
        let alarms = self.alarms(calibration);
        let most = poisson::interval(alarms, ONE_SIDED).1;
        let evidence = &mut calibration.evidence;
        (evidence.judged_s, evidence.alarms) = (judged_s, alarms);
        evidence.interval_low_s = judged_s / most;
    }

    #[expect(clippy::cast_precision_loss, reason = "a count of blocks")]
    fn seconds(&self, counts: impl Fn(&Run, &Block) -> bool) -> f32 {
        let count = |run: &Run| run.blocks.iter().filter(|block| counts(run, block)).count();
        self.block_s * self.runs.iter().map(count).sum::<usize>() as f32
    }

    /// Whether the sum of each component alone stays below the interval in the half that slack is taken from, still
    /// and moving.
    fn keep_the_interval(&self, calibration: &StylusCalibration) -> [[bool; COMPONENTS]; 2] {
        let mut sum = self.sum(calibration);
        let mut quiet = [[true; COMPONENTS]; 2];
        #[expect(clippy::cast_possible_truncation, reason = "1 to 1e9")]
        let interval_s = calibration.evidence.wanted_interval_s as f32;
        for run in self.runs.iter().filter(|run| !run.judges) {
            // Evidence of one scene shows nothing of the slack of the other.
            for scene in run.blocks.chunk_by(|a, b| a.moving == b.moving) {
                sum.reset();
                for block in scene {
                    sum.step(block);
                    let evidence_s = sum.evidence_s();
                    let quiet = &mut quiet[usize::from(block.moving)];
                    for (quiet, evidence_s) in quiet.iter_mut().zip(evidence_s) {
                        *quiet &= evidence_s < interval_s;
                    }
                }
            }
        }
        quiet
    }

    /// Seconds with evidence beyond the interval in the half that judges.
    fn alarms(&self, calibration: &StylusCalibration) -> u64 {
        let mut sum = self.sum(calibration);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let second = ((1.0 / self.block_s) as usize).max(1);
        let mut alarms = 0;
        for run in self.runs.iter().filter(|run| run.judges) {
            sum.reset();
            for second in run.blocks.chunks(second) {
                let highest = second.iter().map(|block| sum.step(block)).fold(0.0, f32::max);
                alarms += u64::from(highest >= 1.0);
            }
        }
        alarms
    }
}

/// A step of the grid for each scene and component.
type Steps = [[usize; COMPONENTS]; 2];

fn midpoints(low: &Steps, high: &Steps) -> Steps {
    core::array::from_fn(|scene| {
        core::array::from_fn(|i| usize::midpoint(low[scene][i], high[scene][i]))
    })
}

fn power(step: usize) -> f32 {
    (0..step).map(|_| STEP).product()
}

/// Raises all slack by so many steps of the grid.
pub(super) fn raise(calibration: &mut StylusCalibration, steps: usize) {
    for slack in [&mut calibration.slack_still, &mut calibration.slack_moving] {
        *slack = slack.map(|slack| slack * power(steps));
    }
}
