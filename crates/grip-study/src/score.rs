//! Errors and shares of correct answers, from answers and true forces.
//!
//! The source study counts "correct responses" without saying how near is correct. So every definition in use stands
//! beside the others.

use serde::Serialize;

/// Adequate over needed force in every condition of the study.
pub const SAFETY: f64 = 1.2;

slip_msg::named! {
    /// When an answer (N) counts as correct.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Tolerance {
        fn title: "As it stands over a column.";
        fn key: "Its name in JSON.";
    }
    Relative5: "Within 5 % of the adequate force.", "± 5 %", "within_5pct";
    Relative10: "Within 10 % of the adequate force: the figure that is meant where none is named.", "± 10 %", "within_10pct";
    Relative20: "Within 20 % of the adequate force.", "± 20 %", "within_20pct";
    Range5: "Within 5 % of the range of the adequate forces that are scored.", "± 5 % of range", "within_5pct_of_range";
    HalfNewton: "Within half a newton.", "± 0.5 N", "within_0_5_n";
    OneNewton: "Within one newton.", "± 1 N", "within_1_n";
    Holds: "Holds without excess: 1.0 to 1.4 times the needed force.", "1.0–1.4 × needed", "holds_1_0_to_1_4";
}

impl Tolerance {
    /// Whether `answer` counts for the adequate force `target` (both N), where the scored forces span `range` (N).
    /// An answer that is not a number never does.
    #[must_use]
    pub fn correct(self, answer: f64, target: f64, range: f64) -> bool {
        let error = (answer - target).abs();
        match self {
            Self::Relative5 => error <= 0.05 * target,
            Self::Relative10 => error <= 0.1 * target,
            Self::Relative20 => error <= 0.2 * target,
            Self::Range5 => error <= 0.05 * range,
            Self::HalfNewton => error <= 0.5,
            Self::OneNewton => error <= 1.0,
            Self::Holds => (1.0..=1.4).contains(&(answer * SAFETY / target)),
        }
    }
}

/// How good the answers to a set of rows are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Score {
    /// Rows.
    pub rows: usize,
    /// Mean squared error (N^2).
    pub mse: f64,
    /// Share of correct answers, 0 to 1, one for each of [`Tolerance::ALL`].
    pub correct: [f64; Tolerance::ALL.len()],
}

impl Score {
    /// Share of correct answers by one definition, 0 to 1.
    #[must_use]
    pub fn share(&self, tolerance: Tolerance) -> f64 {
        self.correct[tolerance as usize]
    }

    /// Share within 10 %.
    #[must_use]
    pub fn within_10pct(&self) -> f64 {
        self.share(Tolerance::Relative10)
    }
}

/// Scores pairs of answer and true adequate force (N). Without pairs every figure is NaN.
#[must_use]
pub fn score(pairs: &[(f64, f64)]) -> Score {
    let targets = || pairs.iter().map(|(_, target)| *target);
    let range =
        targets().fold(f64::NEG_INFINITY, f64::max) - targets().fold(f64::INFINITY, f64::min);
    let rows = pairs.len() as f64;
    let share = |tolerance: Tolerance| {
        pairs.iter().filter(|(answer, target)| tolerance.correct(*answer, *target, range)).count()
            as f64
            / rows
    };
    Score {
        rows: pairs.len(),
        mse: pairs.iter().map(|(answer, target)| (answer - target).powi(2)).sum::<f64>() / rows,
        correct: Tolerance::ALL.map(share),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_definition_by_hand() {
        // Range 30 N; needed forces 10, 20 and 35 N.
        let pairs = [(12.7, 12.0), (20.5, 24.0), (42.0, 42.0)];
        let score = score(&pairs);
        let third = 1.0 / 3.0;
        let expected = [third, 2.0 * third, 1.0, 2.0 * third, third, 2.0 * third, 1.0];
        for ((tolerance, found), expected) in
            Tolerance::ALL.into_iter().zip(score.correct).zip(expected)
        {
            assert!((found - expected).abs() < 1e-12, "{}: {found}", tolerance.key());
            assert_eq!(score.share(tolerance), found);
        }
        assert!((score.mse - (0.49 + 12.25) / 3.0).abs() < 1e-12 && score.rows == 3);
        assert_eq!(score.within_10pct(), score.correct[1]);
    }

    #[test]
    fn borders_count_and_what_is_no_number_does_not() {
        assert!(Tolerance::Relative10.correct(11.0, 10.0, 0.0));
        assert!(!Tolerance::Relative10.correct(11.001, 10.0, 0.0));
        assert!(
            Tolerance::Holds.correct(10.0, 12.0, 0.0) && Tolerance::Holds.correct(13.9, 12.0, 0.0)
        );
        assert!(
            !Tolerance::Holds.correct(9.9, 12.0, 0.0) && !Tolerance::Holds.correct(14.1, 12.0, 0.0)
        );
        for tolerance in Tolerance::ALL {
            assert!(!tolerance.correct(f64::NAN, 10.0, 5.0), "{}", tolerance.key());
            assert!(!tolerance.correct(f64::INFINITY, 10.0, 5.0), "{}", tolerance.key());
        }
    }

    #[test]
    fn wider_tolerances_never_count_less() {
        for step in 0..200 {
            let (answer, target) = (f64::from(step) * 0.2, 20.0);
            let of = |tolerance: Tolerance| tolerance.correct(answer, target, 30.0);
            assert!(of(Tolerance::Relative5) <= of(Tolerance::Relative10));
            assert!(of(Tolerance::Relative10) <= of(Tolerance::Relative20));
            assert!(of(Tolerance::HalfNewton) <= of(Tolerance::OneNewton));
        }
    }
}
