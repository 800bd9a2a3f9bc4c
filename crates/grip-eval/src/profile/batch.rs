//! Peaks, valleys and irregularities of a whole profile: the streaming extraction over a slice of
//! heights at equal steps, and the choice of the hysteresis that the slice allows.

use slip_core::irregularity::{Irregularity, IrregularityExtractor, Turn, TurnFinder};

/// The irregularities of `heights_m` (m) at equal steps of `step_m` (m), larger than `hysteresis_m` (m).
pub fn irregularities(
    heights_m: &[f32],
    step_m: f64,
    hysteresis_m: f32,
) -> impl Iterator<Item = Irregularity> {
    let mut extractor = IrregularityExtractor::new(hysteresis_m);
    placed(heights_m, step_m).filter_map(move |(x, h)| extractor.push(x, h))
}

/// The peaks and valleys of `heights_m` (m) at equal steps of `step_m` (m), larger than `hysteresis_m` (m).
pub fn turns(heights_m: &[f32], step_m: f64, hysteresis_m: f32) -> impl Iterator<Item = Turn> {
    let mut finder = TurnFinder::new(hysteresis_m);
    placed(heights_m, step_m).filter_map(move |(x, h)| finder.push(x, h))
}

fn placed(heights_m: &[f32], step_m: f64) -> impl Iterator<Item = (f64, f32)> {
    heights_m.iter().enumerate().map(move |(i, h)| (i as f64 * step_m, *h))
}

/// Hystereses tried between the two bounds.
const LEVELS: u8 = 48;

/// The hysteresis between `low_m` and `high_m` (m) in the middle of the widest range over which the
/// irregularities of `heights_m` stay the same; `low_m` where there are none.
///
/// Widest in metres, because that is what noise has to cross. Anywhere else a reversal may lie so close to the threshold that noise decides whether it counts, and one
/// reversal more or less among n changes the means by 1/n.
#[must_use]
pub fn widest_gap(heights_m: &[f32], low_m: f32, high_m: f32) -> f32 {
    let level = |k: u8| low_m + (high_m - low_m) * f32::from(k) / f32::from(LEVELS - 1);
    let found = |k: u8| {
        irregularities(heights_m, 1.0, level(k))
            .fold((0_u32, 0.0_f64), |(n, s), i| (n + 1, s + f64::from(i.spacing_m)))
    };
    let mut best: Option<(u8, u8)> = None;
    let mut run = (0, found(0));
    for k in 1..=LEVELS {
        let next = (k < LEVELS).then(|| found(k));
        if next == Some(run.1) {
            continue;
        }
        let last = k - 1;
        if run.1.0 > 0 && best.is_none_or(|(first, end)| last - run.0 > end - first) {
            best = Some((run.0, last));
        }
        if let Some(next) = next {
            run = (k, next);
        }
    }
    best.map_or(low_m, |(first, last)| 0.5 * (level(first) + level(last)))
}

#[cfg(test)]
mod tests {
    use super::{irregularities, turns, widest_gap};
    use slip_core::irregularity::{SpatialLowPass, TurnKind};

    /// Peaks of 10 and, between them, of 2.
    fn two_sizes() -> Vec<f32> {
        let period = [0.0, 5.0, 10.0, 5.0, 0.0, 1.0, 2.0, 1.0];
        period.iter().copied().cycle().take(8 * 20).collect()
    }

    #[test]
    fn a_profile_gives_what_its_samples_give() {
        let profile = two_sizes();
        let all: Vec<_> = irregularities(&profile, 0.5, 1.0).collect();
        assert_eq!(all.len(), 38);
        assert!(all.iter().all(|i| i.spacing_m == 2.0 && (i.delta_m == 10.0 || i.delta_m == 2.0)));
        let large: Vec<_> = irregularities(&profile, 0.5, 3.0).collect();
        assert_eq!(large.len(), 18);
        assert!(large.iter().all(|i| i.delta_m == 10.0));
        let peaks = turns(&profile, 0.5, 3.0).filter(|t| t.kind == TurnKind::Peak).count();
        assert_eq!(peaks, 20);
    }

    #[test]
    fn the_hysteresis_settles_in_the_widest_gap() {
        let profile = two_sizes();
        // 2 to 10 is wider than 0.5 to 2, and above 10 nothing is left.
        let wide = widest_gap(&profile, 0.5, 20.0);
        assert!((wide - 6.0).abs() < 0.3, "{wide}");
        let low = widest_gap(&profile, 0.5, 3.0);
        assert!((low - 1.25).abs() < 0.05, "{low}");
        assert_eq!(widest_gap(&[1.0; 9], 0.5, 3.0), 0.5);
        assert_eq!(widest_gap(&[], 0.5, 3.0), 0.5);
    }

    /// Height and spacing of a sine from samples with noise of 1/20 of its height: the low-pass removes the bias
    /// that the raw samples have.
    #[test]
    #[expect(clippy::cast_possible_truncation, reason = "test signal")]
    fn noise_hardly_changes_the_means() {
        let mut seed = 7_u32;
        let mut uniform = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f32::from((seed >> 16).to_le_bytes()[0]) / 255.0 - 0.5
        };
        let noisy: Vec<f32> = (0..200_000_u32)
            .map(|i| {
                let noise: f32 = (0..12).map(|_| uniform()).sum();
                (f64::from(i) / 1000.0 * core::f64::consts::TAU).sin() as f32 + 0.1 * noise
            })
            .collect();
        let mean = |signal: &[f32]| {
            let all: Vec<_> = irregularities(signal, 1e-3, 0.6).collect();
            let n = all.len() as f32;
            (
                n,
                all.iter().map(|i| i.delta_m).sum::<f32>() / n,
                all.iter().map(|i| i.spacing_m).sum::<f32>() / n,
            )
        };
        let (n, delta, spacing) = mean(&noisy);
        assert!(n >= 198.0 && delta > 2.3, "raw: {n} {delta} {spacing}");
        let mut filter = SpatialLowPass::new(0.1);
        let smooth: Vec<f32> =
            noisy.iter().enumerate().map(|(i, h)| filter.push(i as f64 * 1e-3, *h)).collect();
        let (n, delta, spacing) = mean(&smooth);
        assert!((n - 198.0).abs() <= 1.0, "{n}");
        assert!(
            (delta / 2.0 - 1.0).abs() < 0.02 && (spacing - 1.0).abs() < 0.005,
            "{delta} {spacing}"
        );
    }
}
