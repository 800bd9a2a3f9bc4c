//! Median and 95 % quantile of values.

use serde::Serialize;

/// Median and 95 % quantile; `null` of nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Quantiles {
    /// Median.
    pub p50: Option<f64>,
    /// 95 % quantile.
    pub p95: Option<f64>,
}

impl Quantiles {
    /// Of `values`, interpolated linearly between the ordered values.
    #[must_use]
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        Self { p50: quantile(&values, 0.5), p95: quantile(&values, 0.95) }
    }
}

/// A quantile of ordered values; `None` of nothing.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place in a list")]
pub(super) fn quantile(ordered: &[f64], q: f64) -> Option<f64> {
    let place = q * (ordered.len().checked_sub(1)? as f64);
    let (low, high) = (*ordered.get(place.floor() as usize)?, *ordered.get(place.ceil() as usize)?);
    Some(low + (high - low) * place.fract())
}

#[cfg(test)]
mod tests {
    use super::Quantiles;

    #[test]
    fn quantiles_interpolate() {
        let q = Quantiles::of((0..=10).rev().map(f64::from).collect());
        assert_eq!((q.p50, q.p95), (Some(5.0), Some(9.5)));
    }
}
