//! Irregularities in, the scattered energy of vibration E_sc out.
//!
//! Eq. 1 as printed:
//!
//! ```text
//! E_sc = n F v tan(S),   S = sum over i = 1..n of cot(delta_i / s_i)
//! ```
//!
//! with n irregularities of height delta_i and spacing s_i, the trial force F (N) and the slip speed v
//! (m/s). Its unit is N m/s = W. tan is periodic, so the value answers to S mod pi: with a relative
//! error eps on every r_i = delta_i/s_i the deviation of S is sigma_S = eps sqrt(sum (r_i csc^2 r_i)^2)
//! (independent errors), and where sigma_S exceeds 1 the value says nothing about the surface. It is
//! still given as printed, with the flag beside it.

use crate::irregularity::Irregularity;

/// E_sc with the figures that tell how far it can be trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Esc {
    /// E_sc (W).
    pub value_w: f64,
    /// Irregularities in the sum.
    pub n: u32,
    /// S, the sum of cotangents.
    pub sum: f64,
    /// Relative condition number with respect to S: |2 S / sin 2S|.
    pub condition: f64,
    /// Deviation of S (rad) caused by the sensor noise.
    pub sigma_s: f64,
    /// Whether sigma_S stays below 1, so that S mod pi still depends on the surface.
    pub informative: bool,
}

/// The running sum of Eq. 1. Compensated (Neumaier), so that n up to 10^6 costs no digits; the sum of
/// sensitivities stays beside it. O(1) state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EscSum {
    n: u32,
    degenerate: u32,
    sum: f64,
    compensation: f64,
    sensitivity_squared: f64,
}

impl EscSum {
    /// Adds an irregularity and says so; one without positive finite height and spacing, or whose ratio is
    /// a multiple of pi, is counted as degenerate and left out.
    #[inline]
    pub fn push(&mut self, irregularity: Irregularity) -> bool {
        let r = f64::from(irregularity.delta_m) / f64::from(irregularity.spacing_m);
        let sin = libm::sin(r);
        let cot = libm::cos(r) / sin;
        let sensitivity = r / (sin * sin);
        // Two negative lengths would make a positive ratio; NaN fails every comparison.
        let lengths = irregularity.delta_m > 0.0 && irregularity.spacing_m > 0.0;
        if !(lengths && cot.is_finite() && sensitivity.is_finite()) {
            self.degenerate += 1;
            return false;
        }
        let total = self.sum + cot;
        self.compensation += if self.sum.abs() >= cot.abs() {
            (self.sum - total) + cot
        } else {
            (cot - total) + self.sum
        };
        self.sum = total;
        self.sensitivity_squared += sensitivity * sensitivity;
        self.n += 1;
        true
    }

    /// Irregularities in the sum.
    #[must_use]
    pub fn n(&self) -> u32 {
        self.n
    }

    /// Irregularities that were left out.
    #[must_use]
    pub fn degenerate(&self) -> u32 {
        self.degenerate
    }

    /// E_sc for trial force `force_n` (N) and slip speed `speed_m_s` (m/s), where each delta/s carries the
    /// relative noise `noise`; `None` before the first irregularity or for values that are not finite.
    #[must_use]
    pub fn literal(&self, force_n: f64, speed_m_s: f64, noise: f64) -> Option<Esc> {
        if self.n == 0 {
            return None;
        }
        let sum = self.sum + self.compensation;
        let value_w = f64::from(self.n) * force_n * speed_m_s * libm::tan(sum);
        let sigma_s = noise * libm::sqrt(self.sensitivity_squared);
        value_w.is_finite().then(|| Esc {
            value_w,
            n: self.n,
            sum,
            condition: (2.0 * sum / libm::sin(2.0 * sum)).abs(),
            sigma_s,
            informative: sigma_s < 1.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::EscSum;
    use crate::irregularity::Irregularity;

    fn sum_of(ratios: &[f32]) -> EscSum {
        let mut sum = EscSum::default();
        for r in ratios {
            sum.push(Irregularity { delta_m: *r, spacing_m: 1.0 });
        }
        sum
    }

    /// Values from a 60-digit evaluation of Eq. 1 with r as these `f32` values.
    #[test]
    fn matches_reference_values() {
        // r = 1: S = cot 1, E = 1 * 2 * 0.5 * tan(cot 1).
        let one = sum_of(&[1.0]).literal(2.0, 0.5, 0.0).unwrap();
        assert!((one.sum - 0.642_092_615_934_330_7).abs() < 1e-15);
        assert!((one.value_w - 0.747_801_550_829_053_8).abs() < 2e-15, "{}", one.value_w);
        // r = 0.5, 0.25 are exact in binary: S = cot .5 + cot .25.
        let two = sum_of(&[0.5, 0.25]).literal(1.0, 1.0, 0.01).unwrap();
        assert!((two.sum - 5.746_805_086_358_392).abs() < 1e-15 * 6.0);
        assert!((two.value_w + 1.189_039_663_406_206_3).abs() < 2e-16 * two.condition);
    }

    #[test]
    fn noise_takes_the_information() {
        let few = sum_of(&[0.5; 3]).literal(1.0, 1.0, 0.01).unwrap();
        assert!(few.informative && few.sigma_s > 0.0);
        let many = sum_of(&[0.005; 100]).literal(1.0, 1.0, 0.01).unwrap();
        assert!(!many.informative, "sigma_S = {}", many.sigma_s);
    }

    #[test]
    fn degenerate_irregularities_are_counted_not_summed() {
        let mut sum = EscSum::default();
        for (delta_m, spacing_m) in [
            (0.0, 1.0),
            (1.0, 0.0),
            (f32::NAN, 1.0),
            (1.0, f32::INFINITY),
            (-1.0, -1.0),
            (-1.0, 1.0),
        ] {
            sum.push(Irregularity { delta_m, spacing_m });
        }
        assert_eq!((sum.n(), sum.degenerate()), (0, 6));
        assert_eq!(sum.literal(1.0, 1.0, 0.0), None);
    }

    #[test]
    fn not_finite_inputs_give_no_value() {
        assert_eq!(sum_of(&[0.5]).literal(f64::NAN, 1.0, 0.0), None);
        assert_eq!(sum_of(&[0.5]).literal(1.0, f64::INFINITY, 0.0), None);
    }
}
