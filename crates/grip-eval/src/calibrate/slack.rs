//! Slack of the detector, from the blocks it decides on: with it, noise of their kind keeps the wanted false-alarm interval.

use crate::poisson;
use grip_session::calibration::StylusCalibration;
use slip_core::{
    ConfigError, PipelineConfig,
    detector::{AlarmSum, BANDS, Block, COMPONENTS, DetectorConfig, SlipDetector},
    health,
    units::Hertz,
};

/// Slack is taken from the powers of this, itself the least, up to [`MOST`]; a factor on all slack from the same.
const STEP: f32 = 1.25;
const MOST: f32 = 1e3;
/// Stretches of the recording that serve one purpose by turns: their length at most (s), and their number at least.
const STRETCH_S: f64 = 10.0;
const STRETCHES: f64 = 8.0;
/// A scene has slack of its own from so much of it (s) on.
const LEAST_S: f32 = 2.0;
/// Two-sided confidence whose upper bound is one-sided 95 %: 3.0 where nothing was seen.
const ONE_SIDED: f64 = 0.9;

/// One value for each component, still and moving.
type Scenes<T> = [[T; COMPONENTS]; 2];

/// All that decides.
pub(super) struct DecidedBlocks {
    config: PipelineConfig,
    readings: [f32; BANDS],
    block_s: f32,
    stretch_blocks: usize,
    /// Runs of blocks without a gap that give the slack, and those that judge it.
    halves: [Vec<Vec<Block>>; 2],
    blocks: usize,
    /// Number and time (s) of the last block, and its half.
    last: Option<(u32, f64, usize)>,
}

impl DecidedBlocks {
    /// Nothing yet of a recording of `seconds` (s).
    pub(super) fn new(config: PipelineConfig, seconds: f64) -> Result<Self, ConfigError> {
        let (readings, block_s) = config.detector.readings_at(config.sample_rate.0)?;
        let stretch_s = STRETCH_S.min(seconds / STRETCHES);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let stretch_blocks = ((stretch_s / f64::from(block_s)) as usize).max(1);
        let (halves, blocks, last) = Default::default();
        Ok(Self { config, readings, block_s, stretch_blocks, halves, blocks, last })
    }

    /// Takes the block that `detector` has decided on since the last call, if there is one, at `at_s` (s).
    pub(super) fn push(&mut self, detector: &SlipDetector, at_s: f64) {
        let (number, half) = (detector.decisions(), self.blocks / self.stretch_blocks % 2);
        let is_new = self.last.is_none_or(|(last, ..)| last != number);
        let Some(block) = detector.block().filter(|_| is_new) else { return };
        let goes_on = |(_, last_s, last): (u32, f64, usize)| {
            last == half && at_s - last_s <= health::gap(Hertz(1.0 / self.block_s)).as_seconds()
        };
        let runs = &mut self.halves[half];
        match runs.last_mut().filter(|_| self.last.is_some_and(goes_on)) {
            Some(run) => run.push(*block),
            None => runs.push(vec![*block]),
        }
        self.blocks += 1;
        self.last = Some((number, at_s, half));
    }

    /// Whether the sum decides at this rate.
    pub(super) fn decides(&self) -> bool {
        self.config.detector.reaches_above_motion(self.config.sample_rate.0)
    }

    /// The sum with the slack of `calibration`.
    pub(super) fn sum(&self, calibration: &StylusCalibration) -> AlarmSum {
        let StylusCalibration { slack_still, slack_moving, .. } = *calibration;
        let interval_s = interval_s(calibration);
        let config =
            DetectorConfig { interval_s, slack_still, slack_moving, ..self.config.detector };
        AlarmSum::new(&config, &self.readings, self.block_s)
    }

