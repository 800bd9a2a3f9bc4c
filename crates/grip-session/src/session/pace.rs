//! Bounds the force that is sent, whatever the controller wants.

/// What is sent rises by at most the slew rate times the host time that the rows since the command before give
/// ([`Freshness::take_s`](slip_core::freshness::Freshness::take_s)), however many came at once, and not at all while the newest row is old. What
/// the controller wants beyond that is not made up for later.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SlewLimiter {
    /// What was allowed last (N).
    sent_n: Option<f32>,
}

/// What there is for one set point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// Force that the controller wants (N).
    pub(super) force_n: f32,
    /// Measured normal force (N), where a sensor measures it.
    pub(super) applied_n: Option<f32>,
    /// Largest rise (N); `None` where the newest row is too old to raise the force on it.
    pub(super) rise_n: Option<f32>,
}

impl SlewLimiter {
    /// What a new pipeline begins with: the force that was carried on, if one was.
    pub(super) const fn begin(carried_n: Option<f32>) -> Self {
        Self { sent_n: carried_n }
    }

    /// The force to send; `None` where rows are too old and the force of the fingers is not measured.
    pub(super) fn force(&mut self, wanted: &Wanted) -> Option<f32> {
        let first_n = wanted.rise_n.map_or(wanted.applied_n, |_| Some(wanted.force_n));
        let base_n = self.sent_n.or(first_n)?;
        let force_n = wanted.force_n.min(base_n + wanted.rise_n.unwrap_or(0.0));
        self.sent_n = Some(force_n);
        Some(force_n)
    }

    /// What was really sent (N): while its data are stale the link holds the force back.
    pub(super) fn was_held_to(&mut self, force_n: f32) {
        self.sent_n = self.sent_n.map(|allowed_n| allowed_n.min(force_n));
    }
}

#[cfg(test)]
mod tests {
    use super::{SlewLimiter, Wanted};
    use proptest::prelude::*;
    use slip_core::{Arrival, freshness::Freshness, units::Micros};

    /// A limiter with the rows and the host time that it is given.
    struct Sender {
        limiter: SlewLimiter,
        fresh: Freshness,
        slew_n_s: f32,
    }

    impl Sender {
        fn new(carried_n: Option<f32>, slew_n_s: f32) -> Self {
            let fresh = Freshness::new(Micros(1000));
            Self { limiter: SlewLimiter::begin(carried_n), fresh, slew_n_s }
        }

        /// What is sent at `now_us` after a row of pipeline time `row_us`.
        fn send(
            &mut self,
            now_us: u64,
            row_us: u64,
            force_n: f32,
            applied_n: Option<f32>,
            aged: bool,
        ) -> Option<f32> {
            let age = Micros(if aged { 300_000 } else { 0 });
            self.fresh.arrive(Some(Arrival { at: Micros(now_us), age }), Micros(row_us));
            let rise_n = Some(self.slew_n_s * self.fresh.take_s());
            assert_eq!(self.fresh.is_stale(), aged);
            let rise_n = rise_n.filter(|_| !self.fresh.is_stale());
            self.limiter.force(&Wanted { force_n, applied_n, rise_n })
        }

        fn at(&mut self, now_us: u64, force_n: f32, aged: bool) -> f32 {
            self.send(now_us, now_us, force_n, Some(0.5), aged).unwrap()
        }
    }

    #[test]
    fn what_was_gained_on_old_samples_does_not_leap_out() {
        let mut sender = Sender::new(None, 100.0);
        let mut sent = |now_us, force_n, aged| sender.at(now_us, force_n, aged);
        assert_eq!(sent(1_000_000, 1.0, false), 1.0);
        assert_eq!(sent(1_001_000, 1.1, false), 1.1);
        assert_eq!(sent(1_100_000, 9.0, true), 1.1);
        assert_eq!(sent(1_101_000, 0.9, true), 0.9, "less is sent at any time");
        let next = sent(1_102_000, 9.0, false);
        assert!((next - 1.0).abs() < 1e-4, "{next}");
        assert!((sent(1_112_000, 9.0, false) - 2.0).abs() < 1e-4);
        assert!((sent(2_000_000, 9.0, false) - 3.0).abs() < 1e-4, "a gap counts 10 ms");
    }

    #[test]
    fn what_the_link_held_back_does_not_leap_out() {
        let mut sender = Sender::new(None, 100.0);
        sender.at(1_000_000, 1.0, false);
        for ms in 1..50 {
            sender.at(1_000_000 + 1000 * ms, 9.0, false);
            sender.limiter.was_held_to(1.0);
        }
        let next = sender.at(1_050_000, 9.0, false);
        assert!((next - 1.1).abs() < 1e-4, "{next}");
        sender.limiter.was_held_to(5.0);
        assert!(sender.at(1_051_000, 9.0, false) < 1.3, "more than allowed was not sent");
    }

    #[test]
    fn the_first_command_begins_at_what_is_known() {
        let first = |carried_n, applied_n, aged| {
            Sender::new(carried_n, 100.0).send(1_000_000, 1_000_000, 2.0, applied_n, aged)
        };
        assert_eq!(first(None, Some(0.5), false), Some(2.0));
        assert_eq!(first(None, Some(0.5), true), Some(0.5), "what the fingers press with");
        assert_eq!(first(Some(1.5), Some(0.5), false), Some(1.5));
        assert_eq!(first(None, None, true), None);
    }

    proptest! {
        /// Whatever the controller wants and whenever rows come.
        #[test]
        fn the_command_is_bounded_by_host_time(
            carried_n in prop::option::of(0.0_f32..20.0),
            turns in prop::collection::vec((0_u64..400_000, 0.0_f32..60.0, any::<bool>(), 0_u64..50_000, prop::option::of(0.0_f32..60.0)), 1..200)
        ) {
            let mut sender = Sender::new(carried_n, 500.0);
            let (mut now_us, mut last) = (0, carried_n);
            // The command before this host time, and when it was sent: frames that came in one read share the time since then.
            let (mut before, mut before_us) = (carried_n, None);
            let mut last_us = None;
            for (gap_us, force_n, aged, behind_us, held_n) in turns {
                now_us += gap_us / if gap_us % 3 == 0 { 100 } else { 1 };
                if last_us != Some(now_us) {
                    (before, before_us) = (last, last_us);
                }
                let row_us = now_us.saturating_sub(behind_us);
                let Some(sent_n) = sender.send(now_us, row_us, force_n, None, aged) else { continue };
                prop_assert!(sent_n <= force_n);
                if let Some(last_n) = last {
                    prop_assert!(sent_n >= force_n.min(last_n), "a stall lowered it: {last_n} to {sent_n}");
                    prop_assert!(!aged || sent_n <= last_n + 1e-5, "on an old row: {last_n} to {sent_n}");
                }
                if let Some(before_n) = before {
                    let gap_us = (now_us - before_us.unwrap_or(now_us)).min(10_000);
                    let most_n = 500e-6 * gap_us as f32;
                    prop_assert!(sent_n - before_n <= most_n * 1.0001 + 1e-5, "{before_n} to {sent_n} in {gap_us} us");
                }
                let held_n = held_n.unwrap_or(f32::INFINITY);
                sender.limiter.was_held_to(held_n);
                (last, last_us) = (Some(sent_n.min(held_n)), Some(now_us));
            }
        }
    }
}
