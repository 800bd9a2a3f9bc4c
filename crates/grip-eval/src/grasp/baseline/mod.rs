//! Older grip force controllers, for comparison with gripd on samples of the same gripper.
//!
//! | law | idea | published as |
//! |---|---|---|
//! | [`Fixed`] | one force for everything | what a gripper without slip sensor is set to; VDI 2740 sizes it by the heaviest load |
//! | [`Pr2`] | each slip raises the force by 8 % | J. M. Romano, K. Hsiao, G. Niemeyer, S. Chitta, K. J. Kuchenbecker, "Human-inspired robotic grasp control with tactile sensing", IEEE Trans. Robotics 27(6), 2011 |
//! | [`Fft`] | a block of vibration in the slip band raises the force by a step | E. G. M. Holweg, H. Hoeve, W. Jongkind, L. Marconi, C. Melchiorri, C. Bonivento, "Slip detection by tactile sensors: algorithms and experimental results", ICRA 1996 |
//! | [`Oracle`] | 1.3 times the largest load over friction, from the first sample of the slip on | no law but a bound: it knows mass, friction, every load to come and where the slip begins; the factor is a usual safety margin (R. S. Johansson, G. Westling, Exp. Brain Research 56, 1984) |
//!
//! All wait with open fingers for 0.2 s, as gripd does while it learns the noise of the stylus; their thresholds come from that noise.
//! What is said of each law beyond its idea is ours, and chosen in its favour.

mod fft;
mod fixed;
mod hand;
mod oracle;
mod pr2;

pub(super) use fft::Fft;
pub(super) use fixed::Fixed;
pub(super) use hand::Baseline;
pub(super) use oracle::Oracle;
pub(super) use pr2::Pr2;

use grip_sim::Truth;
use slip_core::Sample;

/// A law of grip force.
pub(super) trait ForceLaw {
    /// Takes a sample of the stylus in the air.
    fn learn(&mut self, sample: &Sample);

    /// The force to command after this sample (N).
    fn force_n(&mut self, sample: &Sample) -> f64;

    /// Takes the truth behind the samples, before they arrive; only a law that cannot be built looks at it.
    fn witness(&mut self, _truth: &Truth) {}

    /// Slips that were noticed.
    fn slips(&self) -> u64;
}

/// Wait after the trial force stands, while the stylus still rings from the touch (s).
const SETTLE_S: f64 = 0.05;

/// Knows when the touch is over: the measured force has stood near the trial force for a while.
#[derive(Clone, Copy, Debug, Default)]
struct Touch {
    standing_s: f64,
}

impl Touch {
    /// Whether the fingers press with `trial_n` since long enough, after another sample.
    fn is_over(&mut self, sample: &Sample, trial_n: f64, period_s: f64) -> bool {
        let presses = sample.normal_force_n.is_none_or(|force| f64::from(force) > 0.8 * trial_n);
        if self.standing_s < SETTLE_S {
            self.standing_s = if presses { self.standing_s + period_s } else { 0.0 };
        }
        self.standing_s >= SETTLE_S
    }
}
