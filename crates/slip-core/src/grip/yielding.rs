//! How an object slides in; how much an estimate may ask for while pads may be giving way out.
//!
//! The estimate F / (1 - a/g) takes the grip force F for the one that brakes the object. Pads brake as far as they have sheared,
//!
//! ```text
//! F_e' = kappa v (1 - F_e / F),   kappa = shear stiffness / friction   (Dahl)
//! ```
//!
//! so on soft ones the acceleration does not answer the force at first. The estimate then grows with the force, and the force with the
//! estimate. An object that no longer gets faster has what it needs for now: from there on more counts as far as it can act, which the
//! object shows by slowing down or by moving on, since F_e grows by kappa x at most. While it gets faster nothing is limited.
//!
//! The share and the two stiffnesses are a compromise, found with pads of 10 to 100 N/mm: the less counts, the fewer objects are crushed on soft
//! pads, and the further they slip on stiff ones while their load still comes.

use super::Sliding;

/// What gets faster by more than this (g) needs more; less is the noise of an acceleration over 4 ms.
const FASTER_G: f32 = 0.03;
/// The margin of an estimate, and an eighth for the load that comes until the object gets faster again and that is seen.
const MARGIN: f32 = 1.35;
/// An object that slows down by this (g) feels the force ...
const SLOWS_G: f32 = 0.16;
/// ... so that up to this share of it more counts: slowing down that hard it stops within some milliseconds.
const SLOWING: f32 = 0.7;
/// What the shear of soft pads adds with the distance (N/m): 5 N/mm over a friction of 0.4.
const SHEARS_N_M: f32 = 12e3;
/// ... and so much there is by then.
const SHEARED_N_M: f32 = 25e3;

/// Memory of one slip.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Yielding {
    /// The force (N) under which the object stopped getting faster, and where that was (m).
    enough: Option<(f32, f32)>,
}

impl Yielding {
    /// What an estimate may ask for at most (N) where the object has moved by `moved_m`.
    pub(super) fn most_n(&mut self, sliding: Option<&Sliding>, moved_m: f32) -> f32 {
        let slows_g = sliding.map_or(0.0, |sliding| -sliding.acceleration_g);
        if let Some(sliding) = sliding {
            if slows_g >= 0.0 {
                self.enough = self.enough.or(Some((sliding.force_n, moved_m)));
            } else if slows_g <= -FASTER_G {
                self.enough = None;
            }
        }
        let slowing = slows_g.max(0.0) / SLOWS_G;
        self.enough.map_or(f32::INFINITY, |(force_n, from_m)| {
            let sheared_n = SHEARS_N_M * (moved_m - from_m).max(0.0);
            let braked_n = force_n * (MARGIN + (slowing * slowing).min(SLOWING)) + sheared_n;
            braked_n.max(SHEARED_N_M * moved_m)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Sliding, Yielding};

    fn sliding(force_n: f32, acceleration_g: f32) -> Sliding {
        Sliding { force_n, acceleration_g }
    }

    #[test]
    fn an_object_that_gets_faster_needs_more_whatever_there_is() {
        let mut yielding = Yielding::default();
        assert_eq!(yielding.most_n(Some(&sliding(3.0, 0.1)), 1e-4), f32::INFINITY);
        assert!(yielding.most_n(Some(&sliding(4.0, 0.0)), 2e-4) < 6.0);
        assert!(yielding.most_n(Some(&sliding(8.0, 0.02)), 2e-4) < 6.0, "noise");
        assert!(yielding.most_n(None, 2e-4) < 6.0, "no news");
        assert_eq!(yielding.most_n(Some(&sliding(8.0, 0.04)), 2e-4), f32::INFINITY);
    }

    #[test]
    fn more_counts_where_the_object_slows_down_or_has_moved_on() {
        let mut yielding = Yielding::default();
        let first_n = yielding.most_n(Some(&sliding(4.0, 0.0)), 5e-5);
        let slow_n = yielding.most_n(Some(&sliding(4.0, -0.05)), 5e-5);
        let hard_n = yielding.most_n(Some(&sliding(4.0, -0.5)), 5e-5);
        let on_n = yielding.most_n(Some(&sliding(4.0, 0.0)), 1.5e-4);
        let far_n = yielding.most_n(Some(&sliding(4.0, 0.0)), 1e-3);
        assert!(slow_n < 1.1 * first_n && hard_n > 1.5 * first_n && hard_n < 9.0);
        assert!((on_n - first_n - 1.2).abs() < 0.01, "{on_n} {first_n}");
        assert!((far_n - 25.0).abs() < 0.01, "{far_n}");
    }
}
