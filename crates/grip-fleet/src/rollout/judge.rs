//! Slips and faults of one gripper before and with a new model in; whether it has become worse out.
//!
//! Slips come as they come: two counts of the same rate differ. Given `a` events in `s` seconds before and `b` in `t` seconds with the
//! new model, and a true rate that has risen by no more than the factor `f`, `b` of the `a + b` events fall into the second time with
//! probability at most `p = f t / (f t + s)`, whatever the rate is: a binomial count (Przyborowski and Wilenski, Biometrika 31, 1940). It is worse where
//! so many or more come with a probability below `alpha`.

use core::fmt;
use serde::{Deserialize, Serialize};
use statrs::distribution::{Discrete, Poisson};
use statrs::function::beta::checked_beta_reg;

/// What was counted over some time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// Time in which something was between the fingers (s).
    pub seconds: f64,
    /// Slips.
    pub slips: u64,
    /// Faults that the gripper has reported, such as an object that was lost.
    pub faults: u64,
    /// Times something came between the fingers.
    #[serde(default)]
    pub grasps: u64,
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seconds, slips, faults, .. } = self;
        write!(f, "{slips} slips and {faults} faults in {seconds:.0} s")
    }
}

impl Counts {
    /// Whether a gripper can have counted that: a time of at most 30 years, and at most ten million of each. Slips are at least five seconds from each
    /// other; ten a second, and a hundred more, are let through.
    #[must_use]
    pub fn is_sane(&self) -> bool {
        (0.0..=1e9).contains(&self.seconds)
            && self.slips.max(self.faults).max(self.grasps) <= 10_000_000
            && float(self.slips) <= 100.0 + 10.0 * self.seconds
    }

    /// What was counted since `earlier`.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Self {
        Self {
            seconds: (self.seconds - earlier.seconds).max(0.0),
            slips: self.slips.saturating_sub(earlier.slips),
            faults: self.faults.saturating_sub(earlier.faults),
            grasps: self.grasps.saturating_sub(earlier.grasps),
        }
    }
}

/// When a model is worse, and when it has been watched long enough.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JudgeConfig {
    /// A rate may rise by so much, from 1.
    pub factor: f64,
    /// Probability of calling a model worse that is not, for each count, 0 to 0.5.
    pub alpha: f64,
    /// Time with the new model after which it is good unless it is worse (s), from 1.
    pub watch_s: f64,
}

impl Default for JudgeConfig {
    /// Half as much again, one in a thousand, ten minutes.
    fn default() -> Self {
        Self { factor: 1.5, alpha: 1e-3, watch_s: 600.0 }
    }
}

/// What got worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Worse {
    /// More slips.
    Slips,
    /// More faults.
    Faults,
}

/// How a new model does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judgement {
    /// It is not known yet.
    Open,
    /// It has been watched long enough.
    Good,
    /// It has been watched long enough, and nothing was grasped with it.
    Idle,
    /// It has to go.
    Worse(Worse),
}

impl JudgeConfig {
    /// Judges counts with the new model against those before it. What was never seen before is compared with one event in that time: a first one condemns
    /// nobody, unless it comes within about `alpha` / 3 of that time, with the defaults.
    #[must_use]
    pub fn judge(&self, before: &Counts, now: &Counts) -> Judgement {
        let worse = |old: u64, new: u64| {
            self.is_worse((old.max(1), before.seconds.max(1.0)), (new, now.seconds))
        };
        if worse(before.slips, now.slips) {
            Judgement::Worse(Worse::Slips)
        } else if worse(before.faults, now.faults) {
            Judgement::Worse(Worse::Faults)
        } else if now.seconds >= self.watch_s {
            if now.grasps > 0 { Judgement::Good } else { Judgement::Idle }
        } else {
            Judgement::Open
        }
    }

    /// Whether the numbers are some: the factor 1 to 100, `alpha` 1e-9 to 0.5, the time 1 s to 30 days.
    #[must_use]
    pub fn is_sane(&self) -> bool {
        (1.0..=100.0).contains(&self.factor)
            && (1e-9..=0.5).contains(&self.alpha)
            && (1.0..=2_592_000.0).contains(&self.watch_s)
    }

