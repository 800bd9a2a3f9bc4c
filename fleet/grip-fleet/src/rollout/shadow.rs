//! Test of whether the second of two models would ask for far too little or too much, by what both made of slips and what the grasps later showed.
//!
//! A grasp counts once, with its first slip that either model had an estimate of. The object slipped last at a force that is too little, and was
//! held at the end with one that is enough. The model in force shows what lies between. The second model is
//!
//! - too low, where it asks for less than the force of the last slip and the model in force does not; or for less than the model in force over
//!   [`KAPPA`], which is the margin that all are trained with, and less than what held the object;
//! - too high, where it asks for more than [`ShadowConfig::most`] times what the model in force asks for, and for over-force
//!   ([`Grasp::OVER_FORCE`]);
//! - too unsure, where it has no answer and the model in force has one.
//!
//! One such grasp in ten is borne, half of them are not. Bets on that are e-values: they reach `3 / alpha` with a probability of `alpha / 3` at most
//! where no more than one of ten is wrong, however often one looks.

use super::Grasp;
use core::fmt;
use serde::{Deserialize, Serialize};
use slip_core::estimate::KAPPA;

/// Share of the grasps that may be wrong in one way, and share that is to be noticed.
const BORNE: f64 = 0.1;
const NOTICED: f64 = 0.5;
/// Grasps of a shadow stage, at most.
const MOST: usize = 500;

/// What two models made of a slip of a grasp, and what the grasp later showed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compared {
    /// Force that the model in force asked for (N); `None` where it had no answer that may move fingers.
    pub in_force_n: Option<f32>,
    /// The same of the shadow model.
    pub shadow_n: Option<f32>,
    /// Commanded force at which the object slipped last (N).
    pub slipped_n: f32,
    /// Force that held it at the end (N); `None` where it was lost, or the hold was not seen.
    pub held_n: Option<f32>,
}

impl Compared {
    /// Whether a gripper can have measured that.
    #[must_use]
    pub fn is_sane(&self) -> bool {
        let measured = |force_n: f32| (0.0..=1e6).contains(&force_n);
        let forces = [self.in_force_n, self.shadow_n, Some(self.slipped_n), self.held_n];
        forces.into_iter().flatten().all(measured)
    }

    /// How the shadow model was wrong, if it was; with `most` of [`ShadowConfig`].
    #[must_use]
    pub fn wrong(&self, most: f32) -> Option<Wrong> {
        let Some(shadow_n) = self.shadow_n else { return self.in_force_n.map(|_| Wrong::Unsure) };
        let little = self.in_force_n.is_some_and(|force_n| KAPPA * shadow_n < force_n)
            && self.held_n.is_none_or(|force_n| shadow_n < force_n);
        let much = self.in_force_n.is_none_or(|force_n| shadow_n > most * force_n)
            && shadow_n > Grasp::OVER_FORCE * self.slipped_n;
        // Where both ask for less than the force of the last slip, that is no difference between them.
        let is_short = |force_n: f32| force_n < self.slipped_n;
        if is_short(shadow_n) && !self.in_force_n.is_some_and(is_short) || little {
            Some(Wrong::Low)
        } else {
            much.then_some(Wrong::High)
        }
    }
}

slip_core::named! {
    /// How a shadow model was wrong.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Wrong {
        fn sentence: "It in words.";
    }
    Low: "It asked for less than the object was shown to need.", "it asks for less force than the objects need";
    High: "It asked for over-force.", "it asks for too much force";
    Unsure: "It had no answer where the model in force had one.", "it is too unsure to answer where the model in force has an answer";
}

/// When a shadow model is stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowConfig {
    /// Probability of ever stopping a model that is wrong in no more than one grasp of ten, in each way.
    pub alpha: f64,
    /// Force over that of the model in force that is too much where it is over-force too.
    pub most: f32,
}

impl ShadowConfig {
    /// Grasps after which a model that is wrong in half of them has been noticed in nine of ten shadow stages: computed, not drawn.
    #[must_use]
    pub fn needed(&self) -> usize {
        // Shares of stages that go on after n grasps, by the number of wrong ones.
        let mut going = vec![1.0_f64];
        for n in 1..=MOST {
            let mut next = vec![0.0; n + 1];
            for (wrong, share) in going.iter().enumerate() {
                for (more, chance) in [(1, NOTICED), (0, 1.0 - NOTICED)] {
                    let is_over = self.is_enough(wrong + more, n);
                    if let Some(place) = next.get_mut(wrong + more).filter(|_| !is_over) {
                        *place += share * chance;
                    }
                }
            }
            if next.iter().sum::<f64>() <= 0.1 {
                return n;
            }
            going = next;
        }
        MOST
    }

    /// Whether so many wrong ones of `all` are evidence enough.
    fn is_enough(&self, wrong: usize, all: usize) -> bool {
        let (wrong, right) = (wrong as f64, all.saturating_sub(wrong) as f64);
        let bet = wrong * (NOTICED / BORNE).ln() + right * ((1.0 - NOTICED) / (1.0 - BORNE)).ln();
        bet >= (3.0 / self.alpha).ln()
    }
}

