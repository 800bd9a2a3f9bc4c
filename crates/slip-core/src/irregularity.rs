//! Irregularities (height delta, spacing s) of stylus heights along the surface.
//!
//! A peak is confirmed when the signal has fallen from it by more than the hysteresis, a valley when
//! it has risen by more; noise smaller than the hysteresis makes neither. One irregularity is what
//! lies between two successive valleys: its spacing s is their distance along the surface, its height
//! delta is the peak between them above the mean of the two valleys. An extremum that is a plateau
//! lies at the middle of the plateau; half a period at either end of the path is no irregularity.
//!
//! # Noise
//! Noise does two things to peaks and valleys. It adds false ones: the hysteresis keeps those out, as long as it is
//! several deviations of the noise. And it makes every peak too high and every valley too low, because the
//! extreme of N noisy samples lies about sigma sqrt(2 ln N) beyond the truth; no threshold cures that, only less noise.
//! [`SpatialLowPass`] averages over a fixed length of *surface*, so the slower the slip, the more samples it averages: its
//! corner in Hz follows the speed, and surface and spacing keep their size at every speed. What remains is of second order:
//! reversals whose height lies within the remaining noise of the hysteresis come and go. `gripctl profile` puts the
//! hysteresis where a given surface has no such reversals.

/// One asperity of the slipping surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Irregularity {
    /// Height of the peak above the mean of its two valleys (m).
    pub delta_m: f32,
    /// Distance between the two valleys along the surface (m).
    pub spacing_m: f32,
}

/// Streaming extraction; cost O(1) a sample.
#[derive(Clone, Copy, Debug)]
pub struct IrregularityExtractor {
    turns: TurnFinder,
    valley: Option<Turn>,
    peak_m: f32,
}

impl IrregularityExtractor {
    /// An extractor that ignores reversals up to `hysteresis_m` (m).
    #[must_use]
    pub fn new(hysteresis_m: f32) -> Self {
        Self { turns: TurnFinder::new(hysteresis_m), valley: None, peak_m: 0.0 }
    }

    /// Takes the height at the next position along the surface (m) (positions do not decrease) and
    /// gives the irregularity that the sample completes, if it does.
    #[inline]
    pub fn push(&mut self, position_m: f64, height_m: f32) -> Option<Irregularity> {
        let turn = self.turns.push(position_m, height_m)?;
        match turn.kind {
            TurnKind::Peak => {
                self.peak_m = turn.height_m;
                None
            }
            TurnKind::Valley => self.valley.replace(turn).map(|left| self.between(&left, &turn)),
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "a spacing needs no more than f32")]
    fn between(&self, left: &Turn, right: &Turn) -> Irregularity {
        Irregularity {
            delta_m: self.peak_m - 0.5 * (left.height_m + right.height_m),
            spacing_m: (right.position_m - left.position_m) as f32,
        }
    }
}

// Detector of confirmed peaks and valleys in heights along a path.

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

// Low-pass of stylus heights along the surface: takes away what is shorter than a length of surface.

/// Poles of the filter.
const POLES: usize = 4;

/// Deviation of the Gaussian profile filter of ISO 16610-21 over its cutoff: sqrt(ln 2) / (pi sqrt 2).
const GAUSSIAN_DEVIATION: f64 = 0.187_390_625_129_277_4;

/// A low-pass along the surface: four equal real poles, y <- y + (1 - exp(-dx / L)) (x - y) each, where dx is the distance
/// moved since the last sample.
///
/// L makes the deviation of its weighting function, 2 L, that of the Gaussian filter of the same cutoff, so both
/// treat surfaces alike (a sine at twice the cutoff keeps 85 % with either); the step response does not overshoot, so it
/// makes no peaks of its own. White noise of deviation sigma leaves [`noise_gain`](Self::noise_gain) sigma. The output lags
/// by 4 L = 0.375 cutoffs of surface, the same for every wavelength that passes, so spacings are unchanged. At rest (dx = 0)
/// it stands still.
#[derive(Clone, Copy, Debug)]
pub struct SpatialLowPass {
    pole_m: f64,
    last_m: Option<f64>,
    state: [f64; POLES],
}

impl SpatialLowPass {
    /// A filter that halves a sine of wavelength about `cutoff_m` (m); 0 or less lets everything pass.
    #[must_use]
    pub fn new(cutoff_m: f64) -> Self {
        // The variance of POLES equal exponentials is POLES L^2.
        let pole_m = GAUSSIAN_DEVIATION * cutoff_m / libm::sqrt(POLES as f64);
        Self { pole_m, last_m: None, state: [0.0; POLES] }
    }

