//! Time axis that never goes back, for times of a device that may restart or go wrong.

/// Times that go back by less than this (s) are those of single rows out of order, which are left out.
const ROW_S: f64 = 0.1;
/// Times that leap ahead by more than this (s) are no times.
const LEAP_S: f64 = 86_400.0;
/// What stands between two runs on the axis (s).
const BETWEEN_S: f64 = 1.0;
/// States and events further from the samples than this (s) belong to another run.
const NEAR_S: f64 = 2.0;

/// From device times to the axis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Axis {
    offset_s: f64,
    /// Device time of the last row.
    row_s: Option<f64>,
    /// Device time of the last state, where no row came.
    state_s: Option<f64>,
    /// The end of the axis.
    end_s: f64,
    /// Runs begun after the first.
    leaps: u32,
}

/// What became of a row's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Placed {
    /// It is here (s on the axis).
    At(f64),
    /// It is not later than the row before and cannot be shown.
    Late,
    /// The device's time leapt: another run begins here.
    Leapt {
        /// On the axis.
        at_s: f64,
        /// The device's time before.
        before_s: f64,
    },
}

impl Axis {
    /// Where a row of this device time (s) goes.
    pub(crate) fn row(&mut self, t_s: f64) -> Placed {
        let placed = match self.row_s {
            None => self.first(t_s),
            Some(last_s) if t_s > last_s && t_s - last_s <= LEAP_S => {
                Placed::At(t_s + self.offset_s)
            }
            Some(last_s) if t_s <= last_s && last_s - t_s < ROW_S => return Placed::Late,
            Some(last_s) => self.leap(t_s, last_s),
        };
        self.row_s = Some(t_s);
        if let Placed::At(at_s) | Placed::Leapt { at_s, .. } = placed {
            self.end_s = self.end_s.max(at_s);
        }
        placed
    }

    /// The first row: states may have been there before it.
    fn first(&mut self, t_s: f64) -> Placed {
        match self.state_s {
            Some(state_s) if (t_s - state_s).abs() > NEAR_S => self.leap(t_s, state_s),
            _ => Placed::At(t_s + self.offset_s),
        }
    }

    fn leap(&mut self, t_s: f64, before_s: f64) -> Placed {
        let at_s = self.end_s + BETWEEN_S;
        self.leaps = self.leaps.wrapping_add(1);
        // Whole microseconds, as the times themselves.
        self.offset_s = (1e6 * (at_s - t_s)).round() / 1e6;
        Placed::Leapt { at_s: t_s + self.offset_s, before_s }
    }

    /// Where a state of this device time goes; `None` where it belongs to a run whose samples are not there.
    pub(super) fn state(&mut self, t_s: f64) -> Option<f64> {
        if !t_s.is_finite() {
            return None;
        }
        if let Some(row_s) = self.row_s {
            return ((t_s - row_s).abs() <= NEAR_S).then_some(t_s + self.offset_s);
        }
        // Without rows states make the axis.
        let last_s = self.state_s.replace(t_s);
        if last_s.is_some_and(|last_s| last_s - t_s > ROW_S || t_s - last_s > LEAP_S) {
            self.leap(t_s, t_s);
        }
        let at_s = t_s + self.offset_s;
        self.end_s = self.end_s.max(at_s);
        Some(at_s)
    }

    /// Where an event goes: what has no time, or one far from the samples, stands at the end.
    pub(super) fn event(&self, t_s: f64) -> f64 {
        let near = match self.row_s.or(self.state_s) {
            Some(last_s) => (t_s - last_s).abs() <= NEAR_S,
            None => t_s.is_finite(),
        };
        if near { t_s + self.offset_s } else { self.end_s }
    }

    /// Where the last row went; `None` before the first one.
    pub(super) fn row_s(&self) -> Option<f64> {
        self.row_s.map(|row_s| row_s + self.offset_s)
    }

    pub(super) const fn end_s(&self) -> f64 {
        self.end_s
    }

    /// Runs begun after the first.
    pub(super) const fn leaps(&self) -> u32 {
        self.leaps
    }

    /// Whether device times stand on the axis as they are.
    pub(super) fn is_plain(&self) -> bool {
        self.offset_s == 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::{Axis, Placed};

    #[test]
    fn the_axis_never_goes_back_whatever_the_device_states() {
        let mut axis = Axis::default();
        assert_eq!(axis.row(5.0), Placed::At(5.0));
        assert_eq!(axis.row(5.01), Placed::At(5.01));
        assert_eq!(axis.row(5.0), Placed::Late);
        assert_eq!(axis.row(0.5), Placed::Leapt { at_s: 6.01, before_s: 5.01 });
        let Placed::At(next_s) = axis.row(0.75) else { panic!() };
        assert!((next_s - 6.26).abs() < 1e-9, "{next_s}");
        assert!(matches!(axis.row(1e12), Placed::Leapt { at_s, .. } if at_s < 8.0));
    }

    #[test]
    fn states_follow_the_rows_and_events_are_never_lost() {
        let mut axis = Axis::default();
        assert_eq!(axis.state(1.0), Some(1.0));
        assert_eq!(axis.row(1.5), Placed::At(1.5));
        assert_eq!(axis.state(1.49), Some(1.49));
        assert_eq!(axis.state(500.0), None);
        assert_eq!(axis.state(f64::NAN), None);
        assert_eq!((axis.event(1.4), axis.event(f64::NAN), axis.event(900.0)), (1.4, 1.5, 1.5));
    }
}