/// Grasps that were compared, and how many were wrong in which way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Grasps that were compared.
    pub grasps: usize,
    /// Those of them in which it asked for too little.
    pub low: usize,
    /// Those in which it asked for too much.
    pub high: usize,
    /// Those in which it had no answer.
    pub unsure: usize,
}

impl Tally {
    /// Takes one more grasp; one in which nothing was compared changes nothing. How the model is wrong, as soon as that is evident.
    pub fn take(&mut self, grasp: &Grasp, config: &ShadowConfig) -> Option<Wrong> {
        let compared = grasp.compared?;
        self.grasps += 1;
        let wrong = compared.wrong(config.most)?;
        let count = match wrong {
            Wrong::Low => &mut self.low,
            Wrong::High => &mut self.high,
            Wrong::Unsure => &mut self.unsure,
        };
        *count += 1;
        let (count, grasps) = (*count, self.grasps);
        config.is_enough(count, grasps).then_some(wrong)
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { grasps, low, high, unsure } = self;
        write!(
            f,
            "{grasps} grasps compared: too little in {low}, too much in {high}, no answer in {unsure}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{Compared, Grasp, ShadowConfig, Tally, Wrong};
    use crate::rollout::judge::Draws;

    const CONFIG: ShadowConfig = ShadowConfig { alpha: 0.05, most: 1.5 };

    fn compared(in_force_n: f32, shadow_n: f32, slipped_n: f32, held_n: f32) -> Compared {
        let (in_force_n, shadow_n) = (Some(in_force_n), Some(shadow_n));
        Compared { in_force_n, shadow_n, slipped_n, held_n: Some(held_n) }
    }

    #[test]
    fn what_the_grasp_showed_stands_over_what_the_model_in_force_asked_for() {
        for (made, wanted) in [
            // The same, a little less, a little more.
            (compared(6.0, 6.0, 3.0, 6.0), None),
            (compared(6.0, 5.4, 3.0, 6.0), None),
            (compared(6.0, 8.9, 3.0, 6.0), None),
            // Less than the margin leaves, and less than what it slipped at.
            (compared(6.0, 4.5, 3.0, 6.0), Some(Wrong::Low)),
            (compared(7.0, 5.9, 6.5, 9.0), Some(Wrong::Low)),
            // Both were too little at first.
            (compared(6.0, 5.9, 6.5, 9.0), None),
            // The model in force asks for too much: half of that has held it.
            (compared(6.0, 3.0, 2.0, 3.0), None),
            // Five times as much; and where the model in force asks for too little, as the grasp showed.
            (compared(6.0, 30.0, 3.0, 6.0), Some(Wrong::High)),
            (compared(1.0, 5.0, 4.0, 6.0), None),
            // No answer of one of them.
            (Compared { shadow_n: None, ..compared(6.0, 0.0, 3.0, 6.0) }, Some(Wrong::Unsure)),
            (Compared { in_force_n: None, ..compared(0.0, 6.0, 3.0, 6.0) }, None),
            (Compared { in_force_n: None, ..compared(0.0, 9.0, 3.0, 6.0) }, Some(Wrong::High)),
        ] {
            assert_eq!(made.wrong(CONFIG.most), wanted, "{made:?}");
        }
    }

    fn stage(state: &mut Draws, chance: f64, grasps: usize) -> Option<Wrong> {
        let mut tally = Tally::default();
        (0..grasps).find_map(|_| {
            let force_n = if state.share() < chance { 30.0 } else { 6.0 };
            let compared = Some(compared(6.0, force_n, 3.0, 6.0));
            tally.take(&Grasp { compared, ..Grasp::default() }, &CONFIG)
        })
    }

    #[test]
    fn the_number_of_grasps_notices_what_is_wrong_in_half_of_them_and_bears_one_in_ten() {
        let needed = CONFIG.needed();
        assert!((10..30).contains(&needed), "{needed}");
        let mut state = Draws(4711);
        let stopped = |state: &mut Draws, chance| {
            (0..1000).filter(|_| stage(state, chance, needed).is_some()).count()
        };
        let (half, tenth) = (stopped(&mut state, 0.5), stopped(&mut state, 0.1));
        assert!(half >= 880 && tenth <= 25, "{half} {tenth}");
        assert_eq!(stage(&mut state, 1.0, 3), Some(Wrong::High), "three in a row are enough");
        assert_eq!(stage(&mut state, 0.0, 500), None);
        let mut tally = Tally::default();
        assert_eq!(tally.take(&Grasp::default(), &CONFIG), None, "nothing was compared");
        assert_eq!(tally, Tally::default());
    }

    #[test]
    fn forces_that_nobody_can_have_measured_are_none() {
        assert!(compared(1.0, 1.0, 1.0, 1.0).is_sane());
        for made in [
            compared(f32::NAN, 1.0, 1.0, 1.0),
            compared(1.0, -1.0, 1.0, 1.0),
            compared(1.0, 1.0, f32::INFINITY, 1.0),
        ] {
            assert!(!made.is_sane(), "{made:?}");
        }
    }
}
