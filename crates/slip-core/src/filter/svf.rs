//! Second-order sections: a sample goes in, its low-pass and high-pass parts come out.
//!
//! The topology is the trapezoidal state-variable filter (V. Zavalishin, *The Art of VA Filter Design*,
//! ch. 4; A. Simper, *Linear trapezoidal integrated SVF*, 2013). Its two states are the integrator
//! outputs, so in `f32` it keeps its accuracy where the corner lies far below the sample rate; a
//! direct-form biquad there subtracts nearly equal numbers. With g = tan(pi fc / fs), k = sqrt 2
//! (Butterworth), a1 = 1/(1 + g(g + k)), a2 = g a1, a3 = g a2:
//!
//! ```text
//! v3 = x - ic2      v1 = a1 ic1 + a2 v3      v2 = ic2 + a2 ic1 + a3 v3
//! ic1 <- 2 v1 - ic1      ic2 <- 2 v2 - ic2
//! low = v2               high = x - k v1 - v2
//! ```
//!
//! The transfer functions are those of the bilinear transform of the analogue Butterworth section.
//! Measured against the same recursion in `f64` (test `f32_follows_f64`): worst error 2e-6 of full scale
//! for corners from 2e-4 to 0.4 of the sample rate.

/// A corner frequency that the sample rate cannot carry.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "corner {corner_hz} Hz must lie between 0 and {limit_hz} Hz (0.4 of the sample rate {rate_hz} Hz)"
)]
pub struct CornerError {
    /// The corner that was asked for.
    pub corner_hz: f32,
    /// The highest one possible.
    pub limit_hz: f32,
    /// The sample rate.
    pub rate_hz: f32,
}

/// The largest corner as a fraction of the sample rate; above it the bilinear warping takes over.
pub const MAX_CORNER: f32 = 0.4;

const K: f32 = core::f32::consts::SQRT_2;

/// Coefficients of one second-order Butterworth section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Svf {
    a1: f32,
    a2: f32,
    a3: f32,
}

impl Svf {
    /// The section with its -3 dB corner at `corner_hz` for samples at `rate_hz`.
    ///
    /// # Errors
    /// Where the corner is not within (0, 0.4 rate] or a number is not finite.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "coefficients are designed in f64 and used in f32"
    )]
    pub fn butterworth(corner_hz: f32, rate_hz: f32) -> Result<Self, CornerError> {
        let limit_hz = MAX_CORNER * rate_hz;
        // Written so that a NaN fails the test.
        if !(corner_hz > 0.0 && corner_hz <= limit_hz && rate_hz.is_finite()) {
            return Err(CornerError { corner_hz, limit_hz, rate_hz });
        }
        let g = libm::tan(core::f64::consts::PI * f64::from(corner_hz) / f64::from(rate_hz));
        let a1 = 1.0 / (1.0 + g * (g + core::f64::consts::SQRT_2));
        Ok(Self { a1: a1 as f32, a2: (g * a1) as f32, a3: (g * g * a1) as f32 })
    }
}

/// `N` sections that advance together, one array per quantity so that the compiler can use vector lanes.
#[derive(Clone, Copy, Debug)]
pub struct SvfLanes<const N: usize> {
    a1: [f32; N],
    a2: [f32; N],
    a3: [f32; N],
    ic1: [f32; N],
    ic2: [f32; N],
}

impl<const N: usize> SvfLanes<N> {
    /// Sections with these coefficients, at rest.
    #[must_use]
    pub fn new(sections: [Svf; N]) -> Self {
        Self {
            a1: sections.map(|s| s.a1),
            a2: sections.map(|s| s.a2),
            a3: sections.map(|s| s.a3),
            ic1: [0.0; N],
            ic2: [0.0; N],
        }
    }

    /// The state that a constant input of `x` would have led to: `low = x`, `high = 0` from the next step on.
    pub fn prime(&mut self, x: f32) {
        self.ic1 = [0.0; N];
        self.ic2 = [x; N];
    }

    /// Low-pass outputs of the lanes for the inputs `x`.
    #[inline(always)]
    pub fn low(&mut self, x: &[f32; N]) -> [f32; N] {
        let mut low = [0.0; N];
        for i in 0..N {
            low[i] = self.lane(i, x[i]).1;
        }
        low
    }

    /// High-pass outputs of the lanes for the inputs `x`.
    #[inline(always)]
    pub fn high(&mut self, x: &[f32; N]) -> [f32; N] {
        let mut high = [0.0; N];
        for i in 0..N {
            let (band, low) = self.lane(i, x[i]);
            high[i] = x[i] - K * band - low;
        }
        high
    }

