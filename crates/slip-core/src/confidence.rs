//! A slip statistic in; how sure it is that noise alone did not cause it out.
//!
//! The thresholds stand where noise and motion reach a statistic x = 1 once in the stated false-alarm interval T (600 s unless
//! calibrated otherwise). Beyond it false alarms get rarer as a Pareto tail, so in T noise reaches x on average x^-tail times, and, the
//! alarms being independent, at least once with probability 1 - exp(-x^-tail). The confidence is the rest of it:
//!
//! ```text
//! confidence = P(noise alone does not reach x within T) = exp(-x^-tail)
//! ```
//!
//! It is 1/e = 0.368 at the threshold and goes to 1 for a strong slip. It says how hard the event is to explain by noise, knows nothing of
//! how often objects slip, and is as good as the threshold: where the interval does not hold, confidences are too high. `tail` is measured by `gripctl calibrate`; the default lies below
//! that of the simulated robot, so it errs to the low side.

/// Range of the tail: below it the mean of the noise would not exist, above it x^-tail is a step.
pub const TAIL_RANGE: (f32, f32) = (1.0, 50.0);

/// Probability (0..=1) that noise alone does not reach `statistic` (over its threshold) within the stated false-alarm interval, for
/// alarms that get rarer as `statistic`^-`tail`. Rises with the statistic; 1/e at 1; 0 for NaN and for what is not positive. A `tail`
/// outside [`TAIL_RANGE`] is taken as the nearer end, NaN as the lower one.
#[must_use]
pub fn confidence(statistic: f32, tail: f32) -> f32 {
    let (low, high) = TAIL_RANGE;
    // `max` and `min` take the number where one side is NaN.
    let tail = tail.max(low).min(high);
    if statistic > 0.0 { libm::expf(-libm::powf(statistic, -tail)) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::{TAIL_RANGE, confidence};
    use proptest::prelude::{any, proptest};

    /// 1 - exp(-x^-a) is the chance of at least one of x^-a expected alarms.
    #[test]
    fn it_is_one_over_e_at_the_threshold_and_rises_to_certainty() {
        for tail in [1.0, 4.0, 8.0, 50.0] {
            assert!((confidence(1.0, tail) - 0.367_879_45).abs() < 1e-7, "tail {tail}");
        }
        assert!((confidence(2.0, 4.0) - 0.939_413).abs() < 1e-6, "exp(-1/16)");
        assert!((confidence(0.5, 1.0) - 0.135_335_3).abs() < 1e-6, "exp(-2)");
        assert_eq!(confidence(100.0, 8.0), 1.0);
        assert_eq!(confidence(0.1, 8.0), 0.0);
    }

    #[test]
    fn odd_numbers_have_a_defined_answer() {
        assert_eq!(confidence(f32::INFINITY, 8.0), 1.0);
        for nothing in [f32::NAN, f32::NEG_INFINITY, -1.0, 0.0, -0.0, f32::MIN_POSITIVE] {
            assert_eq!(confidence(nothing, 8.0), 0.0, "{nothing}");
        }
        let (low, high) = TAIL_RANGE;
        assert_eq!(confidence(1.5, f32::NAN), confidence(1.5, low));
        assert_eq!(confidence(1.5, -3.0), confidence(1.5, low));
        assert_eq!(confidence(1.5, f32::INFINITY), confidence(1.5, high));
    }

    proptest! {
        #[test]
        fn any_input_gives_a_probability(statistic in any::<f32>(), tail in any::<f32>()) {
            let value = confidence(statistic, tail);
            assert!((0.0..=1.0).contains(&value), "{statistic} {tail}: {value}");
        }

        #[test]
        fn it_never_falls_with_the_statistic(a in 0.0_f32..100.0, b in 0.0_f32..100.0, tail in 1.0_f32..50.0) {
            // Up to the rounding of a power.
            assert!(confidence(a.min(b), tail) <= confidence(a.max(b), tail) + 1e-6);
        }
    }
}
