//! Device clock that runs in the time of the rows, from when they came.
//!
//! The clock runs with the host's. It goes forward at once where a row is ahead of it, and slows down where every row of a second was
//! behind it: so it follows a source that is fast or slow, and a row that is late stays late. Rows that stay behind by more than
//! [`JUMP_US`] are no late ones: their source has stood still, and their times go on from the clock. A source whose rows take
//! another time than their ticks in two seconds one after the other has another rate.

/// Rows that are all behind for this long (us) move the clock.
const WINDOW_US: u64 = 1_000_000;
/// Rows that stay this far behind (us) come from a source that had stopped.
const JUMP_US: u64 = 100_000;
/// How far (us) rows may be ahead at once, as after a pause of the line.
const AHEAD_US: u64 = 250_000;
/// Rates of two windows that agree within this are one rate, and one that is further than this from the given one is another.
const SAME_RATE: f64 = 0.02;
/// How much faster than its rate a live source may be (1/n).
const FASTER: u64 = 10;

/// What becomes of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Placed {
    /// It is taken now.
    Now,
    /// It is ahead of real time, and due at this host time (us).
    Early(u64),
    /// It is taken now, and times of rows go on this much later (us).
    After(u64),
}

/// The clock.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowClock {
    /// Whether rows that are ahead of real time can wait.
    holds: bool,
    /// Host time and tick (us) at the last look.
    host_us: u64,
    tick: u64,
    /// How far the clock is to be put back by running slowly (us).
    slow_us: u64,
    /// How far (us) it may still go forward.
    budget_us: u64,
    /// Rows were once so far ahead that they had to wait: the source is a file.
    paced: bool,
    /// Until when (host us), and by how much every row (us) since then was behind.
    window_us: u64,
    behind_us: u64,
    /// Host time and tick (us) of the row with which the window began; time of the rows over time of the host in the last two.
    began: [u64; 2],
    paces: [f64; 2],
}

impl RowClock {
    /// Starts with the first row, of `tick` (us).
    pub(super) fn new(now_us: u64, tick: u64, holds: bool) -> Self {
        Self {
            holds,
            host_us: now_us,
            tick,
            slow_us: 0,
            budget_us: AHEAD_US,
            paced: false,
            window_us: now_us + WINDOW_US,
            behind_us: u64::MAX,
            began: [now_us, tick],
            paces: [1.0; 2],
        }
    }

    /// The tick at this host time; never less than before.
    pub(super) fn tick(&mut self, now_us: u64) -> u64 {
        let passed = now_us.saturating_sub(self.host_us);
        self.host_us = self.host_us.max(now_us);
        let slower = self.slow_us.min(passed / 2);
        self.slow_us -= slower;
        self.tick += passed - slower;
        if !self.paced {
            self.budget_us = (self.budget_us + passed / FASTER).min(AHEAD_US);
        }
        self.tick
    }

    /// Whether rows wait because they came faster than their rate.
    pub(super) fn is_paced(&self) -> bool {
        self.paced
    }

    /// Time of the rows over time of the host where that is another than 1: of rows without a time, the rate over the given one.
    pub(super) fn wrong_pace(&self) -> Option<f64> {
        let [before, last] = self.paces;
        let pace = 0.5 * (before + last);
        let same = (before - last).abs() < SAME_RATE * pace;
        (same && (pace - 1.0).abs() > SAME_RATE && !self.paced).then_some(pace)
    }

    /// Places a row of `tick` that is there at `now_us`.
    pub(super) fn place(&mut self, now_us: u64, tick: u64) -> Placed {
        let now = self.tick(now_us);
        let ahead = tick.saturating_sub(now);
        if ahead > 0 {
            if self.holds && ahead > self.budget_us {
                (self.paced, self.budget_us) = (true, 0);
                return Placed::Early(now_us + ahead);
            }
            self.budget_us = self.budget_us.saturating_sub(ahead);
            self.tick += ahead;
        }
        self.judge(now_us, tick, now.saturating_sub(tick))
    }

