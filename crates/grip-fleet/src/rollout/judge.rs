//! Slips and faults of one gripper before and with a new model in; whether it has become worse out.
//!
//! Slips come as they come: two counts of the same rate differ. Given `a` events in `s` seconds before and `b` in `t` seconds with the
//! new model, and a true rate that has risen by no more than the factor `f`, `b` of the `a + b` events fall into the second time with
//! probability at most `p = f t / (f t + s)`, whatever the rate is: a binomial count (Przyborowski and Wilenski, Biometrika 31, 1940). It is worse where
//! so many or more come with a probability below `alpha`.

/// What was counted over some time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Time in which samples came (s).
    pub seconds: f64,
    /// Slips.
    pub slips: u64,
    /// Faults: of the gripper, of a sensor.
    pub faults: u64,
}

/// When a model is worse, and when it has been watched long enough.
#[derive(Clone, Copy, Debug, PartialEq)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
    /// It has to go.
    Worse(Worse),
}

impl JudgeConfig {
    /// Judges counts with the new model against those before it. What was never seen before is compared with one event in that time, so
    /// that a first slip condemns nobody.
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
            Judgement::Good
        } else {
            Judgement::Open
        }
    }

    fn is_worse(&self, (old, old_s): (u64, f64), (new, new_s): (u64, f64)) -> bool {
        if new == 0 || new_s <= 0.0 {
            return false;
        }
        let share = self.factor * new_s;
        at_least(new, old.saturating_add(new), share / (share + old_s)) < self.alpha
    }
}

/// Probability of `least` or more of `of` events, each of probability `p` in (0, 1).
fn at_least(least: u64, of: u64, p: f64) -> f64 {
    // Term by term from the first one, in logarithms: sums of many small terms, none of which may vanish.
    let odds = (p / (1.0 - p)).ln();
    let (n, first) = (float(of), float(least));
    let mut term = ln_choose(n, first) + first * p.ln() + (n - first) * (1.0 - p).ln();
    let mut sum = 0.0;
    let mut k = first;
    while k <= n {
        let value = term.exp();
        sum += value;
        if k > n * p && value < sum * 1e-17 {
            break;
        }
        term += ((n - k) / (k + 1.0)).ln() + odds;
        k += 1.0;
    }
    sum.min(1.0)
}

/// ln of the binomial coefficient.
fn ln_choose(n: f64, k: f64) -> f64 {
    let k = k.min(n - k);
    let mut sum = 0.0;
    let mut at = 1.0;
    while at <= k {
        sum += ((n - k + at) / at).ln();
        at += 1.0;
    }
    sum
}

#[expect(clippy::cast_precision_loss, reason = "counts far below 2^53")]
fn float(count: u64) -> f64 {
    count as f64
}

#[cfg(test)]
mod tests {
    use super::{Counts, JudgeConfig, Judgement, Worse, at_least};

    fn counts(seconds: f64, slips: u64) -> Counts {
        Counts { seconds, slips, faults: 0 }
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
    fn a_model_is_good_after_its_time_unless_it_is_worse() {
        let judge = JudgeConfig::default();
        let before = counts(3600.0, 360);
        assert_eq!(judge.judge(&before, &counts(60.0, 6)), Judgement::Open);
        assert_eq!(judge.judge(&before, &counts(600.0, 60)), Judgement::Good);
        assert_eq!(judge.judge(&before, &counts(600.0, 80)), Judgement::Good, "chance");
        assert_eq!(judge.judge(&before, &counts(60.0, 25)), Judgement::Worse(Worse::Slips));
        let faults = Counts { seconds: 60.0, slips: 0, faults: 10 };
        assert_eq!(judge.judge(&before, &faults), Judgement::Worse(Worse::Faults));
    }

    #[test]
    fn few_events_condemn_nobody() {
        let judge = JudgeConfig::default();
        for before in [Counts::default(), counts(10.0, 0), counts(3600.0, 1)] {
            assert_eq!(judge.judge(&before, &counts(60.0, 1)), Judgement::Open, "{before:?}");
        }
        assert_eq!(judge.judge(&counts(3600.0, 0), &counts(0.0, 5)), Judgement::Open);
    }
}
