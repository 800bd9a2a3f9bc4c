//! 95 % confidence intervals of counts and latencies.
//!
//! Shares: the exact binomial interval (Clopper and Pearson 1934). Rates: the exact Poisson interval (Garwood 1936). Quantiles:
//! percentile bootstrap (Efron 1979), 2000 draws, seeded. Recordings of one material are alike, so whole materials are drawn
//! where there are at least five of them; the interval then speaks of other materials too.

use super::quantiles::{Quantiles, quantile};
use crate::{
    dice::Dice,
    poisson::{self, chance_to_pass},
};
use serde::Serialize;
use std::collections::BTreeMap;

const DRAWS: usize = 2000;
const SEED: u64 = 0x5eed_0f51_1930_0001;
const TAIL: f64 = 0.025;
/// Fewer materials than this show nothing about others.
const FEWEST_GROUPS: usize = 5;

/// Lower and upper end; `null` of nothing.
pub type Interval = Option<[f64; 2]>;

/// Intervals of the two quantiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct QuantileIntervals {
    /// Of the median.
    pub p50: Interval,
    /// Of the 95 % quantile.
    pub p95: Interval,
}

/// Bootstrap intervals of the quantiles of `values`, each with the name of its group.
#[must_use]
pub fn quantiles(values: &[(&str, f64)]) -> QuantileIntervals {
    if values.is_empty() {
        return QuantileIntervals::default();
    }
    let mut named: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (name, value) in values {
        named.entry(name).or_default().push(*value);
    }
    let groups: Vec<Vec<f64>> = if named.len() >= FEWEST_GROUPS {
        named.into_values().collect()
    } else {
        values.iter().map(|(_, value)| vec![*value]).collect()
    };
    let mut dice = Dice(SEED);
    let (mut medians, mut tails) = (Vec::with_capacity(DRAWS), Vec::with_capacity(DRAWS));
    for _ in 0..DRAWS {
        let mut drawn = Vec::with_capacity(values.len());
        for _ in 0..groups.len() {
            drawn.extend(groups.get(below(&mut dice, groups.len())).into_iter().flatten().copied());
        }
        let quantiles = Quantiles::of(drawn);
        medians.extend(quantiles.p50);
        tails.extend(quantiles.p95);
    }
    QuantileIntervals { p50: central(medians), p95: central(tails) }
}

fn central(mut values: Vec<f64>) -> Interval {
    values.sort_by(f64::total_cmp);
    Some([quantile(&values, TAIL)?, quantile(&values, 1.0 - TAIL)?])
}

/// One of `n`; the bias of n / 2^64 does not matter.
fn below(dice: &mut Dice, n: usize) -> usize {
    let n = u64::try_from(n.max(1)).unwrap_or(u64::MAX);
    usize::try_from(dice.bits() % n).unwrap_or(0)
}

/// Interval of a share of which `hits` of `trials` were seen.
#[must_use]
pub fn share(hits: usize, trials: usize) -> Interval {
    if trials == 0 {
        return None;
    }
    let most = |hits: usize| match (u64::try_from(hits), u64::try_from(trials)) {
        (Ok(hits), Ok(trials)) => chance_to_pass(hits + 1, trials, 1.0 - TAIL),
        _ => 1.0,
    };
    Some([1.0 - most(trials.saturating_sub(hits)), most(hits)])
}

/// Interval of a rate (1/s) at which `events` were seen in `seconds`.
#[must_use]
pub fn rate(events: u32, seconds: f64) -> Interval {
    if seconds <= 0.0 {
        return None;
    }
    let (low, high) = poisson::interval(events.into(), 1.0 - 2.0 * TAIL);
    Some([low / seconds, high / seconds])
}

#[cfg(test)]
mod tests {
    use super::{quantiles, rate, share};

    fn near(interval: super::Interval, expected: [f64; 2]) {
        let [low, high] = interval.unwrap();
        assert!(
            (low - expected[0]).abs() < 1e-3 && (high - expected[1]).abs() < 1e-3,
            "{low} {high}"
        );
    }

    /// Values of published tables.
    #[test]
    fn shares_and_rates_are_exact() {
        near(share(0, 10), [0.0, 0.3085]);
        near(share(5, 10), [0.1871, 0.8129]);
        near(share(10, 10), [0.6915, 1.0]);
        near(share(1, 58), [0.0004, 0.0924]);
        near(rate(0, 1.0), [0.0, 3.6889]);
        near(rate(5, 1.0), [1.6235, 11.6683]);
        near(rate(5, 10.0), [0.16235, 1.16683]);
        assert_eq!((share(0, 0), rate(3, 0.0)), (None, None));
    }

    #[test]
    fn the_bootstrap_is_repeatable_and_near_theory() {
        // The median of 400 uniform numbers has the deviation 0.5 / sqrt(400).
        let values: Vec<(&str, f64)> =
            (0..400_u32).map(|i| ("", f64::from(i * 7919 % 400) / 400.0)).collect();
        let found = quantiles(&values);
        assert_eq!(found, quantiles(&values));
        let [low, high] = found.p50.unwrap();
        assert!((low - 0.45).abs() < 0.01 && (high - 0.55).abs() < 0.01, "{low} {high}");
        assert_eq!(quantiles(&[]), super::QuantileIntervals::default());
    }

    #[test]
    fn alike_recordings_of_a_material_do_not_narrow_the_interval() {
        let materials = ["a", "b", "c", "d", "e", "f"];
        let one: Vec<_> =
            materials.iter().zip([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).map(|(m, v)| (*m, v)).collect();
        let many: Vec<_> = one.iter().flat_map(|pair| core::iter::repeat_n(*pair, 20)).collect();
        let ([a, b], [c, d]) = (quantiles(&one).p50.unwrap(), quantiles(&many).p50.unwrap());
        assert!((d - c) > 0.8 * (b - a), "{c} {d} against {a} {b}");
    }
}