    /// Probability that a gripper that slips `ratio` times as often as before, `per_s` times a second then, is called worse by what is counted in
    /// [`JudgeConfig::watch_s`], where as long a time was counted before.
    #[must_use]
    pub fn power(&self, per_s: f64, ratio: f64) -> f64 {
        let (old, new) = (per_s * self.watch_s, per_s * ratio * self.watch_s);
        let worse = |(a, b): (u64, u64)| {
            self.is_worse((a.max(1), self.watch_s.max(1.0)), (b, self.watch_s))
        };
        // What comes with at least so many, from the most on.
        let mut tails = Vec::from_iter(poisson(new));
        let mut sum = 0.0;
        for (_, p) in tails.iter_mut().rev() {
            sum += *p;
            *p = sum;
        }
        let (mut power, mut least) = (0.0, 0);
        for (a, share) in poisson(old) {
            // The more there were before, the more it takes.
            let most = poisson_end(new);
            while least < most && !worse((a, least)) {
                least += 1;
            }
            let tail = tails.iter().find(|(b, _)| *b >= least).map_or(0.0, |(_, tail)| *tail);
            power += share * tail;
        }
        power.min(1.0)
    }

    /// The least ratio to the rate of before, in steps of a tenth, that is noticed nine times in ten; `None` where even the hundredfold is not.
    #[must_use]
    pub fn noticed(&self, per_s: f64) -> Option<f64> {
        let (mut low, mut high) = (10_u32, 1000_u32);
        let enough = |tenths: u32| self.power(per_s, 0.1 * f64::from(tenths)) >= 0.9;
        if !enough(high) {
            return None;
        }
        while high - low > 1 {
            let middle = low.midpoint(high);
            if enough(middle) { high = middle } else { low = middle }
        }
        Some(0.1 * f64::from(high))
    }

    fn is_worse(&self, (old, old_s): (u64, f64), (new, new_s): (u64, f64)) -> bool {
        if new == 0 || new_s <= 0.0 {
            return false;
        }
        let (share, all) = (self.factor * new_s, old.saturating_add(new));
        let share = share / (share + old_s);
        // So many come at least every second time: the median of a binomial count is no less than its mean, rounded down.
        if float(new) <= (float(all) * share).floor() {
            return false;
        }
        at_least(new, all, share) < self.alpha
    }
}

/// Probability of `least` or more of `of` events, each of probability `p` in (0, 1): the beta distribution of `least` and
/// `of` - `least` + 1 at `p`. The fraction of statrs ends after 140 terms, so of more than a million events what is near
/// one half comes out at 0.2 to 0.5; what is below 0.16 is right to 1e-6.
fn at_least(least: u64, of: u64, p: f64) -> f64 {
    if least == 0 {
        return 1.0;
    }
    checked_beta_reg(float(least), float(of.saturating_sub(least) + 1), p).unwrap_or(1.0)
}

/// Counts around a mean, and the probability of each (Poisson); what is left out has less than a millionth.
fn poisson(mean: f64) -> impl Iterator<Item = (u64, f64)> {
    let law = Poisson::new(mean);
    let first = floor(mean - 6.0 * mean.sqrt() - 6.0);
    (first..poisson_end(mean)).map(move |k| (k, law.as_ref().map_or(0.0, |law| law.pmf(k))))
}

fn poisson_end(mean: f64) -> u64 {
    floor(mean + 6.0 * mean.sqrt() + 12.0)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a count; the cast saturates"
)]
fn floor(count: f64) -> u64 {
    count.max(0.0) as u64
}

#[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
fn float(count: u64) -> f64 {
    count as f64
}

#[cfg(test)]
mod tests {
    use super::{Counts, JudgeConfig, Judgement, Worse, at_least};

    fn counts(seconds: f64, slips: u64) -> Counts {
        Counts { seconds, slips, faults: 0, grasps: 1 }
    }

    #[test]
    fn binomial_tails_are_right() {
        // Exact: sums of choose(n, k) p^k (1-p)^(n-k).
        for (least, of, p, wanted) in [
            (0, 10, 0.3, 1.0),
            (10, 10, 0.5, 1.0 / 1024.0),
            (9, 10, 0.5, 11.0 / 1024.0),
            (1, 3, 0.25, 1.0 - 0.75_f64.powi(3)),
            (500, 1000, 0.5, 0.512_612_509_089_180_5),
        ] {
            let got = at_least(least, of, p);
            assert!((got - wanted).abs() < 1e-11 * wanted.max(1e-3), "{least} of {of}: {got}");
        }
    }

