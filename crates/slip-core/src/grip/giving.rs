//! How an object moves that is held with what it is known to need in; whether it slides, or the pads give way as the load comes, out.

use super::{GripInput, braking::SLIDES_ON_M};

/// Peaks and valleys that pass where it slides: pads give way by fewer.
const PASSED: f32 = 8.0;
/// What slides without slowing down after this long (s) does not stop by itself.
const SLIDES_ON_S: f32 = 0.01;
/// What the stylus feels move for this long (s), and has no peaks to count, is no pad that gives way.
pub(super) const FELT_ON_S: f32 = 0.04;

/// Memory of one slip.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Giving {
    slid: bool,
    /// For how long the stylus has felt it move without peaks to count (s).
    felt_s: f32,
}

impl Giving {
    /// Whether it has moved further than pads give way.
    pub(super) fn has_slid(self) -> bool {
        self.slid
    }

    /// Takes what is new after `dt_s`: how far it has moved (m) at most, the peaks and valleys that have passed, and for how long (s) it slides
    /// without slowing down, if it does.
    pub(super) fn follow(
        &mut self,
        input: &GripInput,
        furthest_m: f32,
        turns: f32,
        slides_s: Option<f32>,
        dt_s: f32,
    ) {
        // A vibration and a smooth surface have no peaks to count.
        let felt = input.felt.is_some_and(|felt| felt.moves && felt.turns <= 0.0);
        self.felt_s = if felt { self.felt_s + dt_s } else { 0.0 };
        let unmeasured = input.moved_m.is_none() && input.felt.is_none();
        let on = slides_s.is_some_and(|s| s >= SLIDES_ON_S) || self.felt_s >= FELT_ON_S;
        let far = furthest_m >= SLIDES_ON_M || turns >= PASSED;
        self.slid |= unmeasured || on || far;
    }
}
