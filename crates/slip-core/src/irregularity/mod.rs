//! Stylus heights along the surface in, irregularities (height delta, spacing s) out.
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
//! extreme of N noisy samples lies about sigma sqrt(2 ln N) beyond the truth; no threshold mends that, only less noise.
//! [`SpatialLowPass`] averages over a fixed length of *surface*, so the slower the slip, the more samples it averages: its
//! corner in Hz follows the speed, and surface and spacing keep their size at every speed. What remains is of second order:
//! reversals whose height lies within the remaining noise of the hysteresis come and go. `gripctl profile` puts the
//! hysteresis where a given surface has no such reversals.

mod low_pass;
mod turn;

pub use low_pass::SpatialLowPass;
pub use turn::{Turn, TurnFinder, TurnKind};

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
