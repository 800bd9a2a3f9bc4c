//! How old the evidence for a rise of the force may be, and how much host time the rise may use.
//!
//! The controller counts device time. After a stall of the line or of the computer many samples come at once, and what they ask for in
//! sequence would be commanded in one moment. So a rise counts host time: samples that arrive together share the time since the arrival
//! before them, at most `MOST`, plus what of it was left over, at most `SLACK`. And evidence whose age exceeds `FRESH` plus what the
//! line usually takes, plus its own period, raises nothing. The pipeline counts so for what it wants, the session for what it sends.

use crate::{sample::Arrival, units::Micros};

/// Longest time between two arrivals that counts.
const MOST: Micros = Micros(10_000);
/// What may be left over from one arrival to the next: frames come early and late.
const SLACK: Micros = Micros(2000);
/// Age of evidence that still raises the force, on top of the usual age and one period ...
const FRESH: Micros = Micros(20_000);
/// ... which count this much at most.
const USUAL: Micros = Micros(40_000);
/// The usual age is the least one of one to two of these, in which a gap counts `MOST` at most: a few stalls are not usual.
const WINDOW: Micros = Micros(1_000_000);
/// The largest age is forgotten by this share of the time.
const FORGETS: u64 = 10;

/// Age of the evidence, and the host time that it gives the force to rise.
#[derive(Clone, Copy, Debug, Default)]
pub struct Freshness {
    /// From sample to sample.
    period: Micros,
    /// Host time of the latest arrival; `None` before the first and where arrivals are not known.
    at: Option<Micros>,
    /// Device time of the newest sample.
    t: Option<Micros>,
    /// Time since the arrival before, as far as it counts; what of it is left; what the samples of this arrival have and nobody took.
    waited: Micros,
    left: Micros,
    granted: Micros,
    /// For how long the force may rise on the latest sample.
    rise: Micros,
    /// Least age in this window and in the one before, and for how long this one has lasted.
    least: [Option<Micros>; 2],
    lasted: Micros,
    /// The largest age of late.
    longest: Micros,
    stale: bool,
}

impl Freshness {
    /// Nothing is known of a line on which a sample comes every `period`.
    #[must_use]
    pub fn new(period: Micros) -> Self {
        Self { period, ..Self::default() }
    }

    /// A sample of device time `t` arrived so; `None` where that is not known.
    #[inline]
    pub fn arrive(&mut self, arrival: Option<Arrival>, t: Micros) {
        let dt = self.t.map_or(Micros(0), |last| t.since(last));
        self.t = self.t.max(Some(t));
        let Some(Arrival { at, age }) = arrival else {
            self.at = None;
            return;
        };
        if self.at != Some(at) {
            self.begin(at, age);
        }
        self.rise = self.left.min(dt);
        self.left = self.left.since(self.rise);
        self.granted = self.granted.plus(self.rise);
        self.stale = age > self.limit();
    }

    /// Another arrival, of which the first and oldest sample shows the age.
    fn begin(&mut self, at: Micros, age: Micros) {
        let waited = self.at.map_or(Micros(0), |before| at.since(before));
        self.at = Some(at);
        self.waited = waited.min(MOST);
        self.left = self.waited.plus(self.left.min(SLACK));
        self.granted = Micros(0);
        self.longest = self.longest.since(Micros(waited.0 / FORGETS)).max(age.min(USUAL));
        self.lasted = self.lasted.plus(self.waited);
        if self.lasted >= WINDOW {
            let [least, _] = self.least;
            (self.least, self.lasted) = ([None, least], Micros(0));
        }
        let [least, _] = &mut self.least;
        *least = Some(least.map_or(age, |least| least.min(age)));
    }

    /// The clocks are related anew: ages of before mean nothing.
    pub fn forget(&mut self) {
        (self.least, self.lasted) = ([None; 2], Micros(0));
    }

    /// Age up to which evidence may raise the force.
    #[must_use]
    #[inline]
    pub fn limit(&self) -> Micros {
        let usual = self.least.iter().flatten().min().copied().unwrap_or_default();
        FRESH.plus(usual.plus(self.period).min(USUAL))
    }

    /// Whether the latest sample is too old to raise the force on it.
    #[must_use]
    #[inline]
    pub fn is_stale(&self) -> bool {
        self.at.is_some() && self.stale
    }

    /// For how long (s) the force may rise on the latest sample; `None` where arrivals are not known.
    #[must_use]
    #[inline]
    pub fn rise_s(&self) -> Option<f32> {
        self.at.map(|_| seconds(self.rise))
    }

    /// For how long (s) the force may rise on the samples of the latest arrival that were not taken into account yet: in all no longer than since
    /// the arrival before.
    pub fn take_s(&mut self) -> f32 {
        let taken = core::mem::take(&mut self.granted).min(self.waited);
        self.waited = self.waited.since(taken);
        seconds(taken)
    }

    /// The largest age of late (s), 40 ms at most. So much later than the drive makes it a command shows in the samples: what a batch asks for
    /// leaves at its end.
    #[must_use]
    #[inline]
    pub fn line_late_s(&self) -> f32 {
        seconds(self.longest)
    }
}

