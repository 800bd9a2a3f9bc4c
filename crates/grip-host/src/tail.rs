//! The highest levels of equal stretches of time in, the level that is passed at a wanted rate out.
//!
//! The largest levels are taken for a Pareto tail, P(X > x) ~ x^-a, with Hill's estimate of a (B. M. Hill, Ann. Statist. 3
//! (1975)): heavier than the exponential tail of Gaussian noise, and continued beyond the largest level seen.

/// The level that `passes` of the stretches exceed on average, 0 < `passes`. `ordered` are their highest levels, all positive, the
/// largest last; the `tail` largest make the tail. The result never lies below the tail; `None` where there are no more levels than
/// make the tail.
#[must_use]
pub fn continued(ordered: &[f32], tail: usize, passes: f64) -> Option<f64> {
    let start = ordered.len().checked_sub(tail + 1)?;
    let (&start, tail) = ordered.get(start..)?.split_first()?;
    if tail.is_empty() {
        return Some(2.0 * f64::from(start));
    }
    #[expect(clippy::cast_precision_loss, reason = "a count of stretches")]
    let count = tail.len() as f64;
    let mean_log = tail.iter().map(|x| f64::from(x / start).ln()).sum::<f64>() / count;
    // passes = count (start / level)^(1 / mean_log)
    Some(f64::from(start) * (count / passes).max(1.0).powf(mean_log))
}

#[cfg(test)]
mod tests {
    use super::continued;

    #[test]
    fn an_ideal_tail_is_continued_exactly_enough() {
        // The i-th largest of a tail with a = 4: (1000 / i)^(1/4).
        #[expect(clippy::cast_possible_truncation, reason = "levels")]
        let mut levels: Vec<f32> =
            (1..=1000_u16).map(|i| (1000.0 / (f64::from(i) - 0.5)).powf(0.25) as f32).collect();
        levels.reverse();
        for passes in [30.0, 1.0, 0.1, 0.01] {
            let level = continued(&levels, 100, passes).unwrap();
            let wanted = (1000.0_f64 / passes).powf(0.25);
            assert!((level / wanted - 1.0).abs() < 0.03, "{passes}: {level}, wanted {wanted}");
        }
        assert!(continued(&levels, 100, 500.0).unwrap() >= f64::from(levels[899]));
    }

    #[test]
    fn too_few_levels_have_no_tail() {
        assert_eq!(continued(&[], 0, 1.0), None);
        assert_eq!(continued(&[1.0, 2.0], 2, 1.0), None);
        assert_eq!(continued(&[3.0], 0, 1.0), Some(6.0));
    }
}
