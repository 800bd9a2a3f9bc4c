//! Failures in, how long to wait before the next attempt out.

use core::time::Duration;

const FIRST: Duration = Duration::from_millis(250);
const LONGEST: Duration = Duration::from_secs(5);

/// Pauses that double up to five seconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Retry {
    next: Duration,
}

impl Default for Retry {
    fn default() -> Self {
        Self { next: FIRST }
    }
}

impl Retry {
    /// The pause after another failure.
    pub(super) fn failed(&mut self) -> Duration {
        let pause = self.next;
        self.next = (2 * pause).min(LONGEST);
        pause
    }

    /// It worked: the next failure is a first one.
    pub(super) fn worked(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::Retry;

    #[test]
    fn pauses_grow_to_a_bound_and_begin_afresh() {
        let mut retry = Retry::default();
        let pauses: Vec<u128> = (0..7).map(|_| retry.failed().as_millis()).collect();
        assert_eq!(pauses, [250, 500, 1000, 2000, 4000, 5000, 5000]);
        retry.worked();
        assert_eq!(retry.failed().as_millis(), 250);
    }
}