    /// Band-pass and low-pass output of one lane.
    #[inline(always)]
    fn lane(&mut self, i: usize, x: f32) -> (f32, f32) {
        let v3 = x - self.ic2[i];
        let v1 = self.a1[i] * self.ic1[i] + self.a2[i] * v3;
        let v2 = self.ic2[i] + self.a2[i] * self.ic1[i] + self.a3[i] * v3;
        self.ic1[i] = 2.0 * v1 - self.ic1[i];
        self.ic2[i] = 2.0 * v2 - self.ic2[i];
        (v1, v2)
    }

    /// Sets states that have decayed below any signal to zero, so that long silence does not
    /// leave subnormal numbers, which many processors handle 50 times slower.
    #[inline]
    pub fn flush_tiny(&mut self) {
        for states in [&mut self.ic1, &mut self.ic2] {
            for state in states {
                // Without a branch, so that whole vectors are looked at.
                *state = if state.abs() < super::bank::TINY { 0.0 } else { *state };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{Svf, SvfLanes};
    use core::f64::consts::PI;

    /// The same recursion in `f64`, coefficients not rounded.
    fn reference(corner: f64, rate: f64, input: &[f32]) -> std::vec::Vec<(f64, f64)> {
        let g = (PI * corner / rate).tan();
        let k = 2.0_f64.sqrt();
        let a1 = 1.0 / (1.0 + g * (g + k));
        let (a2, a3) = (g * a1, g * g * a1);
        let (mut ic1, mut ic2) = (0.0, 0.0);
        input
            .iter()
            .map(|&x| {
                let x = f64::from(x);
                let v3 = x - ic2;
                let v1 = a1 * ic1 + a2 * v3;
                let v2 = ic2 + a2 * ic1 + a3 * v3;
                ic1 = 2.0 * v1 - ic1;
                ic2 = 2.0 * v2 - ic2;
                (v2, x - k * v1 - v2)
            })
            .collect()
    }

    fn noise(n: usize) -> std::vec::Vec<f32> {
        let mut state = 1_u32;
        (0..n)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f32::from(i16::try_from(state >> 17).unwrap_or(0)) / 16384.0 - 1.0
            })
            .collect()
    }

    #[test]
    fn f32_follows_f64() {
        let rate = 10_000.0;
        let input = noise(40_000);
        for corner in [2.0_f32, 10.0, 30.0, 400.0, 4000.0] {
            let expected = reference(f64::from(corner), f64::from(rate), &input);
            let section = Svf::butterworth(corner, rate).unwrap();
            let mut low = SvfLanes::new([section]);
            let mut high = SvfLanes::new([section]);
            let mut worst = 0.0_f64;
            for (x, (want_low, want_high)) in input.iter().zip(expected) {
                worst = worst.max((f64::from(low.low(&[*x])[0]) - want_low).abs());
                worst = worst.max((f64::from(high.high(&[*x])[0]) - want_high).abs());
            }
            assert!(worst < 2e-6, "corner {corner} Hz: worst error {worst:e}");
        }
    }

    /// Gain at a frequency, measured after the transient, against the analogue Butterworth section
    /// at the frequency the bilinear transform maps it to.
    #[test]
    fn gain_is_butterworth() {
        let (rate, corner) = (10_000.0_f32, 500.0_f32);
        let section = Svf::butterworth(corner, rate).unwrap();
        for f in [50.0_f32, 250.0, 500.0, 1000.0, 3000.0] {
            let mut low = SvfLanes::new([section]);
            let (mut energy, mut count) = (0.0_f64, 0.0_f64);
            for i in 0..20_000_u16 {
                let phase = 2.0 * PI * f64::from(f) * f64::from(i) / f64::from(rate);
                #[expect(clippy::cast_possible_truncation, reason = "test signal")]
                let y = low.low(&[phase.sin() as f32])[0];
                if i >= 10_000 {
                    energy += f64::from(y).powi(2);
                    count += 1.0;
                }
            }
            let warped = (PI * f64::from(f) / f64::from(rate)).tan()
                / (PI * f64::from(corner) / f64::from(rate)).tan();
            let expected = 1.0 / (1.0 + warped.powi(4)).sqrt();
            let got = (2.0 * energy / count).sqrt();
            assert!((got - expected).abs() < 1e-3, "{f} Hz: {got} instead of {expected}");
        }
    }

    #[test]
    fn priming_hides_a_constant() {
        let mut high = SvfLanes::new([Svf::butterworth(30.0, 10_000.0).unwrap()]);
        high.prime(1e-3);
        for _ in 0..1000 {
            assert!(high.high(&[1e-3])[0].abs() < 1e-9);
        }
    }

    #[test]
    fn corners_out_of_reach_are_refused() {
        for corner in [0.0, -1.0, 4100.0, f32::NAN, f32::INFINITY] {
            assert!(Svf::butterworth(corner, 10_000.0).is_err(), "{corner}");
        }
        assert!(Svf::butterworth(1.0, f32::NAN).is_err());
    }
}
