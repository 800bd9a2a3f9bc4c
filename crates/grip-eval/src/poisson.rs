//! Interval of the mean of a count of independent events, and chance to pass a rank among independent values.

use statrs::distribution::{Beta, ContinuousCDF, Gamma};

/// The exact (Garwood 1936) two-sided interval of the mean of a Poisson distribution of which `count` events were seen, with
/// probability `confidence` (0 to 1, exclusive): for 0 events at 0.95 it is 0 to 3.69.
#[must_use]
pub fn interval(count: u64, confidence: f64) -> (f64, f64) {
    let tail = 0.5 * (1.0 - confidence);
    // P(X >= count | low) = tail and P(X <= count | high) = tail, and P(X >= k | mean) is the gamma distribution of shape k at the mean.
    let quantile = |shape: u64, at: f64| {
        Gamma::new(shape as f64, 1.0).map_or(f64::INFINITY, |gamma| gamma.inverse_cdf(at))
    };
    let low = if count == 0 { 0.0 } else { quantile(count, tail) };
    (low, quantile(count + 1, 1.0 - tail))
}

/// Upper bound of the chance to pass the `rank`-th largest of `count` independent values of one law, whatever that is,
/// with probability `confidence` (Clopper-Pearson, Biometrika 26 (1934)): that chance has the beta distribution of
/// `rank` and `count` - `rank` + 1. 1 where there is no such rank.
#[must_use]
pub fn chance_to_pass(rank: u64, count: u64, confidence: f64) -> f64 {
    if rank == 0 || rank > count {
        return 1.0;
    }
    Beta::new(rank as f64, (count - rank + 1) as f64)
        .map_or(1.0, |beta| beta.inverse_cdf(confidence.clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::{chance_to_pass, interval};

    /// Values of the table in Garwood, Biometrika 28 (1936), at 95 %.
    #[test]
    fn intervals_are_those_of_the_table() {
        for (count, low, high) in
            [(0, 0.0, 3.689), (1, 0.0253, 5.572), (5, 1.623, 11.668), (50, 37.11, 65.92)]
        {
            let got = interval(count, 0.95);
            assert!((got.0 - low).abs() < 6e-3 && (got.1 - high).abs() < 6e-3, "{count}: {got:?}");
        }
    }

    /// By the sum of binomial probabilities: at the bound, so few values above the rank have the chance that is left.
    #[test]
    fn chances_are_those_of_the_binomial_distribution() {
        for (rank, count, confidence) in [
            (1, 120_000, 0.9999),
            (1, 12, 0.95),
            (5, 1000, 0.999),
            (40, 12_000, 0.95),
            (12, 12, 0.9),
        ] {
            let p = chance_to_pass(rank, count, confidence);
            let mut log_term = count as f64 * (-p).ln_1p();
            let mut sum = log_term.exp();
            for k in 1..rank {
                log_term += (((count - k + 1) as f64) / k as f64).ln() + p.ln() - (-p).ln_1p();
                sum += log_term.exp();
            }
            let left = 1.0 - confidence;
            assert!((sum / left - 1.0).abs() < 1e-6, "{rank} {count}: {p} {sum}");
        }
        assert_eq!([chance_to_pass(0, 9, 0.9), chance_to_pass(10, 9, 0.9)], [1.0; 2]);
    }
}
