//! Controller that raises the force by a share with every slip in the high-passed stylus (Romano et al. 2011).
//!
//! Slip is where the vibration exceeds a threshold that grows with the grip force; the force is then multiplied by 1.08 and never falls.
//! The published gripper reads its pads at 24 Hz; here the law decides every [`STEP_S`], which is what a fast sensor would allow.

use super::{ForceLaw, Touch};
use core::f64::consts::TAU;
use slip_core::Sample;

/// Growth of the force by a slip, as published.
const GROWTH: f64 = 1.08;
/// Corner of the high-pass (Hz), as published.
const CORNER_HZ: f64 = 5.0;
/// Time between two decisions (s).
const STEP_S: f64 = 5e-3;
/// Threshold at the trial force over the largest reading in the air.
const MARGIN: f64 = 1.5;

/// The law of the PR2's gripper.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pr2 {
    trial_n: f64,
    period_s: f64,
    share: f64,
    mean: Option<f64>,
    /// Largest high-passed reading in the air (m).
    rest_m: f64,
    touch: Touch,
    held: bool,
    force_n: f64,
    /// A slip was seen since the last decision, and at it.
    felt: bool,
    slipping: bool,
    since_s: f64,
    slips: u64,
}

impl Pr2 {
    pub(crate) fn new(trial_n: f64, rate_hz: f64) -> Self {
        Self {
            trial_n,
            period_s: 1.0 / rate_hz,
            share: -(-TAU * CORNER_HZ / rate_hz).exp_m1(),
            mean: None,
            rest_m: 0.0,
            touch: Touch::default(),
            held: false,
            force_n: trial_n,
            felt: false,
            slipping: false,
            since_s: 0.0,
            slips: 0,
        }
    }

    fn high_passed(&mut self, sample: &Sample) -> f64 {
        let x = f64::from(sample.stylus);
        if x.is_nan() {
            return 0.0;
        }
        let mean = self.mean.get_or_insert(x);
        let apart = x - *mean;
        *mean += self.share * apart;
        apart.abs()
    }
}

impl ForceLaw for Pr2 {
    fn learn(&mut self, sample: &Sample) {
        self.rest_m = self.high_passed(sample).max(self.rest_m);
    }

    fn force_n(&mut self, sample: &Sample) -> f64 {
        if !self.touch.is_over(sample, self.trial_n, self.period_s) {
            return self.force_n;
        }
        if !self.held {
            // The touch pushed the stylus in.
            self.held = true;
            self.mean = None;
        }
        let threshold = MARGIN * self.rest_m * self.force_n / self.trial_n;
        self.felt |= self.high_passed(sample) > threshold;
        self.since_s += self.period_s;
        if self.since_s >= STEP_S {
            self.slips += u64::from(self.felt && !self.slipping);
            self.force_n *= if self.felt { GROWTH } else { 1.0 };
            (self.slipping, self.felt, self.since_s) = (self.felt, false, 0.0);
        }
        self.force_n
    }

    fn slips(&self) -> u64 {
        self.slips
    }
}