    #[test]
    fn large_counts_are_judged_too() {
        let judge = JudgeConfig { watch_s: 28_800.0, ..JudgeConfig::default() };
        let ratio = judge.noticed(0.2).unwrap();
        assert!((1.5..1.8).contains(&ratio), "{ratio}");
        let most = Counts { seconds: 1e9, slips: 10_000_000, faults: 0, grasps: 1 };
        assert!(most.is_sane());
        assert_eq!(judge.judge(&most, &most), Judgement::Good);
        assert_eq!(
            judge.judge(&Counts { seconds: 2e9, ..most }, &most),
            Judgement::Worse(Worse::Slips)
        );
        for counts in [
            Counts { seconds: f64::NAN, ..most },
            Counts { seconds: -1.0, ..most },
            Counts { slips: u64::MAX, ..most },
            Counts { faults: 10_000_001, ..most },
            Counts { seconds: 10.0, slips: 201, faults: 0, grasps: 1 },
        ] {
            assert!(!counts.is_sane(), "{counts:?}");
        }
    }

    #[test]
    fn a_model_is_good_after_its_time_unless_it_is_worse() {
        let judge = JudgeConfig::default();
        let before = counts(3600.0, 360);
        assert_eq!(judge.judge(&before, &counts(60.0, 6)), Judgement::Open);
        assert_eq!(judge.judge(&before, &counts(600.0, 60)), Judgement::Good);
        assert_eq!(judge.judge(&before, &counts(600.0, 80)), Judgement::Good, "chance");
        assert_eq!(judge.judge(&before, &counts(60.0, 25)), Judgement::Worse(Worse::Slips));
        let faults = Counts { seconds: 60.0, slips: 0, faults: 10, grasps: 1 };
        assert_eq!(judge.judge(&before, &faults), Judgement::Worse(Worse::Faults));
    }

    /// Against draws: with 12 slips in two minutes before, threefold slips are noticed about as often as the sums say.
    #[test]
    fn power_is_that_of_draws() {
        let judge = JudgeConfig { watch_s: 120.0, ..JudgeConfig::default() };
        let mut state = 7_u64;
        let mut share = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            f64::from(u32::try_from(state >> 32).unwrap()) / f64::from(u32::MAX)
        };
        // Events of a rate come so many in a time (Knuth's product of uniforms).
        let mut draw = move |mean: f64| {
            let (mut product, mut count) = (share(), 0);
            while product > (-mean).exp() {
                product *= share();
                count += 1;
            }
            count
        };
        let trials = 2000;
        let mut worse = 0.0;
        for _ in 0..trials {
            let judged = judge.judge(&counts(120.0, draw(12.0)), &counts(120.0, draw(36.0)));
            worse += f64::from(u8::from(judged == Judgement::Worse(Worse::Slips)));
        }
        let (drawn, reported) = (worse / f64::from(trials), judge.power(0.1, 3.0));
        assert!((drawn - reported).abs() < 0.04, "{drawn} {reported}");
        assert!(judge.power(0.1, 1.0) < 1e-3);
    }

    #[test]
    fn what_is_noticed_grows_finer_with_time() {
        let noticed = |watch_s: f64| JudgeConfig { watch_s, ..JudgeConfig::default() }.noticed(0.1);
        let [minute, ten, hour] = [60.0, 600.0, 3600.0].map(|s| noticed(s).unwrap());
        assert!(minute > ten && ten > hour && hour > 1.5, "{minute} {ten} {hour}");
        assert_eq!(noticed(1.0), None, "in a second nothing is");
    }

    /// The table in docs/fleet.md is the judge's.
    #[test]
    fn what_a_watch_can_report_is_as_documented() {
        let docs = include_str!("../../../../docs/fleet.md");
        for per_minute in ["0.1", "1"] {
            let rate = per_minute.parse::<f64>().unwrap() / 60.0;
            let reported = [60.0, 600.0, 3600.0, 28_800.0].map(|watch_s| {
                let judge = JudgeConfig { watch_s, ..JudgeConfig::default() };
                judge.noticed(rate).map_or("-".to_owned(), |ratio| format!("{ratio:.1}"))
            });
            let line = format!("| {per_minute} | {} |", reported.join(" | "));
            assert!(docs.contains(&line), "{line}");
        }
    }

    #[test]
    fn few_events_condemn_nobody() {
        let judge = JudgeConfig::default();
        for before in [Counts::default(), counts(10.0, 0), counts(3600.0, 1)] {
            assert_eq!(judge.judge(&before, &counts(60.0, 1)), Judgement::Open, "{before:?}");
        }
        assert_eq!(judge.judge(&counts(3600.0, 0), &counts(0.0, 5)), Judgement::Open);
        let first = |seconds| judge.judge(&counts(3600.0, 0), &counts(seconds, 1));
        assert_eq!((first(1.3), first(1.1)), (Judgement::Open, Judgement::Worse(Worse::Slips)));
    }
}
