//! The force that the controller wants, host time, the newest row and its age in; the force that is sent out.

/// A gap between two commands counts at most so long (us), or as long as a frame lasts where that is longer.
const LONGEST_GAP_US: u64 = 10_000;
/// Rows older than this (us), beyond what their line usually takes, raise nothing.
const TOO_OLD_US: u64 = 20_000;
/// Usual transit and period of a line count at most so much (us).
const MOST_USUAL_US: u64 = 40_000;
/// The usual transit and period are the least of one to two of these (us).
const WINDOW_US: u64 = 1_000_000;

/// Bounds what is sent: it rises by at most the slew rate times the host time since the command before, however many rows came at once, or
/// times the time that these rows cover where that is less, and not at all while the newest row is old. What the controller wants beyond that is not made up for later.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SlewLimiter {
    /// What was allowed last (N).
    sent_n: Option<f32>,
    /// Host time of that, and pipeline time of the newest row then (us).
    at_us: Option<(u64, u64)>,
}

/// What there is for one set point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// Force that the controller wants (N).
    pub(super) force_n: f32,
    /// Measured normal force (N), where a sensor measures it.
    pub(super) applied_n: Option<f32>,
    /// Host time (us).
    pub(super) now_us: u64,
    /// Pipeline time of the newest row (us).
    pub(super) row_us: u64,
    /// Whether the newest row is too old to raise the force on it.
    pub(super) aged: bool,
    /// Time from frame to frame (us).
    pub(super) period_us: u64,
    /// Largest rise (N/s).
    pub(super) slew_n_s: f32,
}

impl SlewLimiter {
    /// What a new pipeline begins with: the force that was carried on, if one was.
    pub(super) const fn begin(carried_n: Option<f32>) -> Self {
        Self { sent_n: carried_n, at_us: None }
    }

    /// The force to send; `None` where rows are too old and the force of the fingers is not measured.
    pub(super) fn force(&mut self, wanted: &Wanted) -> Option<f32> {
        let first_n = if wanted.aged { wanted.applied_n } else { Some(wanted.force_n) };
        let base_n = self.sent_n.or(first_n)?;
        let most_us = wanted.period_us.clamp(LONGEST_GAP_US, MOST_USUAL_US);
        let (now_us, row_us) = (wanted.now_us, wanted.row_us);
        let (at_us, last_us) = self.at_us.unwrap_or((now_us, row_us));
        // Rows that cover less time than has passed give no more evidence than that.
        let gap_us = now_us.saturating_sub(at_us).min(row_us.saturating_sub(last_us)).min(most_us);
        #[expect(clippy::cast_precision_loss, reason = "40 ms at most")]
        let rise_n = if wanted.aged { 0.0 } else { wanted.slew_n_s * (gap_us as f32 * 1e-6) };
        let force_n = wanted.force_n.min(base_n + rise_n);
        (self.sent_n, self.at_us) = (Some(force_n), Some((now_us, row_us)));
        Some(force_n)
    }

    /// What was really sent (N): while its data are stale the link holds the force back.
    pub(super) fn was_held_to(&mut self, force_n: f32) {
        self.sent_n = self.sent_n.map(|allowed_n| allowed_n.min(force_n));
    }
}

/// Learns how old the newest row of a frame usually is, and how much time a frame covers.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Transit {
    since_us: u64,
    /// Least age and least period (us) in this window and in the one before.
    windows: [Option<(u64, u64)>; 2],
    /// Pipeline time of the newest row of the frame before (us).
    last_us: Option<u64>,
    period_us: u64,
}

impl Transit {
    /// A frame came in at `now_us`; its newest row is of pipeline time `t_us` and, where the clocks are related, so old.
    pub(super) fn learn(&mut self, now_us: u64, t_us: u64, age_us: Option<u64>) {
        let period_us = self.last_us.replace(t_us).map(|last_us| t_us.saturating_sub(last_us));
        self.period_us = period_us.unwrap_or(self.period_us);
        let Some(age_us) = age_us else { return };
        if now_us.saturating_sub(self.since_us) >= WINDOW_US {
            self.since_us = now_us;
            self.windows = [None, self.windows[0].or(self.windows[1])];
        }
        let seen = (age_us, period_us.unwrap_or(u64::MAX));
        let least =
            self.windows[0].map_or(seen, |least| (least.0.min(seen.0), least.1.min(seen.1)));
        self.windows[0] = Some(least);
    }

    /// The clocks are related anew: ages of before mean nothing.
    pub(super) fn forget(&mut self) {
        *self = Self { period_us: self.period_us, ..Self::default() };
    }

    /// Age (us) up to which the newest row may raise the force.
    pub(super) fn limit_us(&self) -> u64 {
        let known = self.windows.iter().flatten();
        let (age_us, period_us) = known
            .copied()
            .reduce(|a, b| (a.0.min(b.0), a.1.min(b.1)))
            .unwrap_or((0, self.period_us));
        let period_us = if period_us == u64::MAX { self.period_us } else { period_us };
        TOO_OLD_US + age_us.saturating_add(period_us).min(MOST_USUAL_US)
    }

    /// Time from frame to frame (us).
    pub(super) const fn period_us(&self) -> u64 {
        self.period_us
    }
}

