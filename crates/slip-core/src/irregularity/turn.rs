//! Heights along a path in, confirmed peaks and valleys out.

/// Which way the height turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurnKind {
    /// From rising to falling.
    Peak,
    /// From falling to rising.
    Valley,
}

/// A confirmed peak or valley.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Peak or valley.
    pub kind: TurnKind,
    /// Where it lies along the surface (m); the middle of a plateau.
    pub position_m: f64,
    /// Its height (m).
    pub height_m: f32,
}

/// Finds peaks and valleys that alternate and differ by more than the hysteresis; O(1) state and cost.
///
/// The path's first and last extremes are no turns: whether the surface goes on rising or falling beyond
/// them is not known. So half a period at either end is left out, and a signal without a reversal has none.
/// Heights that are not finite are passed over.
#[derive(Clone, Copy, Debug)]
pub struct TurnFinder {
    hysteresis_m: f32,
    phase: Phase,
    low: Extremum,
    high: Extremum,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Nothing seen.
    Start,
    /// Neither direction is known yet: `low` and `high` are the extremes so far.
    Undecided,
    /// `high` is the highest point since the last valley.
    Rising,
    /// `low` is the lowest point since the last peak.
    Falling,
}

#[derive(Clone, Copy, Debug, Default)]
struct Extremum {
    height_m: f32,
    first_m: f64,
    last_m: f64,
}

impl Extremum {
    fn at(position_m: f64, height_m: f32) -> Self {
        Self { height_m, first_m: position_m, last_m: position_m }
    }

    /// Takes the next point, which lies beyond the extreme or not.
    #[inline]
    fn follow(&mut self, here: Self, beyond: bool) {
        if beyond {
            *self = here;
        } else if here.height_m == self.height_m {
            self.last_m = here.last_m;
        }
    }

    fn turn(self, kind: TurnKind) -> Turn {
        Turn { kind, position_m: 0.5 * (self.first_m + self.last_m), height_m: self.height_m }
    }
}

impl TurnFinder {
    /// A finder that ignores reversals up to `hysteresis_m` (m, not negative).
    #[must_use]
    pub fn new(hysteresis_m: f32) -> Self {
        let none = Extremum::default();
        Self { hysteresis_m, phase: Phase::Start, low: none, high: none }
    }

    /// Takes the height (m) at the next position (m; positions do not decrease) and gives the peak or valley
    /// that this sample confirms, if it does.
    #[inline]
    pub fn push(&mut self, position_m: f64, height_m: f32) -> Option<Turn> {
        if !height_m.is_finite() {
            return None;
        }
        let here = Extremum::at(position_m, height_m);
        let risen = height_m > self.low.height_m + self.hysteresis_m;
        let fallen = height_m < self.high.height_m - self.hysteresis_m;
        match self.phase {
            Phase::Start => {
                (self.low, self.high) = (here, here);
                self.phase = Phase::Undecided;
            }
            Phase::Undecided if risen => self.rise(here),
            Phase::Undecided if fallen => self.fall(here),
            Phase::Undecided => {
                self.low.follow(here, height_m < self.low.height_m);
                self.high.follow(here, height_m > self.high.height_m);
            }
            Phase::Rising if fallen => {
                let peak = self.high.turn(TurnKind::Peak);
                self.fall(here);
                return Some(peak);
            }
            Phase::Rising => self.high.follow(here, height_m > self.high.height_m),
            Phase::Falling if risen => {
                let valley = self.low.turn(TurnKind::Valley);
                self.rise(here);
                return Some(valley);
            }
            Phase::Falling => self.low.follow(here, height_m < self.low.height_m),
        }
        None
    }

    #[inline]
    fn rise(&mut self, here: Extremum) {
        self.phase = Phase::Rising;
        self.high = here;
    }