    /// Takes in how late (us) the row of `tick` was.
    fn judge(&mut self, now_us: u64, tick: u64, behind_us: u64) -> Placed {
        self.behind_us = self.behind_us.min(behind_us);
        if now_us < self.window_us {
            return Placed::Now;
        }
        let behind_us = core::mem::replace(&mut self.behind_us, u64::MAX);
        self.window_us = now_us + WINDOW_US;
        let [began_us, began_tick] = core::mem::replace(&mut self.began, [now_us, tick]);
        let pace =
            tick.saturating_sub(began_tick) as f64 / now_us.saturating_sub(began_us).max(1) as f64;
        self.paces = [self.paces[1], pace];
        if behind_us > JUMP_US {
            self.began[1] += behind_us;
            return Placed::After(behind_us);
        }
        self.slow_us = behind_us;
        Placed::Now
    }
}

#[cfg(test)]
mod tests {
    use super::{Placed, RowClock};

    /// Rows of `period_us` that come every `every_us`, for `seconds`: lateness of the last one (us), whether it had to wait.
    fn follow(period_us: u64, every_us: u64, seconds: u64) -> (u64, bool) {
        let mut clock = RowClock::new(0, 0, true);
        let mut late = 0;
        for row in 1..=seconds * 1_000_000 / every_us {
            match clock.place(row * every_us, row * period_us) {
                Placed::Now => late = clock.tick(row * every_us) - row * period_us,
                Placed::Early(_) => return (0, true),
                Placed::After(_) => panic!("no row is that late"),
            }
        }
        (late, clock.is_paced())
    }

    #[test]
    fn it_follows_a_source_that_is_fast_or_slow() {
        for (period_us, every_us) in [(625, 625), (625, 620), (625, 600), (625, 630), (625, 640)] {
            let (late, paced) = follow(period_us, every_us, 60);
            assert!(!paced && late < 60_000, "{period_us} every {every_us}: {late}");
        }
        assert_eq!(follow(625, 500, 60), (0, true), "a quarter too fast is no clock error");
    }

    #[test]
    fn another_rate_is_measured_and_a_source_that_stood_still_has_none() {
        for (every_us, wrong) in [(625, None), (630, None), (800, Some(0.781)), (500, Some(1.25))] {
            let mut clock = RowClock::new(0, 0, false);
            let mut after = 0;
            for row in 1..=5_000_000 / every_us {
                if let Placed::After(by_us) = clock.place(every_us * row, 625 * row + after) {
                    after += by_us;
                }
            }
            let pace = clock.wrong_pace().map(|pace| (1e3 * pace).round() / 1e3);
            assert_eq!(pace, wrong, "625 us every {every_us} us");
        }
        let mut clock = RowClock::new(0, 0, true);
        (1..=1600).for_each(|row| _ = clock.place(625 * row, 625 * row));
        let mut after = 0;
        for row in 1601..=6400 {
            if let Placed::After(by_us) = clock.place(5_000_000 + 625 * row, 625 * row + after) {
                after += by_us;
            }
            assert_eq!(clock.wrong_pace(), None, "row {row}");
        }
        assert!(after > 4_900_000, "{after}");
    }

    #[test]
    fn a_file_runs_in_real_time() {
        let mut clock = RowClock::new(0, 0, true);
        let (mut now_us, mut row) = (0, 1);
        while row < 16_000 {
            match clock.place(now_us, 625 * row) {
                Placed::Early(due_us) => now_us = due_us,
                _ => row += 1,
            }
        }
        assert!((9_700_000..=9_800_000).contains(&now_us), "{now_us}: 10 s less what may be ahead");
        // Without a way to make it wait it is taken as it comes.
        let mut clock = RowClock::new(0, 0, false);
        assert!((1..16_000).all(|row| clock.place(0, 625 * row) == Placed::Now));
    }

    #[test]
    fn a_row_that_is_late_stays_late_and_a_source_that_stood_still_is_followed() {
        let mut clock = RowClock::new(0, 0, true);
        for row in 1..=1600 {
            assert_eq!(clock.place(625 * row, 625 * row), Placed::Now);
        }
        // 300 ms later those of 300 ms at once: the newest is in time.
        for row in 1601..=2080 {
            assert_eq!(clock.place(1_300_000, 625 * row), Placed::Now);
        }
        assert_eq!(clock.tick(1_300_000), 1_300_000);
        // 5 s of silence, and then on where it stopped.
        let mut after = 0;
        for row in 2081..=6000 {
            let now_us = 5_000_000 + 625 * row;
            match clock.place(now_us, 625 * row + after) {
                Placed::After(by_us) => after += by_us,
                placed => assert_eq!(placed, Placed::Now),
            }
        }
        assert!((4_900_000..5_100_000).contains(&after), "{after}");
    }
}