#[expect(clippy::cast_possible_truncation, reason = "at most 40 ms")]
fn seconds(time: Micros) -> f32 {
    time.as_seconds() as f32
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::Freshness;
    use crate::{sample::Arrival, units::Micros};
    use std::vec::Vec;

    const PERIOD: Micros = Micros(1000);

    /// Samples at 1 kHz that arrive at these host times (ms) with these ages (ms): rise (ms) and staleness of each.
    fn rises(arrivals: &[(u64, u64)]) -> Vec<(f32, bool)> {
        let mut fresh = Freshness::new(PERIOD);
        let give = |(i, (at, age)): (usize, &(u64, u64))| {
            let arrival = Arrival { at: Micros(1000 * at), age: Micros(1000 * age) };
            fresh.arrive(Some(arrival), Micros(1000 * (i as u64 + 1)));
            (1e3 * fresh.rise_s().unwrap(), fresh.is_stale())
        };
        arrivals.iter().enumerate().map(give).collect()
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

    /// What a frame leaves over counts for the next one in the pipeline; what is sent keeps to the host time since the command before.
    #[test]
    fn frames_come_early_and_late_and_each_takes_no_more_than_its_host_time() {
        let mut fresh = Freshness::new(PERIOD);
        let (mut rise_s, mut taken_s) = (0.0, 0.0);
        for frame in 1..=20_u64 {
            let at = Micros(8000 * frame + if frame % 2 == 0 { 1000 } else { 0 });
            for row in 0..8 {
                fresh.arrive(
                    Some(Arrival { at, age: Micros(0) }),
                    Micros(8000 * frame + 1000 * row),
                );
                rise_s += fresh.rise_s().unwrap();
            }
            let s = fresh.take_s();
            assert!(s <= if frame % 2 == 0 { 0.009_01 } else { 0.007_01 }, "{s}");
            assert_eq!(fresh.take_s(), 0.0, "once");
            taken_s += s;
        }
        assert!((rise_s - 0.152).abs() < 1e-6, "all of it but the first frame: {rise_s}");
        assert!((taken_s - 0.143).abs() < 1e-6, "{taken_s}");
    }

    /// Commands at one host time, as of frames that came in one read: they share the time since the read before, whatever they leave over.
    #[test]
    fn commands_of_one_arrival_share_its_time() {
        let mut fresh = Freshness::new(PERIOD);
        let mut taken_s = |at, t| {
            fresh.arrive(Some(Arrival { at: Micros(at), age: Micros(0) }), Micros(t));
            fresh.take_s()
        };
        assert_eq!(taken_s(20_000, 1000), 0.0, "nothing before it");
        assert!((taken_s(26_000, 4000) - 0.003).abs() < 1e-6);
        assert!((taken_s(26_000, 7000) - 0.003).abs() < 1e-6, "a second frame");
        assert_eq!(taken_s(26_000, 17_000), 0.0, "no more than 6 ms, nor what may be left over");
        assert_eq!(taken_s(36_000, 17_000), 0.0, "no newer row");
        assert!((taken_s(36_000, 57_000) - 0.01).abs() < 1e-6, "the newer row is not too late");
    }

    #[test]
    fn a_line_that_is_always_late_is_used_up_to_sixty_milliseconds() {
        let late = |age| rises(&(1..2000).map(|ms| (ms, age)).collect::<Vec<_>>()).pop().unwrap().1;
        assert!(!late(30) && !late(55) && late(61));
    }

    #[test]
    fn the_usual_age_of_a_line_is_learned_and_bounded() {
        assert_eq!(Freshness::default().limit(), Micros(20_000));
        let mut fresh = Freshness::new(PERIOD);
        let mut give = |ms: u64, age_us: u64| {
            fresh.arrive(
                Some(Arrival { at: Micros(1000 * ms), age: Micros(age_us) }),
                Micros(1000 * ms),
            );
            fresh.limit().0
        };
        // A millisecond to 5 ms late, a stall of 300 ms among them.
        let stalls = |ms: u64| if ms % 700 < 300 { 300_000 } else { 1000 + ms % 4000 };
        let limit_us = (1..3000).map(|ms| give(ms, stalls(ms))).last().unwrap();
        assert!((22_000..23_500).contains(&limit_us), "{limit_us}");
        let limit_us = (3000..6000).map(|ms| give(ms, 300_000)).last().unwrap();
        assert_eq!(limit_us, 60_000, "no line is that slow");
        fresh.forget();
        assert_eq!(fresh.limit(), Micros(21_000));
    }

    #[test]
    fn stalls_however_long_are_not_usual() {
        let mut fresh = Freshness::new(PERIOD);
        fresh.arrive(Some(Arrival { at: Micros(0), age: Micros(0) }), Micros(0));
        for i in 1..60 {
            let arrival = Arrival { at: Micros(400_000 * i), age: Micros(400_000) };
            fresh.arrive(Some(arrival), Micros(400_000 * i));
            assert!(fresh.is_stale() && fresh.limit() == Micros(21_000), "{i}");
        }
    }

    #[test]
    fn a_line_in_batches_is_as_late_as_their_first_samples_and_a_stall_is_forgotten() {
        let mut fresh = Freshness::new(PERIOD);
        let mut give = |t: u64, at: u64| {
            let (t, at) = (Micros(1000 * t), Micros(1000 * at));
            fresh.arrive(Some(Arrival { at, age: at.since(t) }), t);
            fresh.line_late_s()
        };
        let batches: Vec<f32> = (1..=160).map(|t: u64| give(t, t.next_multiple_of(16))).collect();
        assert!(batches.iter().all(|late_s| (0.013..=0.016).contains(late_s)), "{batches:?}");
        assert!((161..460).all(|t| give(t, 460) <= 0.04), "a stall");
        let after: Vec<f32> = (460..900).map(|t| give(t, t)).collect();
        assert!(after[100] > 0.02 && after[439] < 1e-6, "{after:?}");
    }

    #[test]
    fn without_arrivals_nothing_is_bounded() {
        let mut fresh = Freshness::new(PERIOD);
        fresh.arrive(None, Micros(5));
        assert_eq!((fresh.rise_s(), fresh.is_stale()), (None, false));
    }
}
