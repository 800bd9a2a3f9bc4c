//! The force that the controller wants, sample time and its age in; the force that is sent out.

/// Keeps what is sent within the slew rate over the samples in between. The controller does so by itself; but while its samples are too old
/// to act on, what is sent stands still and the controller goes on, and what it has gained meanwhile must not leap out at once.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pace {
    /// What was allowed last (N).
    sent_n: Option<f32>,
    /// Device time of the sample it was allowed for (s).
    at_s: f64,
}

/// What there is for one set point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    /// Force that the controller wants (N).
    pub(super) force_n: f32,
    /// Measured normal force (N), where a sensor measures it.
    pub(super) applied_n: Option<f32>,
    /// Device time of the newest sample (s).
    pub(super) at_s: f64,
    /// Whether that sample is too old to raise the force on it.
    pub(super) aged: bool,
    /// Largest rise (N/s).
    pub(super) slew_n_s: f32,
}

impl Pace {
    /// What a new pipeline begins with: the force that was carried on, if one was.
    pub(super) const fn begin(carried_n: Option<f32>) -> Self {
        Self { sent_n: carried_n, at_s: f64::INFINITY }
    }

    /// The force to send; `None` where samples are too old and nothing says what the fingers press with.
    pub(super) fn force(&mut self, wanted: &Wanted) -> Option<f32> {
        let first_n = if wanted.aged { wanted.applied_n } else { Some(wanted.force_n) };
        let base_n = self.sent_n.or(first_n)?;
        #[expect(clippy::cast_possible_truncation, reason = "seconds between two frames")]
        let dt_s = (wanted.at_s - self.at_s).max(0.0) as f32;
        let rise_n = if wanted.aged { 0.0 } else { wanted.slew_n_s * dt_s };
        let force_n = wanted.force_n.min(base_n + rise_n);
        (self.sent_n, self.at_s) = (Some(force_n), wanted.at_s);
        Some(force_n)
    }

    /// What was really sent (N): while its data are stale the link holds the force, and what it held back must not leap out either.
    pub(super) fn was_held_to(&mut self, force_n: f32) {
        self.sent_n = self.sent_n.map(|allowed_n| allowed_n.min(force_n));
    }
}

#[cfg(test)]
mod tests {
    use super::{Pace, Wanted};

    fn at(at_s: f64, force_n: f32, aged: bool) -> Wanted {
        Wanted { force_n, applied_n: Some(0.5), at_s, aged, slew_n_s: 100.0 }
    }

    #[test]
    fn what_was_gained_on_old_samples_does_not_leap_out() {
        let mut pace = Pace::begin(None);
        let mut sent = |wanted| pace.force(&wanted).unwrap();
        assert_eq!(sent(at(1.000, 1.0, false)), 1.0);
        assert_eq!(sent(at(1.001, 1.1, false)), 1.1);
        assert_eq!(sent(at(1.100, 9.0, true)), 1.1);
        assert_eq!(sent(at(1.101, 0.9, true)), 0.9, "less is sent at any time");
        let next = sent(at(1.102, 9.0, false));
        assert!((next - 1.0).abs() < 1e-4, "{next}");
        assert!((sent(at(1.112, 9.0, false)) - 2.0).abs() < 1e-4);
    }

    #[test]
    fn what_the_link_held_back_does_not_leap_out() {
        let mut pace = Pace::begin(None);
        pace.force(&at(1.0, 1.0, false)).unwrap();
        for ms in 1..50 {
            pace.force(&at(1.0 + 0.001 * f64::from(ms), 9.0, false)).unwrap();
            pace.was_held_to(1.0);
        }
        let next = pace.force(&at(1.050, 9.0, false)).unwrap();
        assert!((next - 1.1).abs() < 1e-4, "{next}");
        pace.was_held_to(5.0);
        assert!(
            pace.force(&at(1.051, 9.0, false)).unwrap() < 1.3,
            "more than allowed was not sent"
        );
    }

    #[test]
    fn the_first_command_begins_at_what_is_known() {
        let first = |carried_n, wanted| Pace::begin(carried_n).force(&wanted);
        assert_eq!(first(None, at(1.0, 2.0, false)), Some(2.0));
        assert_eq!(first(None, at(1.0, 2.0, true)), Some(0.5), "what the fingers press with");
        assert_eq!(first(Some(1.5), at(1.0, 2.0, false)), Some(1.5));
        let blind = Wanted { applied_n: None, ..at(1.0, 2.0, true) };
        assert_eq!(first(None, blind), None);
    }
}
