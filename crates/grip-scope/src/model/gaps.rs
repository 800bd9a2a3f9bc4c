//! Ends of gaps in the samples in; whether a point of a curve that is no row joins the one before it out.
//!
//! States and what is derived come in blocks behind the rows of their time: by the time of a gap, not by the order in which things come, the curve is
//! shown that opens and where.

use std::collections::VecDeque;

/// Ends kept; a block of a recording's rows may hold as many gaps before its states come. The oldest go first.
const MOST: usize = 2048;

/// Where the latest gaps end (s on the axis), in order.
#[derive(Clone, Debug, Default)]
pub(super) struct Gaps {
    ends_s: VecDeque<f64>,
    /// The first point that was derived behind the last break between derived points.
    derived_s: Option<f64>,
}

impl Gaps {
    /// Takes the end of a gap: the time of the first row behind it, which is behind those of all gaps before.
    pub(super) fn push(&mut self, end_s: f64) {
        if self.ends_s.len() == MOST {
            self.ends_s.pop_front();
        }
        self.ends_s.push_back(end_s);
    }

    /// The end of the last gap at or before `t_s`: a point at `t_s` does not join one before it. Minus infinity where there is none.
    pub(super) fn before(&self, t_s: f64) -> f64 {
        let behind = self.ends_s.partition_point(|end_s| *end_s <= t_s);
        let last = behind.checked_sub(1).and_then(|at| self.ends_s.get(at));
        last.copied().unwrap_or(f64::NEG_INFINITY)
    }

    /// Takes the time of the first point that was derived behind a break: of an observer that began anew no sample need be missing.
    pub(super) const fn derive_from(&mut self, t_s: f64) {
        self.derived_s = Some(t_s);
    }

    /// As [`before`](Self::before), for what is derived.
    pub(super) fn derived_before(&self, t_s: f64) -> f64 {
        let begun_s = self.derived_s.filter(|begun_s| *begun_s <= t_s);
        begun_s.unwrap_or(f64::NEG_INFINITY).max(self.before(t_s))
    }
}

#[cfg(test)]
mod tests {
    use super::{Gaps, MOST};

    #[test]
    fn the_last_gap_before_a_time_is_found_and_the_oldest_are_forgotten() {
        let mut gaps = Gaps::default();
        assert_eq!(gaps.before(1.0), f64::NEG_INFINITY);
        (0..=u16::try_from(MOST).unwrap()).for_each(|k| gaps.push(f64::from(k)));
        assert_eq!(gaps.ends_s.len(), MOST);
        assert_eq!((gaps.before(7.0), gaps.before(7.5), gaps.before(9e9)), (7.0, 7.0, 2048.0));
        assert_eq!(gaps.before(0.5), f64::NEG_INFINITY);
    }
}
