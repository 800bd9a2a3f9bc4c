//! Sequential test of grasps with the new model against those with the one of before: the evidence that the new one is worse.
//!
//! Each grasp with the new model is compared with `per` earlier grasps of the same gripper, which are used once. Where both models are
//! equal, each of the `per + 1` grasps is the worst of them with the same probability, whatever the grasps are like. A bet on that is an
//! e-value: it pays `w_j` where the new grasp has place `j` from the worst, with a mean of 1 over the places; equal grasps share the
//! mean of their places. The product over all grasps is a test martingale: it ever exceeds `1 / alpha` with a probability of at most
//! `alpha`, however often one looks (Ville; Shafer, J. R. Stat. Soc. A 184, 2021). Products of different bets, of different properties of
//! a grasp and of many grippers are averaged or multiplied and stay e-values.

use super::Grasp;

/// Bets: with exponent `s` place `j` of `m` pays `m ((j / m)^s - ((j - 1) / m)^s)`. The smaller, the more stands on the worst place.
const BETS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// Most earlier grasps that one grasp is compared with.
const MOST_PER: usize = 8;
/// Roll-outs that are drawn for a plan, and the most grasps of one.
const DRAWS: usize = 100;
/// A stage takes at most so many grasps.
pub const MOST_GRASPS: usize = 500;

/// When a model is worse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgeConfig {
    /// Probability of ever calling a model worse that is as good, in all, 1e-6 to 0.5.
    pub alpha: f64,
    /// What slips and force may grow by without being called worse, from 1.
    pub margin: f32,
}

impl Default for JudgeConfig {
    fn default() -> Self {
        Self { alpha: 0.05, margin: 1.2 }
    }
}

/// What a roll-out is to notice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Share of the grasps that are lost beside those that were lost before, above 0 to 1.
    pub lost: f64,
    /// Force over that of before, more than the margin.
    pub force: f32,
}

impl Default for Difference {
    /// One more of ten is lost, and half as much force again.
    fn default() -> Self {
        Self { lost: 0.1, force: 1.5 }
    }
}

slip_core::named! {
    /// What got worse.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Worse {
        fn sentence: "It in words.";
    }
    Hold: "More objects are lost, or they slip more often or further.", "objects are lost, or slip more often or further";
    Force: "They are held with more force than they were shown to need.", "objects are held with too much force";
}

/// Earlier grasps that each new one can be compared with, where there are `before` of them and up to `now` new ones are wanted.
#[must_use]
pub fn per(before: usize, now: usize) -> usize {
    (before / now.max(1)).clamp(1, MOST_PER)
}

/// Evidence that a model is worse, as e-values: 1 is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// That it holds worse.
    pub hold: f64,
    /// That it holds with too much force.
    pub force: f64,
    /// Grasps that were compared.
    pub grasps: usize,
}

/// A property of a grasp; more is worse. `None` where it was not measured.
type Property = fn(&Grasp) -> Option<f32>;
/// What stands for a hold that is worse, and for too much force; slips and forces are divided by the margin.
const HOLD: [(Property, bool); 3] = [
    (|grasp| Some(f32::from(u8::from(grasp.lost))), false),
    (|grasp| (!grasp.lost).then(|| float(grasp.regrasps)), true),
    (|grasp| Some(if grasp.lost { f32::INFINITY } else { grasp.slip_mm }), true),
];
const FORCE: [(Property, bool); 2] = [
    (|grasp| grasp.force_ratio.map(|_| f32::from(u8::from(grasp.over_force()))), false),
    (|grasp| grasp.force_ratio, true),
];

impl JudgeConfig {
    /// Whether the numbers are some.
    #[must_use]
    pub fn is_sane(&self) -> bool {
        (1e-6..=0.5).contains(&self.alpha) && (1.0..=100.0).contains(&self.margin)
    }

