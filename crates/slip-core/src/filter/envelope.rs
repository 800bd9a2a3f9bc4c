//! Band signals in, their mean energy over the last milliseconds out.

use super::bank::TINY;

/// Exponentially weighted mean of the square: e <- e + a (y^2 - e), a = 1 - exp(-1/(tau fs)).
#[derive(Clone, Copy, Debug)]
pub struct Envelope<const N: usize> {
    weight: [f32; N],
    energy: [f32; N],
}

impl<const N: usize> Envelope<N> {
    /// Envelopes with time constants `tau_s` (s) for samples at `rate_hz`, starting from `energy`.
    #[must_use]
    pub fn new(tau_s: &[f32; N], rate_hz: f32, energy: [f32; N]) -> Self {
        Self { weight: tau_s.map(|tau| -libm::expm1f(-1.0 / (tau * rate_hz))), energy }
    }

    /// Starts again from the energies `energy` (signal unit squared).
    pub fn prime(&mut self, energy: [f32; N]) {
        self.energy = energy;
    }

    /// Takes the next band values and gives the mean energies (signal unit squared).
    #[inline]
    pub fn step(&mut self, y: &[f32; N]) -> [f32; N] {
        for ((energy, weight), y) in self.energy.iter_mut().zip(&self.weight).zip(y) {
            let e = *energy + weight * (y * y - *energy);
            *energy = if e < TINY * TINY { 0.0 } else { e };
        }
        self.energy
    }
}

#[cfg(test)]
mod tests {
    use super::Envelope;

    #[test]
    fn reaches_63_percent_after_one_time_constant() {
        let mut envelope = Envelope::new(&[0.01], 10_000.0, [0.0]);
        let mut last = 0.0;
        for _ in 0..100 {
            [last] = envelope.step(&[2.0]);
        }
        assert!((last / 4.0 - (1.0 - libm::expf(-1.0))).abs() < 1e-3, "{last}");
    }
}
