//! Ends of gaps in the samples: whether a point of a curve that is no row joins the one before it.
//!
//! States and what is derived come in blocks behind the rows of their time: by the time of a gap, not by the order in which things come, the curve is
//! shown that opens and where.

use super::timeline::{Room, Timeline};

/// Ends kept; a block of a recording's rows may hold as many gaps before its states come.
const ENDS: Room = Room::Items(2048);

/// Where the latest gaps end (s on the axis).
#[derive(Clone, Debug, Default)]
pub(super) struct Gaps {
    ends_s: Timeline<f64>,
    /// The first point that was derived behind the last break between derived points.
    derived_s: Option<f64>,
}

impl Gaps {
    /// Takes the end of a gap: the time of the first row behind it, which is behind those of all gaps before.
    pub(super) fn push(&mut self, end_s: f64) {
        self.ends_s.append(end_s, ENDS);
    }

    /// The end of the last gap at or before `t_s`: a point at `t_s` does not join one before it. Minus infinity where there is none.
    pub(super) fn before(&self, t_s: f64) -> f64 {
        self.ends_s.at(t_s).copied().unwrap_or(f64::NEG_INFINITY)
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
