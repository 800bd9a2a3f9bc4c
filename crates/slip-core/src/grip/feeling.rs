//! What a slip feels like to the controller: by the stylus alone, pads that give way, objects that slide.

use super::{
    GripConfig, GripInput, Sliding,
    response::{LEAST_TAUS, SLIDES_ON_M},
};
use crate::{estimate::KAPPA, need::Felt};

/// What is aimed at over the median and over the lower quantile of the needed force.
const OVER_MEDIAN: f32 = 1.35;
const OVER_LOW: f32 = 1.45;
/// The target rises by e in this time (s) at most ...
const RISE_S: f32 = 0.003;
/// ... and not further over the measured force than by this share and this much (N).
const AHEAD: f32 = 1.7;
const AHEAD_N: f32 = 0.3;
/// Soon after a stop it rises at once by this much only: pads swing. Then by this logarithm with each peak that passes, the first two left out,
/// and by e in this time (s), since a surface may be too smooth to count peaks.
const AGAIN: f32 = 1.3;
const AGAIN_TURN: f32 = 0.15;
const AGAIN_TURNS: f32 = 2.0;
const AGAIN_S: f32 = 0.1;
/// It falls by e in this time (s).
const FALL_S: f32 = 0.03;
/// An object that has not stopped under this much more than the median, so long (s) after the alarm, is heavier than thought ...
const DONE: f32 = 1.1;
const DONE_S: f32 = 0.006;
/// ... by e in this time (s); in that one where no candidate explains what is felt ...
const DOUBT_S: f32 = 0.4;
const UNEXPLAINED_S: f32 = 0.03;
/// ... and by no more than this with each peak and valley that passes: what only shakes passes none.
const DOUBT: f32 = 0.02;
/// What slipped at a force is held with this much more at least.
const LEAST: f32 = 1.05;

/// Memory of a slip that only the stylus feels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Feeling {
    /// Force to hold with (N), once the object has stopped.
    held_n: Option<f32>,
    /// Logarithm of what the object is heavier by than thought, by time and by turns; turns so far.
    doubt: f32,
    doubt_turns: f32,
    turns: f32,
    /// For how long it has moved (s).
    moved_s: f32,
}

/// Forces of one finger (N).
#[derive(Clone, Copy, Debug)]
pub(super) struct Forces {
    /// The target so far.
    pub(super) target_n: f32,
    /// Measured, or commanded where it is not.
    pub(super) applied_n: f32,
    /// What the object was to be held with before the slip.
    pub(super) hold_n: f32,
}

impl Feeling {
    /// Force to hold with (N), once the object has stopped.
    pub(super) fn held_n(&self) -> Option<f32> {
        self.held_n
    }

    /// Peaks and valleys that have passed.
    pub(super) fn turns(&self) -> f32 {
        self.turns
    }

    /// For how long it has moved (s).
    pub(super) fn moved_s(&self) -> f32 {
        self.moved_s
    }

    /// The next target (N) after that of `forces`. It goes up as far as the lower
    /// quantile allows, which is low at first and runs away only where the stylus shows that the object is heavy; down slowly while the object moves; and
    /// to the balance of impulse once it stands. `dt_s` and `rise_s`: time since the sample before, and time for which the force may rise.
    pub(super) fn target_n(
        &mut self,
        config: &GripConfig,
        felt: &Felt,
        forces: Forces,
        dt_s: f32,
        rise_s: f32,
    ) -> f32 {
        let Forces { target_n, applied_n, hold_n } = forces;
        if !felt.moves {
            let Some(held_n) = felt.held_n else { return target_n };
            // Pads that swing show nothing new.
            let least_n = if felt.swung { hold_n.min(felt.from_n) } else { LEAST * felt.from_n };
            let held_n = (KAPPA * held_n).max(least_n).min(target_n);
            self.held_n = Some(held_n);
            return held_n;
        }
        self.held_n = None;
        let passed = (felt.turns - self.turns).max(0.0);
        self.turns = felt.turns;
        let done = applied_n > DONE * felt.median_n && felt.since_s > DONE_S && felt.vibrates;
        if done || felt.unexplained {
            let tau_s = if felt.unexplained { UNEXPLAINED_S } else { DOUBT_S };
            self.doubt += rise_s / tau_s;
            self.doubt_turns += DOUBT * passed;
        }
        if !felt.vibrates {
            return target_n;
        }
        self.moved_s += rise_s;
        // A surface too smooth to count peaks has none to wait for.
        let doubt = if felt.turns > 0.0 { self.doubt.min(self.doubt_turns) } else { self.doubt };
        let heavier = libm::expf(doubt);
        let wanted_n = heavier * (OVER_MEDIAN * felt.median_n).min(OVER_LOW * felt.low_n);
        let quickly_n = (target_n * (1.0 + rise_s / RISE_S)).max(felt.first * felt.from_n);
        let most_n = quickly_n.min((AHEAD * applied_n + AHEAD_N).max(target_n));
        let most_n = most_n.min(again_most_n(felt).max(target_n));
        let least_n = target_n * (1.0 - (dt_s / FALL_S).min(1.0));
        // The least answer to an object that slides on, whatever is believed of it.
        let on = self.moved_s / (1e-3 * LEAST_TAUS * config.measured_tau_ms);
        let on = if felt.turns > 0.0 { on.min(DOUBT * felt.turns) } else { on };
        let slides_n = felt.from_n * libm::expf(on);
        wanted_n.min(most_n).max(least_n).max(slides_n).min(config.ceiling_n())
    }
}

