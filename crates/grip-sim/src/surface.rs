//! A height profile h(x) of any length, by roughness and seed.
//!
//! The profile is a row of asperities. The i-th has height delta_i above its valleys and spacing s_i and
//! rises and falls as `h(u) = delta_i / 2 (1 - cos(2 pi u / s_i))`, so profile and slope are continuous.
//! delta_i has median 3.5 Ra and log-spread 0.3, s_i has median RSm and log-spread 0.2; RSm follows from Ra as
//! [`mean_spacing`] states. Amplitude and spacing parameters as in ISO 21920-2; the relation between Ra and
//! RSm is a fit to machined surfaces, not a law.
//!
//! [`Surface::with_shape`] adds waviness and form, so that all three parts of a texture are there.
//!
//! Each asperity is a pure function of seed and index (the ChaCha stream is seekable), so the profile has no
//! end, takes constant memory and may be walked in both directions.

use crate::random::{self, Purpose};
use crate::shape::Shape;
use rand_chacha::ChaCha8Rng;

/// Median of delta / Ra.
pub const HEIGHT_PER_RA: f64 = 3.5;
/// Log-normal spread of the heights.
pub const HEIGHT_SPREAD: f64 = 0.3;
/// Log-normal spread of the spacings about RSm.
pub const SPACING_SPREAD: f64 = 0.2;
/// Log-normal spread of RSm between surfaces of the same Ra.
pub const MEAN_SPACING_SPREAD: f64 = 0.35;

/// Words of the random stream set aside for one asperity; two normal draws need four, rarely a few more.
const WORDS_PER_ASPERITY: u128 = 32;

/// One irregularity of the profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asperity {
    /// Height of the peak above the valleys beside it (m).
    pub delta_m: f64,
    /// Distance between these valleys (m).
    pub spacing_m: f64,
}

/// Mean spacing RSm (m) of a surface of roughness `ra_m` (m): 200 um (Ra / 1.6 um)^0.5, times
/// exp(0.35 `deviate`) with `deviate` from N(0, 1), kept within 20 um and 2 mm.
#[must_use]
pub fn mean_spacing(ra_m: f64, deviate: f64) -> f64 {
    let median = 200e-6 * (ra_m / 1.6e-6).sqrt();
    (median * (MEAN_SPACING_SPREAD * deviate).exp()).clamp(20e-6, 2e-3)
}

/// A seeded profile and the place on it that was read last.
#[derive(Clone, Debug)]
pub struct Surface {
    rng: ChaCha8Rng,
    ra_m: f64,
    rsm_m: f64,
    index: u64,
    start_m: f64,
    current: Asperity,
    shape: Option<Shape>,
    /// The place asked for last, and its height.
    last: (f64, f64),
}

impl Surface {
    /// A profile of roughness `ra_m` and mean spacing `rsm_m`, both positive (m).
    #[must_use]
    pub fn new(ra_m: f64, rsm_m: f64, seed: u64) -> Self {
        let rng = random::stream(seed, Purpose::Surface);
        let current = asperity(&rng, ra_m, rsm_m, 0);
        Self { rng, ra_m, rsm_m, index: 0, start_m: 0.0, current, shape: None, last: (0.0, 0.0) }
    }

    /// The same asperities on waviness and form.
    #[must_use]
    pub fn with_shape(self, shape: Shape) -> Self {
        Self { shape: Some(shape), ..self }
    }

    /// The true i-th irregularity, counted from x = 0.
    #[must_use]
    pub fn asperity(&self, index: u64) -> Asperity {
        asperity(&self.rng, self.ra_m, self.rsm_m, index)
    }

    /// All irregularities whose end lies within `length_m` of x = 0, in order.
    pub fn within(&self, length_m: f64) -> impl Iterator<Item = Asperity> + '_ {
        let mut end = 0.0;
        (0..).map(|index| self.asperity(index)).take_while(move |a| {
            end += a.spacing_m;
            end <= length_m
        })
    }

    /// Height (m) at `x_m` (m) above the valleys, or above the one at 0 where there is waviness or form; 0 for negative or NaN `x_m`.
    ///
    /// Costs one cosine plus one draw for each asperity between this place and the last one asked for; nothing at the same place.
    pub fn height(&mut self, x_m: f64) -> f64 {
        if x_m.is_nan() || x_m <= 0.0 {
            return 0.0;
        }
        if x_m != self.last.0 {
            self.last = (x_m, self.height_at(x_m));
        }
        self.last.1
    }

    fn height_at(&mut self, x_m: f64) -> f64 {
        while x_m >= self.start_m + self.current.spacing_m {
            self.start_m += self.current.spacing_m;
            self.move_to(self.index.saturating_add(1));
        }
        while x_m < self.start_m && self.index > 0 {
            self.move_to(self.index - 1);
            self.start_m -= self.current.spacing_m;
        }
        let phase = core::f64::consts::TAU * (x_m - self.start_m) / self.current.spacing_m;
        let roughness = 0.5 * self.current.delta_m * (1.0 - phase.cos());
        match &self.shape {
            Some(shape) => roughness + shape.waviness_m(x_m) + shape.form_m(x_m),
            None => roughness,
        }
    }

    fn move_to(&mut self, index: u64) {
        self.index = index;
        self.current = self.asperity(index);
    }
}

