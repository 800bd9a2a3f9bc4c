//! Clock of a recording: its times, from the stamps of its rows.
//!
//! Stamps are whole nanoseconds. A counter of 32 bits that begins again is continued; stamps that count from 1970, or begin
//! below 0, are moved to 0, but for those of a column `t_s`, which are the times of its labels too; rows whose stamps are
//! coarser than their steps are [placed](crate::pace).

use slip_core::units::Micros;

use crate::pace::{Pace, PaceFinder, Placer};
use crate::time::TimeUnit;

/// From here on times count from 1970 and are moved to 0 (ns).
const FAR_NS: i64 = 1_000_000_000_000_000;

/// The clock of a file.
#[derive(Clone, Debug)]
pub struct Clock {
    /// The column `t_s`, in seconds.
    own: bool,
    /// When a counter of 32 bits begins again (ns), how often it did, and the last stamp.
    wrap_ns: Option<i64>,
    wraps: u32,
    last_ns: Option<i64>,
    zero_ns: Option<i64>,
    placer: Option<Placer>,
    finder: PaceFinder,
}

impl Clock {
    /// A clock of stamps in `unit`, by which rows are placed where `pace` says so.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "2^32 ms in ns have 52 bits")]
    pub fn new(unit: TimeUnit, own: bool, pace: Option<Pace>) -> Self {
        let wraps = matches!(unit, TimeUnit::Millis | TimeUnit::Micros);
        Self {
            own,
            wrap_ns: wraps.then_some((unit.ns() as i64) << 32),
            wraps: 0,
            last_ns: None,
            zero_ns: None,
            placer: pace.as_ref().and_then(Pace::placer),
            finder: PaceFinder::default(),
        }
    }

    /// The next stamp on a line without wraps.
    ///
    /// # Errors
    /// The last stamp, where this one is before it.
    pub fn unwrapped(&mut self, stamp_ns: i64) -> Result<i64, i64> {
        let wrap_ns = self.wrap_ns.unwrap_or(i64::MAX);
        let wrapped = |wraps: u32| stamp_ns.saturating_add(wrap_ns.saturating_mul(wraps.into()));
        let mut stamp = wrapped(self.wraps);
        if let Some(last) = self.last_ns.filter(|last| stamp < *last) {
            let before = last.saturating_sub(wrap_ns.saturating_mul(self.wraps.into()));
            let full = before / 8 * 9 >= wrap_ns && before < wrap_ns;
            if self.wrap_ns.is_none() || !full || !(0..wrap_ns / 8).contains(&stamp_ns) {
                return Err(last);
            }
            self.wraps += 1;
            stamp = wrapped(self.wraps);
        }
        self.last_ns = Some(stamp);
        Ok(stamp)
    }

    /// The time of the next row.
    ///
    /// # Errors
    /// The last stamp, where this one is before it.
    pub fn time(&mut self, stamp_ns: i64) -> Result<Micros, i64> {
        let stamp = self.unwrapped(stamp_ns)?;
        self.finder.push(stamp);
        let placed = self.placer.as_mut().map_or(stamp, |placer| placer.place(stamp));
        let far = stamp < -500 || (!self.own && stamp >= FAR_NS);
        let zero = *self.zero_ns.get_or_insert(if far { stamp } else { 0 });
        // Halves are rounded up.
        let us = placed.saturating_sub(zero).saturating_add(500).div_euclid(1000);
        Ok(Micros(u64::try_from(us).unwrap_or(0)))
    }

    /// Whether rows are placed.
    #[must_use]
    pub const fn places(&self) -> bool {
        self.placer.is_some()
    }

    /// The pace of all stamps so far; `None` where time never went on.
    #[must_use]
    pub fn pace(&self) -> Option<Pace> {
        self.finder.clone().finish()
    }

    /// What to know of it.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.wraps > 0 {
            notes.push(format!(
                "the counter of the times began again at 2^32, {} times; it is continued",
                self.wraps
            ));
        }
        if let Some(zero) = self.zero_ns.filter(|zero| *zero != 0) {
            let sign = if zero < 0 { "-" } else { "" };
            let (whole, part) =
                (zero.unsigned_abs() / 1_000_000_000, zero.unsigned_abs() % 1_000_000_000);
            notes.push(format!("t = 0 is {sign}{whole}.{part:09} s of the file"));
        }
        notes
    }
}

/// The stamps (ns) of a whole column of times named `name`, with their unit.
///
/// # Errors
/// What is wrong, as a sentence about the column.
pub fn stamps(
    name: &str,
    times: &[f64],
    unit: Option<TimeUnit>,
) -> Result<(TimeUnit, Vec<i64>), String> {
    let unit = unit.map_or_else(|| TimeUnit::of_numbers(times), Ok);
    let unit = unit.map_err(|fault| format!("the times in {name:?} {fault}"))?;
    let mut clock = Clock::new(unit, false, None);
    let stamps = times.iter().enumerate().map(|(row, time)| {
        let place = || format!("row {row} (from 0): the time in {name:?}");
        let ns = unit.to_ns(*time);
        let ns = ns.ok_or_else(|| format!("{} is no number of {}", place(), unit.name()))?;
        clock.unwrapped(ns).map_err(|_| {
            format!(
                "{} goes back; split the file there, or give --rate HZ where it is no time",
                place()
            )
        })
    });
    Ok((unit, stamps.collect::<Result<_, _>>()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_that_begins_again_is_continued() {
        let first = u64::from(u32::MAX) - 2000;
        let at = |k: u64| ((first + 500 * k) % (1 << 32)) as f64;
        let times: Vec<f64> = (0..20).map(at).collect();
        let (unit, stamps) = stamps("micros", &times, None).unwrap();
        assert_eq!(unit, TimeUnit::Micros);
        assert!(stamps.windows(2).all(|pair| pair[1] - pair[0] == 500_000), "{stamps:?}");
        let mut clock = Clock::new(unit, false, None);
        assert!(times.iter().all(|t| clock.time(unit.to_ns(*t).unwrap()).is_ok()));
        assert!(clock.notes()[0].contains("2^32, 1 times"), "{:?}", clock.notes());
        for (before, after) in [(5e9, 0.0), (4e9, 1e9), (100.0, 99.0)] {
            assert!(super::stamps("t", &[0.0, before, after], Some(unit)).is_err(), "{before}");
        }
        assert!(super::stamps("t", &[4.2e9, 3.0], Some(TimeUnit::Seconds)).is_err());
    }

    #[test]
    fn times_from_1970_and_below_0_are_moved_and_those_of_t_s_stay() {
        let first = |own, ns| {
            let mut clock = Clock::new(TimeUnit::Seconds, own, None);
            (clock.time(ns).unwrap().0, clock.notes().len())
        };
        assert_eq!(first(false, 1_700_000_000_000_000_000), (0, 1));
        assert_eq!(first(true, 1_700_000_000_000_000_000), (1_700_000_000_000_000, 0));
        assert_eq!((first(true, -5000), first(false, 1_499)), ((0, 1), (1, 0)));
    }
}