#[cfg(test)]
mod tests {
    use super::{SlewLimiter, Transit, Wanted};
    use proptest::prelude::*;

    fn at(now_us: u64, force_n: f32, aged: bool) -> Wanted {
        let row_us = now_us;
        Wanted {
            force_n,
            applied_n: Some(0.5),
            now_us,
            row_us,
            aged,
            period_us: 1000,
            slew_n_s: 100.0,
        }
    }

    #[test]
    fn what_was_gained_on_old_samples_does_not_leap_out() {
        let mut limiter = SlewLimiter::begin(None);
        let mut sent = |wanted| limiter.force(&wanted).unwrap();
        assert_eq!(sent(at(1_000_000, 1.0, false)), 1.0);
        assert_eq!(sent(at(1_001_000, 1.1, false)), 1.1);
        assert_eq!(sent(at(1_100_000, 9.0, true)), 1.1);
        assert_eq!(sent(at(1_101_000, 0.9, true)), 0.9, "less is sent at any time");
        let next = sent(at(1_102_000, 9.0, false));
        assert!((next - 1.0).abs() < 1e-4, "{next}");
        assert!((sent(at(1_112_000, 9.0, false)) - 2.0).abs() < 1e-4);
        assert!((sent(at(2_000_000, 9.0, false)) - 3.0).abs() < 1e-4, "a gap counts 10 ms");
    }

    #[test]
    fn what_the_link_held_back_does_not_leap_out() {
        let mut limiter = SlewLimiter::begin(None);
        limiter.force(&at(1_000_000, 1.0, false)).unwrap();
        for ms in 1..50 {
            limiter.force(&at(1_000_000 + 1000 * ms, 9.0, false)).unwrap();
            limiter.was_held_to(1.0);
        }
        let next = limiter.force(&at(1_050_000, 9.0, false)).unwrap();
        assert!((next - 1.1).abs() < 1e-4, "{next}");
        limiter.was_held_to(5.0);
        assert!(
            limiter.force(&at(1_051_000, 9.0, false)).unwrap() < 1.3,
            "more than allowed was not sent"
        );
    }

    #[test]
    fn the_first_command_begins_at_what_is_known() {
        let first = |carried_n, wanted| SlewLimiter::begin(carried_n).force(&wanted);
        assert_eq!(first(None, at(1_000_000, 2.0, false)), Some(2.0));
        assert_eq!(first(None, at(1_000_000, 2.0, true)), Some(0.5), "what the fingers press with");
        assert_eq!(first(Some(1.5), at(1_000_000, 2.0, false)), Some(1.5));
        let blind = Wanted { applied_n: None, ..at(1_000_000, 2.0, true) };
        assert_eq!(first(None, blind), None);
    }

    #[test]
    fn transit_and_period_of_a_line_are_learned_and_bounded() {
        let mut transit = Transit::default();
        assert_eq!(transit.limit_us(), 20_000);
        for ms in 1..3000 {
            // A millisecond to 5 ms late, a stall of 300 ms among them.
            let age_us = if ms % 700 < 300 { 300_000 } else { 1000 + ms % 4000 };
            transit.learn(1000 * ms, 1000 * ms, Some(age_us));
        }
        assert!((22_000..23_500).contains(&transit.limit_us()), "{}", transit.limit_us());
        for ms in 3000..6000 {
            transit.learn(1000 * ms, 1000 * ms, Some(300_000));
        }
        assert_eq!(transit.limit_us(), 60_000, "no line is that slow");
    }

    proptest! {
        /// Whatever the controller wants and whenever rows come.
        #[test]
        fn the_command_is_bounded_by_host_time(
            carried_n in prop::option::of(0.0_f32..20.0),
            turns in prop::collection::vec((0_u64..400_000, 0.0_f32..60.0, any::<bool>(), 0_u64..50_000, prop::option::of(0.0_f32..60.0)), 1..200)
        ) {
            let mut limiter = SlewLimiter::begin(carried_n);
            let (mut now_us, mut last) = (0, carried_n);
            let mut last_us = None;
            for (gap_us, force_n, aged, period_us, held_n) in turns {
                now_us += gap_us / if gap_us % 3 == 0 { 100 } else { 1 };
                let row_us = now_us.saturating_sub(period_us);
                let wanted =
                    Wanted { force_n, applied_n: None, now_us, row_us, aged, period_us, slew_n_s: 500.0 };
                let Some(sent_n) = limiter.force(&wanted) else { continue };
                prop_assert!(sent_n <= force_n);
                if let Some(before_n) = last {
                    prop_assert!(sent_n >= force_n.min(before_n), "a stall lowered it: {before_n} to {sent_n}");
                    let gap_us = (now_us - last_us.unwrap_or(now_us)).min(period_us.clamp(10_000, 40_000));
                    let most_n = if aged { 0.0 } else { 500e-6 * gap_us as f32 };
                    prop_assert!(sent_n - before_n <= most_n * 1.0001 + 1e-5, "{before_n} to {sent_n} in {gap_us} us");
                }
                let held_n = held_n.unwrap_or(f32::INFINITY);
                limiter.was_held_to(held_n);
                (last, last_us) = (Some(sent_n.min(held_n)), Some(now_us));
            }
        }
    }
}
