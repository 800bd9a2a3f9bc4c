//! Arrival times in; for how long the force may rise on a sample, and whether the sample is too old for that, out.
//!
//! The controller counts device time. After a stall of the line or of the computer many samples come at once, and what they ask for in
//! sequence would be commanded in one moment. So a rise counts host time: the samples that arrive together share the time since the arrival
//! before them, at most [`MOST`], plus what of it was left over, at most [`SLACK`]. And a sample whose age exceeds [`FRESH`] plus what the
//! line usually takes, plus its own period, raises nothing.

use crate::{
    sample::Arrival,
    units::{Hertz, Micros},
};

/// Longest time between two arrivals that counts.
const MOST: Micros = Micros(10_000);
/// What may be left over from one arrival to the next: frames come early and late.
const SLACK: Micros = Micros(2000);
/// Age of evidence that still raises the force, on top of the usual delay and one period ...
const FRESH: Micros = Micros(20_000);
/// ... which count this much at most.
const USUAL: Micros = Micros(40_000);
/// The usual age follows a longer one by this share of the time.
const FOLLOWS: u64 = 1000;
/// The largest age is forgotten by this share of the time.
const FORGETS: u64 = 10;

/// Samples that arrive together, and those before them.
#[derive(Clone, Copy, Debug)]
pub(super) struct HostTime {
    period: Micros,
    /// Host time of the latest arrival; `None` before the first and where arrivals are not known.
    at: Option<Micros>,
    /// Device time of the sample before it, and for how much device time from there on the force may rise.
    from: Micros,
    allowed: Micros,
    /// The smallest age of late, and the largest.
    usual: Micros,
    longest: Micros,
    stale: bool,
}

impl HostTime {
    pub(super) fn new(rate: Hertz) -> Self {
        Self {
            period: Micros::from_ms(1e3 / rate.0),
            at: None,
            from: Micros(0),
            allowed: MOST,
            usual: USUAL,
            longest: Micros(0),
            stale: false,
        }
    }

    /// The next sample arrived so; `last` is the device time of the one before.
    #[inline]
    pub(super) fn arrive(&mut self, arrival: Option<Arrival>, last: Option<Micros>) {
        let Some(Arrival { at, age }) = arrival else {
            self.at = None;
            return;
        };
        if self.at != Some(at) {
            self.begin(at, last.unwrap_or_default());
            self.usual = self.usual.min(age);
            self.longest = self.longest.max(age.min(USUAL));
        }
        self.stale = age > FRESH.plus(self.usual.plus(self.period).min(USUAL));
    }

    fn begin(&mut self, at: Micros, last: Micros) {
        let waited = self.at.map_or(MOST, |before| at.since(before));
        let left = self.allowed.since(last.since(self.from)).min(SLACK);
        self.allowed = waited.min(MOST).plus(left);
        self.usual = self.usual.plus(Micros(waited.0 / FOLLOWS));
        self.longest = self.longest.since(Micros(waited.0 / FORGETS));
        (self.at, self.from) = (Some(at), last);
    }

    /// The largest age of late (s), 40 ms at most. So much later than the drive makes it a command shows in the samples: what a batch asks for
    /// leaves at its end.
    #[inline]
    pub(super) fn late_s(&self) -> f32 {
        #[expect(clippy::cast_possible_truncation, reason = "at most 40 ms")]
        let late_s = self.longest.as_seconds() as f32;
        late_s
    }

    /// Whether the latest sample is too old to raise the force on it.
    #[inline]
    pub(super) fn is_stale(&self) -> bool {
        self.at.is_some() && self.stale
    }

    /// For how long (s) the force may rise on a sample at device time `t` that follows one `dt` before; `None` where arrivals are not known.
    #[inline]
    pub(super) fn rise_s(&self, t: Micros, dt: Micros) -> Option<f32> {
        self.at?;
        let used = Micros(t.0.saturating_sub(dt.0)).since(self.from);
        #[expect(clippy::cast_possible_truncation, reason = "at most 12 ms")]
        let rise_s = self.allowed.since(used).min(dt).as_seconds() as f32;
        Some(rise_s)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::HostTime;
    use crate::{
        sample::Arrival,
        units::{Hertz, Micros},
    };
    use std::vec::Vec;

    /// Samples at 1 kHz that arrive at these host times (ms) with these ages (ms): rise (ms) and staleness of each.
    fn rises(arrivals: &[(u64, u64)]) -> Vec<(f32, bool)> {
        let mut host = HostTime::new(Hertz(1000.0));
        let mut last = None;
        let mut out = Vec::new();
        for (i, (at, age)) in arrivals.iter().enumerate() {
            let t = Micros(1000 * (i as u64 + 1));
            host.arrive(Some(Arrival { at: Micros(1000 * at), age: Micros(1000 * age) }), last);
            let dt = last.map_or(Micros(0), |last| t.since(last));
            out.push((1e3 * host.rise_s(t, dt).unwrap(), host.is_stale()));
            last = Some(t);
        }
        out
    }

    #[test]
    fn samples_in_time_count_whole_and_a_burst_counts_ten_milliseconds() {
        let mut arrivals: Vec<(u64, u64)> = (1..100).map(|ms| (ms, 1)).collect();
        arrivals.extend((100..400).map(|ms| (400, 401 - ms)));
        let out = rises(&arrivals);
        assert!(out[1..99].iter().all(|&(rise, stale)| (rise - 1.0).abs() < 1e-3 && !stale));
        let burst: f32 = out[99..].iter().map(|(rise, _)| rise).sum();
        assert!((9.9..=12.1).contains(&burst), "{burst}");
        let fresh = out[99..].iter().filter(|(_, stale)| !stale).count();
        assert!(
            (20..=23).contains(&fresh),
            "{fresh}: 20 ms, a period and what the line usually takes"
        );
    }

    #[test]
    fn a_line_that_is_always_late_is_used_up_to_sixty_milliseconds() {
        let late = |age| rises(&(1..2000).map(|ms| (ms, age)).collect::<Vec<_>>()).pop().unwrap().1;
        assert!(!late(30) && !late(55) && late(61));
    }

    #[test]
    fn a_line_in_batches_is_as_late_as_their_first_samples_and_a_stall_is_forgotten() {
        let mut host = HostTime::new(Hertz(1000.0));
        let mut give = |t: u64, at: u64| {
            let (t, at) = (Micros(1000 * t), Micros(1000 * at));
            host.arrive(Some(Arrival { at, age: at.since(t) }), Some(t));
            host.late_s()
        };
        let batches: Vec<f32> = (1..=160).map(|t: u64| give(t, t.next_multiple_of(16))).collect();
        assert!(batches.iter().all(|late_s| (0.013..=0.016).contains(late_s)), "{batches:?}");
        assert!((161..460).all(|t| give(t, 460) <= 0.04), "a stall");
        let after: Vec<f32> = (460..900).map(|t| give(t, t)).collect();
        assert!(after[100] > 0.02 && after[439] < 1e-6, "{after:?}");
    }

    #[test]
    fn without_arrivals_nothing_is_bounded() {
        let mut host = HostTime::new(Hertz(1000.0));
        host.arrive(None, None);
        assert_eq!((host.rise_s(Micros(5), Micros(1)), host.is_stale()), (None, false));
    }
}