/// The most (N) that is answered to what moves soon after a stop; it may be the pads.
fn again_most_n(felt: &Felt) -> f32 {
    if !felt.again {
        return f32::INFINITY;
    }
    let passed = (felt.turns - AGAIN_TURNS).max(0.0);
    AGAIN * felt.from_n * libm::expf(AGAIN_TURN * passed + felt.since_s / AGAIN_S)
}

// Classifier of the motion of an object held with what it is known to need: it slides, or the pads give way as the load comes.

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

// Limit of what an estimate may ask for while pads may be giving way, by how the object slides.

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
///
/// The estimate F / (1 - a/g) takes the grip force F for the one that brakes the object. Pads brake as far as they have sheared,
///
/// ```text
/// F_e' = kappa v (1 - F_e / F),   kappa = shear stiffness / friction   (Dahl)
/// ```
///
/// so on soft ones the acceleration does not answer the force at first. The estimate then grows with the force, and the force with the
/// estimate. An object that no longer gets faster has what it needs for now: from there on more counts as far as it can act, which the
/// object shows by slowing down or by moving on, since F_e grows by kappa x at most. While it gets faster nothing is limited.
///
/// The share and the two stiffnesses are a compromise, found with pads of 10 to 100 N/mm: the less counts, the fewer objects are crushed on soft
/// pads, and the further they slip on stiff ones while their load still comes.
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
    use super::{Feeling, Forces};
    use crate::{grip::GripConfig, need::Felt};

    const DT_S: f32 = 1e-4;

    fn forces(target_n: f32, hold_n: f32) -> Forces {
        Forces { target_n, applied_n: target_n, hold_n }
    }

    fn moving(low_n: f32, median_n: f32) -> Felt {
        Felt {
            moves: true,
            from_n: 1.2,
            first: 1.4,
            since_s: 0.003,
            low_n,
            median_n,
            vibrates: true,
            ..Felt::default()
        }
    }

    #[test]
    fn the_lower_quantile_bounds_the_target_and_the_median_ends_it() {
        let config = GripConfig::default();
        for (low_n, median_n, wanted_n) in [(2.0, 8.0, 2.9), (9.0, 10.0, 13.05), (9.9, 10.0, 13.5)]
        {
            let (mut feeling, mut target_n) = (Feeling::default(), 1.2);
            for _ in 0..300 {
                target_n = feeling.target_n(
                    &config,
                    &moving(low_n, median_n),
                    forces(target_n, 1.2),
                    DT_S,
                    DT_S,
                );
            }
            assert!((target_n - wanted_n).abs() < 0.01, "{target_n} of {wanted_n}");
        }
    }

    #[test]
    fn a_stop_leads_to_the_balance_and_a_swing_of_the_pads_to_what_it_was() {
        let config = GripConfig::default();
        let stopped = Felt { moves: false, held_n: Some(8.0), ..moving(9.0, 9.0) };
        let mut feeling = Feeling::default();
        let target_n = feeling.target_n(&config, &stopped, forces(14.0, 1.2), DT_S, DT_S);
        assert!((target_n - 9.6).abs() < 1e-5 && feeling.held_n() == Some(target_n));
        let swung = Felt { from_n: 9.6, swung: true, ..stopped };
        assert!(
            (feeling.target_n(&config, &swung, forces(11.0, 9.6), DT_S, DT_S) - 9.6).abs() < 1e-5
        );
        let slipped = Felt { from_n: 9.6, ..stopped };
        let again_n = feeling.target_n(&config, &slipped, forces(11.0, 9.6), DT_S, DT_S);
        assert!((again_n - 10.08).abs() < 1e-5, "{again_n}");
    }

    #[test]
    fn what_moves_soon_after_a_stop_is_answered_by_peaks_and_time() {
        let config = GripConfig::default();
        let target_n = |again, turns, since_s| {
            let felt = Felt { from_n: 8.0, again, turns, since_s, ..moving(40.0, 60.0) };
            let (mut feeling, mut target_n) = (Feeling::default(), 8.0);
            for _ in 0..300 {
                let forces = forces(target_n, 8.0);
                target_n = feeling.target_n(&config, &felt, forces, DT_S, DT_S);
            }
            target_n
        };
        assert!((target_n(false, 0.0, 0.003) - 58.0).abs() < 0.1, "the first slip");
        assert!((target_n(true, 2.0, 0.003) - 10.7).abs() < 0.1, "pads that swing");
        assert!((target_n(true, 10.0, 0.003) - 35.6).abs() < 0.2, "it slides");
        assert!((target_n(true, 0.0, 0.2) - 58.0).abs() < 0.1, "a surface without peaks");
    }

    #[test]
    fn what_shakes_without_passing_peaks_does_not_raise_the_force_for_ever() {
        let config = GripConfig::default();
        let (mut feeling, mut target_n) = (Feeling::default(), 9.0);
        let shaken = Felt { turns: 3.0, since_s: 0.5, unexplained: true, ..moving(5.0, 5.0) };
        for _ in 0..100_000 {
            target_n = feeling.target_n(&config, &shaken, forces(target_n, 9.0), DT_S, DT_S);
        }
        assert!(target_n < 8.0, "{target_n}");
        for i in 0..10_000_u16 {
            let slides = Felt { turns: 3.0 + 0.05 * f32::from(i), ..shaken };
            target_n = feeling.target_n(&config, &slides, forces(target_n, 9.0), DT_S, DT_S);
        }
        assert!(target_n >= 59.0, "500 peaks: it slides, {target_n}");
    }
}

#[cfg(test)]
mod yielding_tests {
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
        assert!(yielding.most_n(None, 2e-4) < 6.0, "nothing new");
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