    /// Grasps with the new model after which each of the differences has been noticed in nine of ten roll-outs, where one gripper has made
    /// `each` grasps before: drawn from the grasps `before`, with a fixed seed. `None` where more than [`MOST_GRASPS`] are needed, or
    /// nothing is known of a force.
    #[must_use]
    pub fn needed(&self, before: &[Grasp], each: usize, difference: &Difference) -> Option<usize> {
        let lost = |grasp: &Grasp, chance: f64| Grasp {
            lost: grasp.lost || chance < difference.lost,
            ..*grasp
        };
        let pressed = |grasp: &Grasp, _: f64| Grasp {
            force_ratio: grasp.force_ratio.map(|ratio| ratio * difference.force),
            ..*grasp
        };
        let ladder = core::iter::successors(Some(10_usize), |n| Some(n + n / 4));
        ladder.take_while(|n| *n <= MOST_GRASPS).find(|n| {
            let per = per(each, *n);
            self.noticed(before, *n, per, &lost) && self.noticed(before, *n, per, &pressed)
        })
    }

    /// Whether grasps that are changed so are noticed in nine of ten draws.
    fn noticed(
        &self,
        before: &[Grasp],
        grasps: usize,
        per: usize,
        change: &dyn Fn(&Grasp, f64) -> Grasp,
    ) -> bool {
        let mut draws = Draws(4711);
        let run = |_: &usize| {
            let mut bets = Bets::default();
            (0..grasps).any(|_| {
                let now = change(&draws.of(before), draws.share());
                let others: Vec<Grasp> = (0..per).map(|_| draws.of(before)).collect();
                bets.compare(&now, &others, self.margin);
                self.judge(&bets.evidence()).is_some()
            })
        };
        (0..DRAWS).filter(run).count() * 10 >= DRAWS * 9
    }

    /// What is worse. Half of `alpha` is for the hold, half for the force.
    #[must_use]
    pub fn judge(&self, evidence: &Evidence) -> Option<Worse> {
        let enough = |e: f64| e >= 2.0 / self.alpha;
        if enough(evidence.hold) {
            Some(Worse::Hold)
        } else {
            enough(evidence.force).then_some(Worse::Force)
        }
    }
}

/// Bets on the grasps of one gripper, or of many: logarithms of what each bet on each property has made of 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bets {
    hold: [[f64; BETS.len()]; HOLD.len()],
    force: [[f64; BETS.len()]; FORCE.len()],
    grasps: usize,
}

impl Bets {
    /// One more grasp with the new model, and earlier ones of the same gripper that were not used before. Slips and forces are divided by
    /// `margin`.
    pub fn compare(&mut self, now: &Grasp, before: &[Grasp], margin: f32) {
        let (hold, force) = (HOLD.iter().zip(&mut self.hold), FORCE.iter().zip(&mut self.force));
        for ((property, with_margin), purses) in hold.chain(force) {
            let Some(value) = property(now) else { continue };
            let value = if *with_margin { value / margin } else { value };
            let known = before.iter().filter_map(property);
            let (mut worse, mut equal, mut all) = (0_u32, 0_u32, 1_u32);
            for other in known {
                let order = other.total_cmp(&value);
                worse += u32::from(order.is_gt());
                equal += u32::from(order.is_eq());
                all += 1;
            }
            let [first, last, all] = [worse, worse + equal + 1, all].map(f64::from);
            for (purse, bet) in purses.iter_mut().zip(BETS) {
                let pays = (last / all).powf(bet) - (first / all).powf(bet);
                *purse += (all * pays / (last - first)).ln();
            }
        }
        self.grasps += 1;
    }

    /// Those of another gripper too.
    pub fn add(&mut self, other: &Self) {
        let own = self.hold.as_flattened_mut().iter_mut().chain(self.force.as_flattened_mut());
        let others = other.hold.as_flattened().iter().chain(other.force.as_flattened());
        own.zip(others).for_each(|(own, other)| *own += other);
        self.grasps += other.grasps;
    }

    /// What they show.
    #[must_use]
    pub fn evidence(&self) -> Evidence {
        Evidence { hold: mean(&self.hold), force: mean(&self.force), grasps: self.grasps }
    }
}