fn asperity(rng: &ChaCha8Rng, ra_m: f64, rsm_m: f64, index: u64) -> Asperity {
    let mut rng = rng.clone();
    rng.set_word_pos(u128::from(index) * WORDS_PER_ASPERITY);
    Asperity {
        delta_m: random::lognormal(&mut rng, HEIGHT_PER_RA * ra_m, HEIGHT_SPREAD),
        spacing_m: random::lognormal(&mut rng, rsm_m, SPACING_SPREAD),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled_ra(surface: &mut Surface, length_m: f64, points: u32) -> f64 {
        let heights: Vec<f64> = (0..points)
            .map(|i| surface.height(length_m * f64::from(i) / f64::from(points)))
            .collect();
        let mean = heights.iter().sum::<f64>() / f64::from(points);
        heights.iter().map(|h| (h - mean).abs()).sum::<f64>() / f64::from(points)
    }

    #[test]
    fn profile_has_the_roughness_asked_for() {
        for ra_um in [0.4, 1.6, 6.3] {
            let ra = ra_um * 1e-6;
            let mut surface = Surface::new(ra, mean_spacing(ra, 0.0), 7);
            let measured = sampled_ra(&mut surface, 0.2, 400_000) / ra;
            println!("Ra {ra_um} um: measured / asked {measured:.3}");
            // A raised cosine has Ra = delta / pi; the log-normal mean and spread of 3.5 Ra add about 8 %.
            assert!(
                (1.0..1.3).contains(&measured),
                "Ra {ra_um} um came out {measured} times as large"
            );
        }
    }

    #[test]
    fn spacing_and_height_have_their_medians() {
        let surface = Surface::new(1.6e-6, 200e-6, 3);
        let (mut deltas, mut spacings): (Vec<f64>, Vec<f64>) =
            (0..4001).map(|i| surface.asperity(i)).map(|a| (a.delta_m, a.spacing_m)).unzip();
        deltas.sort_by(f64::total_cmp);
        spacings.sort_by(f64::total_cmp);
        assert!((deltas[2000] / 5.6e-6 - 1.0).abs() < 0.03, "{}", deltas[2000]);
        assert!((spacings[2000] / 200e-6 - 1.0).abs() < 0.02, "{}", spacings[2000]);
    }

    #[test]
    fn walking_back_meets_the_same_heights() {
        let mut surface = Surface::new(1.6e-6, 50e-6, 11);
        let places: Vec<f64> = (0..2000).map(|i| f64::from(i) * 7.3e-6).collect();
        let forth: Vec<f64> = places.iter().map(|&x| surface.height(x)).collect();
        for (&x, &h) in places.iter().zip(&forth).rev() {
            // The running start of an asperity is a sum; walking back rounds it differently.
            assert!((surface.height(x) - h).abs() < 1e-14, "at {x}");
        }
    }

    #[test]
    fn without_waviness_and_form_every_bit_is_that_of_the_asperities() {
        let mut surface = Surface::new(1.6e-6, 50e-6, 11);
        let (mut start, mut index) = (0.0, 0);
        for i in 1..20_000 {
            let x = f64::from(i) * 1e-6;
            while x >= start + surface.asperity(index).spacing_m {
                start += surface.asperity(index).spacing_m;
                index += 1;
            }
            let Asperity { delta_m, spacing_m } = surface.asperity(index);
            let plain =
                0.5 * delta_m * (1.0 - (core::f64::consts::TAU * (x - start) / spacing_m).cos());
            assert_eq!(surface.height(x).to_bits(), plain.to_bits(), "at {x}");
        }
    }

    #[test]
    fn a_shape_carries_the_same_asperities() {
        let shape = Shape {
            amplitude_m: 5e-6,
            wavelength_m: 2e-3,
            phases: [0.3, 1.7, 4.4],
            tilt: 1e-3,
            curvature_1_m: 0.5,
        };
        let mut plain = Surface::new(1.6e-6, 50e-6, 11);
        let mut shaped = plain.clone().with_shape(shape);
        for i in 0..3000 {
            let x = f64::from(i) * 7e-6;
            let below = shape.waviness_m(x) + shape.form_m(x);
            assert!((shaped.height(x) - plain.height(x) - below).abs() < 1e-18, "at {x}");
        }
        assert_eq!(shaped.asperity(70), plain.asperity(70));
    }

    #[test]
    fn peaks_equal_the_listed_asperities() {
        let mut surface = Surface::new(1.6e-6, 200e-6, 5);
        let listed: Vec<Asperity> = surface.within(5e-3).collect();
        let mut start = 0.0;
        for a in &listed {
            let peak = surface.height(start + a.spacing_m / 2.0);
            assert!((peak - a.delta_m).abs() < 1e-12 * a.delta_m, "{peak} {a:?}");
            start += a.spacing_m;
        }
        assert!(listed.len() > 15 && start <= 5e-3);
    }

    #[test]
    fn mean_spacing_stays_in_range() {
        assert!((mean_spacing(1.6e-6, 0.0) - 200e-6).abs() < 1e-12);
        assert!(mean_spacing(1e-9, -3.0) >= 20e-6 && mean_spacing(1e-3, 3.0) <= 2e-3);
    }
}