    /// Takes the height (m) at the next position along the surface (m) and gives the filtered one (m).
    ///
    /// A reading that is not finite does not enter the filter; the last output is given again.
    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "heights are f32 outside the filter")]
    pub fn push(&mut self, position_m: f64, height_m: f32) -> f32 {
        let height = f64::from(height_m);
        if !height.is_finite() || !position_m.is_finite() {
            return self.state[POLES - 1] as f32;
        }
        let Some(last_m) = self.last_m.replace(position_m) else {
            self.state = [height; POLES];
            return height_m;
        };
        if self.pole_m <= 0.0 {
            self.state = [height; POLES];
            return height_m;
        }
        let weight = -libm::expm1(-(position_m - last_m).abs() / self.pole_m);
        let mut input = height;
        for y in &mut self.state {
            *y += weight * (input - *y);
            input = *y;
        }
        input as f32
    }

    /// Distance by which the output lags (m).
    #[must_use]
    pub fn lag_m(&self) -> f64 {
        (POLES as f64 * self.pole_m).max(0.0)
    }

    /// Deviation of white noise after the filter over that before, at `step_m` (m) between samples:
    /// sqrt(5 dx / (32 L)) while that is small, never above 1.
    #[must_use]
    pub fn noise_gain(&self, step_m: f64) -> f64 {
        if self.pole_m <= 0.0 {
            return 1.0;
        }
        libm::sqrt(5.0 * step_m.abs() / (32.0 * self.pole_m)).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{Irregularity, IrregularityExtractor};
    use std::vec::Vec;

    fn extract(hysteresis: f32, heights: &[f32]) -> Vec<Irregularity> {
        let mut extractor = IrregularityExtractor::new(hysteresis);
        heights.iter().enumerate().filter_map(|(i, h)| extractor.push(i as f64, *h)).collect()
    }

    #[test]
    fn a_triangle_wave_gives_its_height_and_period() {
        let wave: Vec<f32> = (0..100_u16).map(|i| f32::from((i % 10).min(10 - i % 10))).collect();
        let found = extract(0.5, &wave);
        assert_eq!(found.len(), 8);
        assert!(
            found.iter().all(|i| *i == Irregularity { delta_m: 5.0, spacing_m: 10.0 }),
            "{found:?}"
        );
    }

    #[test]
    fn plateaus_count_at_their_middle() {
        let found = extract(0.5, &[1., 0., 0., 0., 4., 4., 1., 1., 5., 0., 3.]);
        assert_eq!(
            found,
            [
                Irregularity { delta_m: 3.5, spacing_m: 4.5 },
                Irregularity { delta_m: 4.5, spacing_m: 2.5 }
            ]
        );
    }

    #[test]
    fn ripple_below_the_hysteresis_is_not_a_peak() {
        let wave: Vec<f32> = (0..1000_u16)
            .map(|i| {
                let ripple = if i % 2 == 0 { 0.2 } else { -0.2 };
                10.0 * libm::sinf(core::f32::consts::TAU * f32::from(i) / 100.0) + ripple
            })
            .collect();
        let found = extract(0.5, &wave);
        assert_eq!(found.len(), 9, "valleys at 75, 175, ... 975");
        for irregularity in found {
            assert!((irregularity.delta_m - 20.0).abs() < 0.5, "{irregularity:?}");
            assert!((irregularity.spacing_m - 100.0).abs() <= 4.0, "{irregularity:?}");
        }
    }

    #[test]
    fn a_flat_or_single_sided_signal_gives_nothing() {
        assert!(extract(0.5, &[0.0; 50]).is_empty());
        assert!(extract(0.5, &(0..50_u8).map(f32::from).collect::<Vec<_>>()).is_empty());
    }
}

#[cfg(test)]
mod turn_tests {
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

#[cfg(test)]
mod low_pass_tests {
    use super::SpatialLowPass;
    use core::f64::consts::TAU;

    /// Amplitude of a sine of `wavelength` after the filter, at `step` between samples.
    #[expect(clippy::cast_possible_truncation, reason = "test signal")]
    fn gain(cutoff: f64, wavelength: f64, step: f64) -> f64 {
        let mut filter = SpatialLowPass::new(cutoff);
        let mut highest = 0.0_f32;
        let mut x = 0.0;
        while x < 20.0 * wavelength {
            let y = filter.push(x, (TAU * x / wavelength).sin() as f32);
            if x > 10.0 * wavelength {
                highest = highest.max(y);
            }
            x += step;
        }
        f64::from(highest)
    }

    #[test]
    fn the_gain_depends_on_the_surface_and_not_on_the_speed() {
        // (1 + (2 pi L / wavelength)^2)^-2 with L = 0.0937 cutoff.
        let ideal = |ratio: f64| (1.0 + (TAU * 0.093_695_3 / ratio).powi(2)).powi(-2);
        for (ratio, step) in [(1.0, 0.01), (2.0, 0.01), (2.0, 0.002), (4.0, 0.03), (20.0, 0.05)] {
            let got = gain(1.0, ratio, step);
            assert!((got - ideal(ratio)).abs() < 0.012, "{ratio} {step}: {got} {}", ideal(ratio));
        }
        assert!((ideal(1.0) - 0.55).abs() < 0.01 && (ideal(2.0) - 0.85).abs() < 0.01);
    }

    #[test]
    fn noise_shrinks_as_stated() {
        for step in [0.005, 0.02, 0.06] {
            let mut filter = SpatialLowPass::new(1.0);
            let (mut seed, mut input, mut output) = (1_u32, 0.0, 0.0);
            for i in 0..40_000_u32 {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let noise = f32::from((seed >> 16).to_le_bytes()[0]) - 127.5;
                let y = filter.push(f64::from(i) * step, noise);
                if i > 1000 {
                    input += f64::from(noise).powi(2);
                    output += f64::from(y).powi(2);
                }
            }
            let (got, stated) = ((output / input).sqrt(), filter.noise_gain(step));
            assert!((got / stated - 1.0).abs() < 0.15, "step {step}: {got}, stated {stated}");
        }
    }

    #[test]
    fn bad_readings_and_rest_leave_the_state_alone() {
        let mut filter = SpatialLowPass::new(1.0);
        assert_eq!(filter.push(0.0, 2.0), 2.0);
        assert_eq!(filter.push(0.1, f32::NAN), 2.0);
        assert_eq!(filter.push(f64::NAN, 9.0), 2.0);
        assert_eq!(filter.push(0.0, 9.0), 2.0, "not moved");
        assert!(filter.push(0.5, 9.0) > 2.0);
        let mut open = SpatialLowPass::new(0.0);
        assert_eq!(
            [open.push(0.0, 1.0), open.push(0.1, 5.0), open.push(0.2, -3.0)],
            [1.0, 5.0, -3.0]
        );
        assert_eq!((open.noise_gain(0.1), open.lag_m()), (1.0, 0.0));
    }
}
