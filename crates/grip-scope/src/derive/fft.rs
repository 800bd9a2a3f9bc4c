//! Complex values in, their discrete Fourier transform out: radix 2, in place, for a power of two of them.
//!
//! `X_k = sum_n x_n exp(-2 pi i k n / N)`. Cooley and Tukey, Math. Comp. 19 (1965); decimation in time. In f32 the error of a bin is some
//! 1e-6 of the largest one at N = 512 (test), far below a step of the spectrogram. A crate would be faster; a transform a few dozen times
//! a second does not need it.

use core::f32::consts::TAU;

/// A transform of one length.
#[derive(Clone, Debug)]
pub(super) struct Fft {
    /// exp(-2 pi i k / N) for k below N / 2.
    turns: Vec<[f32; 2]>,
    len: usize,
}

impl Fft {
    /// A transform of `len` values, a power of two.
    pub(super) fn new(len: usize) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "lengths are below 2^24")]
        let angle = |k: usize| -TAU * k as f32 / len as f32;
        let turns = (0..len / 2).map(|k| [angle(k).cos(), angle(k).sin()]).collect();
        Self { turns, len }
    }

    /// Transforms `values`; another number of them than the transform is for stays as it is.
    pub(super) fn run(&self, values: &mut [[f32; 2]]) {
        if values.len() != self.len || !self.len.is_power_of_two() {
            return;
        }
        let shift = usize::BITS - self.len.trailing_zeros();
        for k in 0..self.len {
            let mirrored = if self.len > 1 { k.reverse_bits() >> shift } else { 0 };
            if k < mirrored {
                values.swap(k, mirrored);
            }
        }
        let mut half = 1;
        while half < self.len {
            let stride = self.len / (2 * half);
            for block in values.chunks_exact_mut(2 * half) {
                let (low, high) = block.split_at_mut(half);
                let turns = self.turns.iter().step_by(stride);
                for ((a, b), [re, im]) in low.iter_mut().zip(high).zip(turns) {
                    let turned = [b[0] * re - b[1] * im, b[0] * im + b[1] * re];
                    *b = [a[0] - turned[0], a[1] - turned[1]];
                    *a = [a[0] + turned[0], a[1] + turned[1]];
                }
            }
            half *= 2;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Fft;
    use core::f64::consts::TAU;

    #[test]
    fn it_is_the_sum_that_it_says() {
        for len in [1_usize, 2, 8, 64, 512] {
            let wave = |n: usize| {
                let n = f64::from(u32::try_from(n).unwrap());
                (0.37 * n).sin() + 0.5 * (1.9 * n + 1.0).cos()
            };
            #[expect(clippy::cast_possible_truncation, reason = "the precision under test")]
            let mut values: Vec<[f32; 2]> = (0..len).map(|n| [wave(n) as f32, 0.0]).collect();
            Fft::new(len).run(&mut values);
            for (k, value) in values.iter().enumerate() {
                let turn = |n: usize| -TAU * (k * n % len) as f64 / len as f64;
                let re: f64 = (0..len).map(|n| wave(n) * turn(n).cos()).sum();
                let im: f64 = (0..len).map(|n| wave(n) * turn(n).sin()).sum();
                let error = (f64::from(value[0]) - re).hypot(f64::from(value[1]) - im);
                assert!(error < 1e-6 * len as f64, "{len} {k}: {error}");
            }
        }
    }
}