    #[inline]
    fn fall(&mut self, here: Extremum) {
        self.phase = Phase::Falling;
        self.low = here;
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{Turn, TurnFinder, TurnKind};
    use proptest::prelude::*;
    use std::vec::Vec;

    fn turns(hysteresis: f32, heights: &[f32]) -> Vec<(TurnKind, f64, f32)> {
        let mut finder = TurnFinder::new(hysteresis);
        let confirmed = heights.iter().enumerate().filter_map(|(i, h)| finder.push(i as f64, *h));
        confirmed.map(|Turn { kind, position_m, height_m }| (kind, position_m, height_m)).collect()
    }

    #[test]
    fn the_first_and_the_last_extreme_are_no_turns() {
        use TurnKind::{Peak, Valley};
        let wave = [0., 3., 6., 3., 0., 3., 6., 3., 0.];
        assert_eq!(turns(1.0, &wave), [(Peak, 2.0, 6.0), (Valley, 4.0, 0.0), (Peak, 6.0, 6.0)]);
        assert!(turns(1.0, &wave[..3]).is_empty(), "half a period has no confirmed turn");
        assert!(turns(1.0, &[]).is_empty());
        // Down by less than the hysteresis, then up: the low point at the start is no valley.
        assert_eq!(turns(1.0, &[5.0, 4.5, 6.0, 4.0]), [(Peak, 2.0, 6.0)]);
    }

    #[test]
    fn a_plateau_turns_at_its_middle_and_a_reversal_of_the_hysteresis_is_none() {
        use TurnKind::{Peak, Valley};
        let found = turns(2.0, &[0., 5., 5., 5., 3., 5., 1., 1., 4., 2., 6.]);
        // 5 -> 3 falls by exactly the hysteresis: the plateau goes on to the last 5.
        assert_eq!(found, [(Peak, 3.0, 5.0), (Valley, 6.5, 1.0)]);
    }

    #[test]
    fn readings_that_are_not_finite_are_passed_over() {
        let wave = [f32::NAN, 0., 3., f32::INFINITY, 6., 3., f32::NAN, 0., f32::NEG_INFINITY, 3.];
        let found = turns(1.0, &wave);
        assert_eq!(found, [(TurnKind::Peak, 4.0, 6.0), (TurnKind::Valley, 7.0, 0.0)]);
    }

    /// Every turn the slow way: from the last one, the extreme of the stretch that ends where the height has
    /// come back by more than the hysteresis.
    fn by_scanning(hysteresis: f32, h: &[f32]) -> Vec<(TurnKind, f32)> {
        let extremes = |s: &[f32]| {
            let fold = |pick: fn(f32, f32) -> f32| s.iter().copied().reduce(pick).unwrap();
            (fold(f32::min), fold(f32::max))
        };
        let mut found = Vec::new();
        let (mut start, mut rising) = (0, None);
        for end in 1..h.len() {
            let (low, high) = extremes(&h[start..end]);
            let (up, down) = (h[end] > low + hysteresis, h[end] < high - hysteresis);
            match rising {
                None if up || down => (rising, start) = (Some(up), end),
                Some(true) if down => {
                    found.push((TurnKind::Peak, high));
                    (rising, start) = (Some(false), end);
                }
                Some(false) if up => {
                    found.push((TurnKind::Valley, low));
                    (rising, start) = (Some(true), end);
                }
                _ => {}
            }
        }
        found
    }

    proptest! {
        #[test]
        fn agrees_with_scanning(
            heights in prop::collection::vec((-20_i8..20).prop_map(f32::from), 0..200),
            hysteresis in (0_u8..12).prop_map(f32::from),
        ) {
            let found: Vec<_> = turns(hysteresis, &heights).into_iter().map(|t| (t.0, t.2)).collect();
            prop_assert_eq!(&found, &by_scanning(hysteresis, &heights));
            for pair in found.windows(2) {
                prop_assert!(pair[0].0 != pair[1].0 && (pair[0].1 - pair[1].1).abs() > hysteresis);
            }
        }
    }
}