    /// Sets the slack: for each component and scene the least with which its sum alone keeps the interval in one half
    /// of the stretches, times one factor for the other half.
    pub(super) fn fit(&self, calibration: &mut StylusCalibration) {
        let shipped = [calibration.slack_still, calibration.slack_moving];
        let mut slack = [[STEP; COMPONENTS]; 2];
        let mut raised = true;
        while raised {
            [calibration.slack_still, calibration.slack_moving] = slack;
            let passes = self.passes(calibration);
            raised = false;
            for (slack, passes) in slack.as_flattened_mut().iter_mut().zip(passes.as_flattened()) {
                if *passes && *slack < MOST {
                    *slack *= STEP;
                    raised = true;
                }
            }
        }
        let sum = self.sum(calibration);
        let known = [false, true].map(|moving| {
            let enough = self.seconds(0, |block| block.moving == moving) >= LEAST_S
                && (!moving || calibration.gain.is_some());
            sum.decides(moving).map(|decides| decides && enough)
        });
        let known_slack: Scenes<f32> = core::array::from_fn(|scene| {
            core::array::from_fn(|i| match (known[scene][i], known[1 - scene][i]) {
                (true, _) => slack[scene][i],
                // A scene that was not recorded is as the other one at best.
                (false, true) => shipped[scene][i].max(slack[1 - scene][i]),
                (false, false) => shipped[scene][i],
            })
        });
        [calibration.slack_still, calibration.slack_moving] = known_slack;
        let mut factor = 1.0;
        while factor < MOST && self.alarms(calibration) > 0 {
            self.raise(calibration);
            factor *= STEP;
        }
    }

    /// Raises all slack that decides by one step.
    pub(super) fn raise(&self, calibration: &mut StylusCalibration) {
        let sum = self.sum(calibration);
        let StylusCalibration { slack_still, slack_moving, .. } = calibration;
        for (scene, decides) in [slack_still, slack_moving]
            .into_iter()
            .zip([false, true].map(|moving| sum.decides(moving)))
        {
            for (slack, decides) in scene.iter_mut().zip(decides) {
                *slack *= if decides { STEP } else { 1.0 };
            }
        }
    }

    /// Counts the alarms of the slack in the half that it was not taken from, and states what they promise.
    pub(super) fn judge(&self, calibration: &mut StylusCalibration) {
        if !self.decides() {
            return;
        }
        let (judged_s, alarms) = (f64::from(self.seconds(1, |_| true)), self.alarms(calibration));
        let evidence = &mut calibration.evidence;
        (evidence.judged_s, evidence.alarms) = (judged_s, alarms);
        evidence.interval_low_s = judged_s / poisson::interval(alarms, ONE_SIDED).1;
    }

    /// Time in a half that the blocks which count fill (s).
    fn seconds(&self, half: usize, counts: impl Fn(&&Block) -> bool) -> f32 {
        self.block_s * self.halves[half].iter().flatten().filter(counts).count() as f32
    }

    /// Whether the sum of each component alone passes the interval in the half that gives the slack.
    fn passes(&self, calibration: &StylusCalibration) -> Scenes<bool> {
        let (mut sum, interval_s) = (self.sum(calibration), interval_s(calibration));
        let mut passes = [[false; COMPONENTS]; 2];
        // Evidence of one scene shows nothing of the slack of the other.
        for scene in self.halves[0].iter().flat_map(|run| run.chunk_by(|a, b| a.moving == b.moving))
        {
            sum.reset();
            for block in scene {
                sum.step(block);
                let passes = &mut passes[usize::from(block.moving)];
                for (passes, evidence_s) in passes.iter_mut().zip(sum.evidence_s()) {
                    *passes |= evidence_s >= interval_s;
                }
            }
        }
        passes
    }

    /// Seconds with evidence beyond the interval in the half that judges.
    fn alarms(&self, calibration: &StylusCalibration) -> u64 {
        let mut sum = self.sum(calibration);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let second = ((1.0 / self.block_s) as usize).max(1);
        let mut alarms = 0;
        for run in &self.halves[1] {
            sum.reset();
            for second in run.chunks(second) {
                let highest = second.iter().map(|block| sum.step(block)).fold(0.0, f32::max);
                alarms += u64::from(highest >= 1.0);
            }
        }
        alarms
    }
}

#[expect(clippy::cast_possible_truncation, reason = "1 to 1e9")]
fn interval_s(calibration: &StylusCalibration) -> f32 {
    calibration.evidence.wanted_interval_s as f32
}
