//! Controller with one constant force.

use super::ForceLaw;
use slip_core::Sample;

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

impl ForceLaw for Fixed {
    fn learn(&mut self, _sample: &Sample) {}

    fn force_n(&mut self, _sample: &Sample) -> f64 {
        self.force_n
    }

    fn slips(&self) -> u64 {
        0
    }
}
