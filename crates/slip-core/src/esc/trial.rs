//! What is known of the slip beside its irregularities.

use super::real::Real;

/// Relative noise of each ratio delta/s (one deviation).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise<T = f64> {
    /// Independent from irregularity to irregularity.
    pub independent: T,
    /// Common to all of them: an error of the gain or of the speed.
    pub common: T,
}

impl<T: Real> Noise<T> {
    /// Deviation of a sum whose terms answer to a relative error with `slopes`: their sum of squares and their sum.
    pub(super) fn deviation(self, squares: T, sum: T) -> T {
        // A sum beyond the largest number must not turn "no noise" into NaN.
        let part = |noise: T, answer: T| if noise == T::ZERO { T::ZERO } else { noise * answer };
        let independent = part(self.independent, squares.sqrt());
        let common = part(self.common, sum);
        if common == T::ZERO {
            return independent;
        }
        (independent * independent + common * common).sqrt()
    }
}

/// Force and speed of the slip, the noise of its measurement, and the damper of the stylus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial<T = f64> {
    /// Trial force F (N).
    pub force_n: T,
    /// Slip speed v (m/s).
    pub speed_m_s: T,
    /// Noise of each delta/s.
    pub noise: Noise<T>,
    /// Damper c of the stylus (N s/m), for [`super::Reading::ViscousWork`] alone.
    pub damping_n_s_m: T,
}

impl<T: Real> Trial<T> {
    /// Damper of a stylus of 1 g on 500 N/m with damping ratio 0.1: 0.2 sqrt(k m) (N s/m).
    pub const DAMPING_N_S_M: f32 = 0.141_421_36;

    /// A trial with exact ratios and the damper [`Self::DAMPING_N_S_M`].
    #[must_use]
    pub fn new(force_n: T, speed_m_s: T) -> Self {
        let noise = Noise { independent: T::ZERO, common: T::ZERO };
        Self { force_n, speed_m_s, noise, damping_n_s_m: T::of(Self::DAMPING_N_S_M) }
    }

    /// The same with independent relative noise `noise` of each delta/s.
    #[must_use]
    pub fn with_noise(self, noise: T) -> Self {
        Self { noise: Noise { independent: noise, common: T::ZERO }, ..self }
    }
}
