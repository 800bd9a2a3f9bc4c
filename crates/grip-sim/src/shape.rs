//! Height of the waviness and form of a surface at any place, by amplitude, wavelength, tilt and curvature.
//!
//! Texture is form, waviness and roughness; [`crate::surface`] adds this to its asperities. Waviness is a sum of three waves,
//! form is a parabola:
//!
//! ```text
//! w(x) = A (cos(2 pi x / L + p1) + cos(2 pi x / (0.6 L) + p2) / 2 + cos(2 pi x / (1.7 L) + p3) / 2)
//! f(x) = t x - c x^2 / 2
//! ```
//!
//! so the waviness has Wq = A sqrt(3/4), whatever its phases. Heights count from x = 0.

use core::f64::consts::TAU;

/// Wavelength over L and amplitude over A of the three waves: no two periods are in a ratio of small whole numbers.
const WAVES: [(f64, f64); 3] = [(1.0, 1.0), (0.6, 0.5), (1.7, 0.5)];

/// Waviness and form of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Amplitude A of the strongest wave (m), not negative.
    pub amplitude_m: f64,
    /// Its wavelength L (m), positive.
    pub wavelength_m: f64,
    /// Phases p1 to p3 (rad).
    pub phases: [f64; 3],
    /// Slope t at x = 0.
    pub tilt: f64,
    /// Curvature c (1/m), positive where the surface bends away from the stylus.
    pub curvature_1_m: f64,
}

impl Shape {
    /// Whether the surface has neither waviness nor form.
    #[must_use]
    pub fn is_flat(&self) -> bool {
        [self.amplitude_m, self.tilt, self.curvature_1_m].iter().all(|size| *size == 0.0)
    }

    /// Height of the waviness at `x_m` (m) above that at 0 (m).
    #[must_use]
    pub fn waviness_m(&self, x_m: f64) -> f64 {
        let wave = |((length, height), phase): ((f64, f64), f64)| {
            let turns = TAU * x_m / (length * self.wavelength_m);
            height * ((turns + phase).cos() - phase.cos())
        };
        self.amplitude_m * WAVES.into_iter().zip(self.phases).map(wave).sum::<f64>()
    }

    /// Height of the form at `x_m` (m) above that at 0 (m).
    #[must_use]
    pub fn form_m(&self, x_m: f64) -> f64 {
        self.tilt * x_m - 0.5 * self.curvature_1_m * x_m * x_m
    }
}

#[cfg(test)]
mod tests {
    use super::Shape;

    const SHAPE: Shape = Shape {
        amplitude_m: 5e-6,
        wavelength_m: 2e-3,
        phases: [0.3, 1.7, 4.4],
        tilt: 1e-3,
        curvature_1_m: 0.5,
    };

    #[test]
    fn waviness_has_the_size_stated() {
        // 0.204 m hold whole numbers of all three waves: 102, 170, 60.
        let heights: Vec<f64> =
            (0..200_000).map(|i| SHAPE.waviness_m(0.204 * f64::from(i) / 2e5)).collect();
        let mean = heights.iter().sum::<f64>() / 2e5;
        let wq = (heights.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / 2e5).sqrt();
        assert!((wq / (5e-6 * 0.75_f64.sqrt()) - 1.0).abs() < 1e-9, "{wq}");
        let highest = heights.iter().map(|w| w - mean).fold(0.0, f64::max);
        assert!(highest > 7e-6 && highest < 10e-6, "{highest}");
    }

    #[test]
    fn form_is_a_parabola_and_both_begin_at_nought() {
        assert!((SHAPE.form_m(0.02) - (20e-6 - 100e-6)).abs() < 1e-18);
        assert_eq!((SHAPE.form_m(0.0), SHAPE.waviness_m(0.0)), (0.0, 0.0));
        assert!(!SHAPE.is_flat());
        assert!(Shape { amplitude_m: 0.0, tilt: 0.0, curvature_1_m: 0.0, ..SHAPE }.is_flat());
    }
}
