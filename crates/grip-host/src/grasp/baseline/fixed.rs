//! Nothing in, always the same force out; or the tangential force in, and what friction calls for out.

use super::ForceLaw;
use grip_sim::scene::Object;
use slip_core::Sample;

/// Force of the oracle over the needed one.
const SAFETY: f64 = 1.1;

/// The same force from the touch on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fixed {
    force_n: f64,
}

impl Fixed {
    /// What holds most of the objects of the built-in scenes without crushing the egg (N).
    pub(crate) const USUAL_N: f64 = 20.0;

    pub(crate) fn new(force_n: f64) -> Self {
        Self { force_n }
    }
}

/// 1.1 times the force that the load of an object needs. It knows mass and dry friction, and nothing of what happens later; where the tangential
/// force is measured, it follows that upwards as well.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Oracle {
    weight_n: f64,
    friction: f64,
    /// Tangential force of a finger, smoothed (N).
    load_n: f64,
}

impl Oracle {
    /// Share of the way to a new reading: 1 ms at 10 kHz.
    const SHARE: f64 = 0.1;

    pub(crate) fn new(object: &Object) -> Self {
        Self { weight_n: object.force_needed_n(), friction: object.friction, load_n: 0.0 }
    }
}

impl ForceLaw for Oracle {
    fn learn(&mut self, _sample: &Sample) {}

    fn force_n(&mut self, sample: &Sample) -> f64 {
        if let Some(tangential_n) = sample.tangential_n.filter(|force| force.is_finite()) {
            self.load_n += Self::SHARE * (f64::from(tangential_n) - self.load_n);
        }
        SAFETY * self.weight_n.max(self.load_n / self.friction)
    }

    fn slips(&self) -> u64 {
        0
    }
}

impl ForceLaw for Fixed {
    fn learn(&mut self, _sample: &Sample) {}

    fn force_n(&mut self, _sample: &Sample) -> f64 {
        self.force_n
    }

    fn slips(&self) -> u64 {
        0
    }
}
