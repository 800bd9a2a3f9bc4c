//! The times of rows: given, or spaced by the rate.

use slip_core::units::Micros;

/// Which row comes when.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    rate_hz: f32,
    /// The last row that had a time, or the first one.
    origin: Micros,
    /// Rows since then.
    since: u64,
    last: Option<Micros>,
}

impl Clock {
    pub(crate) fn new(rate_hz: f32) -> Self {
        Self { rate_hz, origin: Micros(0), since: 0, last: None }
    }

    /// The time of the next row, which is `t` where it has one; `None` where that is not later than the row before.
    pub(crate) fn next(&mut self, t: Option<u64>) -> Option<Micros> {
        let now = if let (None, Some(_)) = (t, self.last) {
            self.since += 1;
            let seconds = self.since as f64 / f64::from(self.rate_hz);
            self.origin.plus(Micros::from_seconds(seconds))
        } else {
            (self.origin, self.since) = (Micros(t.unwrap_or(0)), 0);
            self.origin
        };
        let before = self.last.replace(now);
        before.is_none_or(|before| now > before).then_some(now)
    }
}
