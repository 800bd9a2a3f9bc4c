//! The Pareto tail of the highest levels of seconds, and the level that is passed once in a wanted interval.
//!
//! The largest levels are taken for a Pareto tail, P(X > x) ~ x^-a, with Hill's estimate of a (B. M. Hill, Ann. Statist. 3
//! (1975)): heavier than the exponential tail of Gaussian noise, and continued beyond the largest level seen.

/// The tail of a test's peaks: P(peak > h) in a second is `share` (start/h)^index for h above `start`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tail {
    /// Where the tail begins.
    start: f64,
    /// Seconds in the tail over all seconds.
    share: f64,
    /// Hill's mean of ln(peak / start), the reciprocal of the index.
    mean_log: f64,
}

impl Tail {
    /// Of the `most` largest `peaks`, which are positive and in rising order and were seen in `seconds`; `None` where there are no more
    /// peaks than that, or `most` is 0.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "counts of seconds")]
    pub(super) fn of(peaks: &[f32], most: usize, seconds: usize) -> Option<Self> {
        let from = peaks.len().checked_sub(most + 1)?;
        let (&start, tail) = peaks.get(from..)?.split_first()?;
        let count = tail.len() as f64;
        let logs = tail.iter().map(|x| f64::from(x / start).ln()).sum::<f64>();
        (!tail.is_empty()).then(|| Self {
            start: f64::from(start),
            share: count / seconds as f64,
            mean_log: logs / count,
        })
    }

    /// The level that is exceeded once in `seconds` seconds, never below the tail.
    #[must_use]
    pub(super) fn level(&self, seconds: f64) -> f32 {
        // P(peak > h) in a second = 1 / seconds
        let factor = (self.share * seconds).max(1.0).powf(self.mean_log);
        #[expect(clippy::cast_possible_truncation, reason = "a threshold")]
        let level = (self.start * factor).min(1e9) as f32;
        level
    }
}

#[cfg(test)]
mod tests {
    use super::Tail;

    /// Peaks of a known Pareto tail: the level exceeded with a known probability comes out.
    #[test]
    fn a_pareto_tail_is_continued_to_its_quantile() {
        let mut state = 9_u32;
        let mut uniform = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (f64::from(state) + 1.0) / 4_294_967_297.0
        };
        #[expect(clippy::cast_possible_truncation, reason = "test data")]
        let mut peaks: Vec<f32> =
            (0..20_000).map(|_| (3.0 * uniform().powf(-0.125)) as f32).collect();
        peaks.sort_by(f32::total_cmp);
        let tail = Tail::of(&peaks, 2000, 20_000).unwrap();
        // P(X > h) = (3/h)^8 = 1/(7 * 600): h = 3 * 4200^(1/8) = 8.51.
        let h = tail.level(4200.0);
        assert!((h / 8.51 - 1.0).abs() < 0.06, "{h}");
    }

    #[test]
    fn an_ideal_tail_is_continued_exactly_enough() {
        // The i-th largest of a tail with index 4: (1000 / i)^(1/4).
        #[expect(clippy::cast_possible_truncation, reason = "levels")]
        let mut levels: Vec<f32> =
            (1..=1000_u16).map(|i| (1000.0 / (f64::from(i) - 0.5)).powf(0.25) as f32).collect();
        levels.reverse();
        let tail = Tail::of(&levels, 100, 1000).unwrap();
        for passes in [30.0, 1.0, 0.1, 0.01] {
            let level = f64::from(tail.level(1000.0 / passes));
            let wanted = (1000.0_f64 / passes).powf(0.25);
            assert!((level / wanted - 1.0).abs() < 0.03, "{passes}: {level}, wanted {wanted}");
        }
        assert!(tail.level(2.0) >= levels[899]);
    }

    #[test]
    fn a_longer_interval_never_gets_a_lower_threshold() {
        let peaks = [2.0, 2.1, 2.2, 2.5, 2.6, 2.7, 2.9, 3.0, 3.3, 4.4, 4.5, 4.6];
        let tail = Tail::of(&peaks, 1, 12).unwrap();
        let levels = [70.0, 700.0, 7e3, 7e6].map(|seconds| tail.level(seconds));
        assert!(levels.windows(2).all(|pair| pair[0] <= pair[1]), "{levels:?}");
        assert!(levels[3] < 1e9 && levels[3].is_finite());
        assert_eq!(Tail::of(&[1.0; 9], 0, 9), None);
        assert_eq!(Tail::of(&[1.0; 9], 9, 9), None);
        assert_eq!(Tail::of(&[], 0, 9), None);
    }
}
