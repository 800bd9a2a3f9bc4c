//! Rate of arriving samples, and the longest pause between two arrivals.

/// Counts arrivals by the host's clock.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Arrivals {
    first_us: Option<u64>,
    last_us: u64,
    /// Samples after those of the first arrival: as many periods.
    periods: u64,
    longest_us: u64,
}

impl Arrivals {
    /// `samples` came at `now_us`.
    pub(crate) fn push(&mut self, now_us: u64, samples: u64) {
        if samples == 0 {
            return;
        }
        if self.first_us.is_none() {
            self.first_us = Some(now_us);
        } else {
            self.periods += samples;
            self.longest_us = self.longest_us.max(now_us.saturating_sub(self.last_us));
        }
        self.last_us = now_us;
    }

    /// Time between the first and the last arrival (s).
    pub(crate) fn span_s(&self) -> f64 {
        let span_us = self.first_us.map_or(0, |first_us| self.last_us.saturating_sub(first_us));
        let span_us = span_us as f64;
        span_us / 1e6
    }

    /// Samples a second, once two batches have come.
    pub(crate) fn rate_hz(&self) -> Option<f64> {
        let periods = self.periods as f64;
        (self.span_s() > 0.0).then(|| periods / self.span_s())
    }

    /// The longest pause between two arrivals (ms).
    pub(crate) fn longest_ms(&self) -> f64 {
        let longest_us = self.longest_us as f64;
        longest_us / 1000.0
    }
}

#[cfg(test)]
mod tests {
    use super::Arrivals;

    #[test]
    fn batches_of_ten_at_a_kilohertz_are_ten_kilohertz() {
        let mut arrivals = Arrivals::default();
        assert_eq!(arrivals.rate_hz(), None);
        arrivals.push(500, 0);
        for batch in 0..1000 {
            // The 500th comes 7 ms late, together with seven others.
            let late = if (500..508).contains(&batch) { 508 } else { batch };
            arrivals.push(1_000_000 + late * 1000, 10);
        }
        assert!((arrivals.rate_hz().unwrap() - 10_000.0).abs() < 1e-6);
        assert!((arrivals.longest_ms() - 9.0).abs() < 1e-9);
        assert!((arrivals.span_s() - 0.999).abs() < 1e-9);
    }
}