/// The mean of what all bets on all properties have made of 1.
fn mean(purses: &[[f64; BETS.len()]]) -> f64 {
    let all = || purses.iter().flatten();
    let sum: f64 = all().map(|purse| purse.exp()).sum();
    sum / f64::from(u32::try_from(all().count()).unwrap_or(1))
}

fn float(count: u32) -> f32 {
    count as f32
}

/// Draws with a seed (Steele, Lea and Flood, OOPSLA 2014: SplitMix64).
#[derive(Clone, Copy, Debug)]
pub struct Draws(pub u64);

impl Draws {
    const fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    /// 0 to 1.
    pub fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One of some grasps; a grasp without anything where there is none.
    pub fn of(&mut self, grasps: &[Grasp]) -> Grasp {
        let place = usize::try_from(self.next() % grasps.len().max(1) as u64).unwrap_or(0);
        grasps.get(place).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::{Bets, Difference, Draws, JudgeConfig, Worse, per};
    use crate::rollout::Grasp;

    /// Grasps of which a share is lost, that slip by 0.2 to 1 mm and are held with 1 to 1.6 times what they need, and with `force` times that.
    fn grasps(draws: &mut Draws, count: usize, lost: f64, force: f32) -> Vec<Grasp> {
        let mut grasp = || {
            #[expect(clippy::cast_possible_truncation, reason = "made up")]
            let [slip_mm, ratio] =
                [0.2 + 0.8 * draws.share(), 1.0 + 0.6 * draws.share()].map(|x| x as f32);
            let regrasps = u32::from(draws.share() < 0.3) + 1;
            Grasp {
                lost: draws.share() < lost,
                regrasps,
                slip_mm,
                force_ratio: Some(force * ratio),
                compared: None,
            }
        };
        (0..count).map(|_| grasp()).collect()
    }

    /// Each grasp against the next `per` earlier ones.
    fn compared<'a>(
        judge: &JudgeConfig,
        before: &'a [Grasp],
        now: &'a [Grasp],
        per: usize,
    ) -> impl Iterator<Item = Bets> + use<'a> {
        let margin = judge.margin;
        now.iter().zip(before.chunks_exact(per)).scan(
            Bets::default(),
            move |bets, (now, before)| {
                bets.compare(now, before, margin);
                Some(*bets)
            },
        )
    }

    /// Looks after every grasp; after how many it was called worse, and how.
    fn first(
        judge: &JudgeConfig,
        before: &[Grasp],
        now: &[Grasp],
        per: usize,
    ) -> Option<(usize, Worse)> {
        compared(judge, before, now, per)
            .enumerate()
            .find_map(|(n, bets)| Some((n + 1, judge.judge(&bets.evidence())?)))
    }

    /// Looking after every grasp, with one to eight earlier grasps for each.
    #[test]
    fn equal_models_are_called_worse_in_five_of_a_hundred_roll_outs_at_most() {
        let judge = JudgeConfig { margin: 1.0, ..JudgeConfig::default() };
        for (per, lost) in [(1, 0.0), (1, 0.3), (4, 0.05), (8, 0.02)] {
            let mut draws = Draws(31 + per as u64);
            let wrong = (0..400).filter(|_| {
                let before = grasps(&mut draws, 100 * per, lost, 1.0);
                let now = grasps(&mut draws, 100, lost, 1.0);
                first(&judge, &before, &now, per).is_some()
            });
            let wrong = wrong.count();
            assert!(wrong <= 20, "{wrong} of 400 with {per}, {lost}");
        }
    }

    #[test]
    fn what_is_worse_is_noticed_and_called_by_its_name() {
        let judge = JudgeConfig::default();
        for (lost, force, what, most) in [(0.3, 1.0, Worse::Hold, 60), (0.0, 2.0, Worse::Force, 40)]
        {
            for seed in 0..20 {
                let mut draws = Draws(seed);
                let before = grasps(&mut draws, 400, 0.01, 1.0);
                let now = grasps(&mut draws, 100, lost, force);
                let (n, worse) = first(&judge, &before, &now, 4).unwrap();
                assert!(worse == what && n <= most, "{seed}: {worse:?} after {n}");
            }
        }
    }

    #[test]
    fn a_model_that_is_better_has_nothing_against_it() {
        let judge = JudgeConfig::default();
        let mut draws = Draws(5);
        let before = grasps(&mut draws, 400, 0.2, 1.5);
        let now = grasps(&mut draws, 200, 0.0, 1.0);
        assert_eq!(first(&judge, &before, &now, 2), None);
        let evidence = compared(&judge, &before, &now, 2).last().unwrap().evidence();
        assert!(evidence.hold < 1.0 && evidence.force < 1.0, "{evidence:?}");
    }

    /// The bet of one grasp against `per` others is fair: over all places it pays 1 in the mean.
    #[test]
    fn bets_are_fair_and_grippers_are_pooled() {
        let judge = JudgeConfig::default();
        let lost = Grasp { lost: true, ..Grasp::default() };
        let held = Grasp::default();
        for losses in 0..=4 {
            let all: Vec<Grasp> = (0..4).map(|n| if n < losses { lost } else { held }).collect();
            let pays = (0..4).map(|place| {
                let mut others = all.clone();
                let now = [others.remove(place)];
                compared(&judge, &others, &now, 3).last().unwrap().evidence().hold
            });
            let mean = pays.sum::<f64>() / 4.0;
            assert!((mean - 1.0).abs() < 1e-9, "{losses}: {mean}");
        }
        let (before, now) = ([held; 8], [lost; 20]);
        // Grasps without an earlier one to compare with show nothing.
        let one = compared(&judge, &before, &now, 4).last().unwrap();
        let mut two = one;
        two.add(&one);
        let [one, two] = [one, two].map(|bets| bets.evidence());
        assert!(two.hold > 2.0 * one.hold && (one.grasps, two.grasps) == (2, 4), "{one:?} {two:?}");
        assert_eq!(per(100, 50), 2);
        assert_eq!((per(10, 50), per(1000, 50), per(7, 0)), (1, 8, 7));
    }

    #[test]
    fn the_number_of_grasps_is_known_before() {
        let judge = JudgeConfig::default();
        let mut draws = Draws(9);
        let before = grasps(&mut draws, 300, 0.02, 1.0);
        let needed = |lost, force, each| judge.needed(&before, each, &Difference { lost, force });
        let [coarse, fine] =
            [(0.5, 3.0), (0.1, 1.5)].map(|(lost, force)| needed(lost, force, 1000).unwrap());
        assert!(coarse < fine && (20..200).contains(&fine), "{coarse} {fine}");
        // More earlier grasps to compare with need fewer new ones.
        assert!(needed(0.1, 1.5, 1000).unwrap() <= needed(0.1, 1.5, 100).unwrap());
        // That many do notice it.
        let noticed = (0..100).filter(|_| {
            let now = grasps(&mut draws, fine, 0.12, 1.0);
            let before = grasps(&mut draws, 1000, 0.02, 1.0);
            first(&judge, &before, &now, per(1000, fine)).is_some()
        });
        let noticed = noticed.count();
        assert!(noticed >= 80, "{noticed}");
        assert_eq!(needed(0.001, 1.5, 1000), None, "too little to be seen");
        assert_eq!(needed(0.3, 1.2, 1000), None, "within the margin");
        assert_eq!(judge.needed(&[], 0, &Difference::default()), None);
    }

    #[test]
    fn numbers_that_make_no_sense_are_none() {
        let judge = JudgeConfig::default();
        assert!(judge.is_sane());
        for (alpha, margin) in
            [(0.0, 1.2), (0.6, 1.2), (f64::NAN, 1.2), (0.05, 0.9), (0.05, f32::NAN)]
        {
            assert!(!JudgeConfig { alpha, margin }.is_sane());
        }
    }
}
