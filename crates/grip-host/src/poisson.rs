//! A count of independent events in, the interval its mean lies in out.

/// The exact (Garwood 1936) two-sided interval of the mean of a Poisson distribution of which `count` events were seen, with
/// probability `confidence` (0 to 1, exclusive): for 0 events at 0.95 it is 0 to 3.69.
#[must_use]
pub fn interval(count: u64, confidence: f64) -> (f64, f64) {
    let tail = 0.5 * (1.0 - confidence);
    // P(X >= count | low) = tail and P(X <= count | high) = tail.
    let low = if count == 0 { 0.0 } else { solve(|mean| 1.0 - at_most(count - 1, mean), tail) };
    let high = solve(|mean| 1.0 - at_most(count, mean), 1.0 - tail);
    (low, high)
}

/// Probability of at most `count` events where `mean` are expected.
fn at_most(count: u64, mean: f64) -> f64 {
    let mut log_term = -mean;
    let mut sum = log_term.exp();
    for k in 1..=count {
        #[expect(clippy::cast_precision_loss, reason = "counts are below 2^52")]
        let k = k as f64;
        log_term += mean.ln() - k.ln();
        sum += log_term.exp();
    }
    sum.min(1.0)
}

/// The mean at which the rising `probability` reaches `wanted`.
fn solve(probability: impl Fn(f64) -> f64, wanted: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while probability(high) < wanted && high < 1e12 {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if probability(middle) < wanted { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::interval;

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
}
