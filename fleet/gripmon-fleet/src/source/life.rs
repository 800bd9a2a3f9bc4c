//! Presence of a gripper: whether it is there, by when it came, spoke and went.

use core::time::Duration;

/// Where states come for so long and no rows, none will.
const ROWLESS: Duration = Duration::from_secs(2);
/// STATE comes five times a second: without one for so long the gripper is silent.
const SILENCE: Duration = Duration::from_secs(2);
/// A gripper that is there is known to be so after this time.
const GREETING: Duration = Duration::from_secs(3);

/// How a gripper is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// It speaks.
    Live,
    /// It is there, and has said nothing for so long.
    Silent(Duration),
    /// Nothing is known of it yet.
    Awaited,
    /// It is not there.
    Gone,
}

/// What is known of its presence. Times are those of one clock.
#[derive(Clone, Copy, Debug)]
pub(super) struct Life {
    begun: Duration,
    alive: bool,
    first: Option<Duration>,
    last: Option<Duration>,
}

impl Life {
    /// Nothing was received yet.
    pub(super) const fn new(now: Duration) -> Self {
        Self { begun: now, alive: false, first: None, last: None }
    }

    /// It is there, or gone.
    pub(super) const fn turn(&mut self, alive: bool) {
        self.alive = alive;
        (self.first, self.last) = (None, None);
    }

    /// It has spoken. What arrives behind its farewell was on the way.
    pub(super) fn speak(&mut self, now: Duration) {
        if self.alive {
            self.first.get_or_insert(now);
            self.last = Some(now);
        }
    }

    /// Whether rows would have come by now.
    pub(super) fn has_spoken_long(&self, now: Duration) -> bool {
        self.first.is_some_and(|first| now.saturating_sub(first) >= ROWLESS)
    }

    /// How it is now.
    pub(super) fn standing(&self, now: Duration) -> Standing {
        match self.last.map(|last| now.saturating_sub(last)) {
            Some(silent) if silent < SILENCE => Standing::Live,
            Some(silent) => Standing::Silent(silent),
            None if self.alive || now.saturating_sub(self.begun) < GREETING => Standing::Awaited,
            None => Standing::Gone,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Duration, Life, Standing};

    #[test]
    fn what_comes_behind_the_farewell_does_not_bring_a_gripper_back() {
        let at = Duration::from_secs;
        let mut life = Life::new(at(0));
        assert_eq!(
            (life.standing(at(1)), life.standing(at(4))),
            (Standing::Awaited, Standing::Gone)
        );
        life.turn(true);
        assert_eq!(life.standing(at(9)), Standing::Awaited);
        life.speak(at(10));
        assert!(!life.has_spoken_long(at(11)) && life.has_spoken_long(at(12)));
        assert_eq!(life.standing(at(11)), Standing::Live);
        assert_eq!(life.standing(at(15)), Standing::Silent(at(5)));
        life.turn(false);
        life.speak(at(16));
        assert_eq!(life.standing(at(16)), Standing::Gone);
        life.turn(true);
        life.speak(at(20));
        assert_eq!(life.standing(at(20)), Standing::Live);
    }
}
