//! Stylus heights along the surface in, the same without what is shorter than a length of surface out.

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
