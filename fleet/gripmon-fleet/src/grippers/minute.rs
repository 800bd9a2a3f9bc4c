//! Times of what happened in, how many of them lie in the last minute out.

/// Counts of the last sixty seconds, one for each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Minute {
    counts: [u16; 60],
    /// The newest second that was counted.
    newest: u64,
}

impl Default for Minute {
    fn default() -> Self {
        Self { counts: [0; 60], newest: 0 }
    }
}

impl Minute {
    /// Something happened at this time (s).
    pub(super) fn count(&mut self, at_s: f64) {
        let second = number(at_s).max(self.newest);
        for passed in (self.newest + 1..=second).take(60) {
            self.counts[place(passed)] = 0;
        }
        self.newest = second;
        let count = &mut self.counts[place(second)];
        *count = count.saturating_add(1);
    }

    /// How often it happened in the minute before this time (s).
    pub(super) fn before(&self, now_s: f64) -> u32 {
        let now = number(now_s).max(self.newest);
        let first = (now + 1).saturating_sub(60);
        let oldest_kept = (self.newest + 1).saturating_sub(60);
        let seconds = first.max(oldest_kept)..=self.newest;
        seconds.map(|second| u32::from(self.counts[place(second)])).sum()
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
const fn number(at_s: f64) -> u64 {
    at_s as u64
}

const fn place(second: u64) -> usize {
    (second % 60) as usize
}

#[cfg(test)]
mod tests {
    use super::Minute;

    #[test]
    fn what_is_older_than_a_minute_is_not_counted() {
        let mut minute = Minute::default();
        assert_eq!(minute.before(1e6), 0);
        for at_s in [0.5, 0.9, 10.0, 59.9, 60.1] {
            minute.count(at_s);
        }
        assert_eq!(
            [60.1, 69.9, 70.1, 119.9, 121.0].map(|now_s| minute.before(now_s)),
            [3, 3, 2, 1, 0]
        );
        minute.count(1000.0);
        assert_eq!((minute.before(1000.0), minute.before(1060.0)), (1, 0));
        // Three in every second of ten minutes.
        for k in 0..1800 {
            minute.count(2000.0 + f64::from(k / 3));
        }
        assert_eq!(minute.before(2599.0), 180);
    }
}
