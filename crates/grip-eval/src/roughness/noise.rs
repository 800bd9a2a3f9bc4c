//! The standard deviation of the white noise in a height profile.

/// Deviation of the white noise in `heights`, from the median of `|z[i-1] - 2 z[i] + z[i+1]|` over 0.6745 sqrt 6.
///
/// The surface itself hardly enters, as long as it is smooth over two steps; a few cracks or lost contacts do not
/// either, because it is a median. Of a surface that is coarse against the step it is an upper bound. `None` with fewer than
/// three heights; `scratch` needs as many values as `heights` has, otherwise `None` too. Heights must be finite.
#[must_use]
pub fn noise_deviation(heights: &[f64], scratch: &mut [f64]) -> Option<f64> {
    let n = heights.len().checked_sub(2).filter(|n| *n > 0)?;
    let bends = scratch.get_mut(..n)?;
    for (bend, z) in bends.iter_mut().zip(heights.windows(3)) {
        *bend = (z[0] - 2.0 * z[1] + z[2]).abs();
    }
    let (_, median, _) = bends.select_nth_unstable_by(n / 2, f64::total_cmp);
    Some(*median / (0.674_489_750_196_081_7 * libm::sqrt(6.0)))
}

#[cfg(test)]
mod tests {
    use super::noise_deviation;

    #[test]
    fn finds_the_noise_on_a_rough_surface() {
        let mut seed = 3_u32;
        let mut uniform = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        let heights: Vec<f64> = (0..20_000)
            .map(|i| {
                let noise: f64 = (0..12).map(|_| uniform()).sum();
                5.0 * (f64::from(i) / 60.0).sin()
                    + 0.1 * noise
                    + if i % 500 == 0 { 9.0 } else { 0.0 }
            })
            .collect();
        let mut scratch = heights.clone();
        let found = noise_deviation(&heights, &mut scratch).unwrap();
        assert!((found / 0.1 - 1.0).abs() < 0.04, "{found}");
        assert_eq!(noise_deviation(&heights[..2], &mut scratch), None);
        assert_eq!(noise_deviation(&heights, &mut [0.0; 5]), None);
        assert_eq!(noise_deviation(&[1.0; 9], &mut scratch), Some(0.0));
    }
}
