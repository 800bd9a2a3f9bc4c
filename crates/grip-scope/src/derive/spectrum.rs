//! Spectra of samples of the stylus, some milliseconds each.

use crate::feed::{DB_BASE, DB_STEP, SpectrumColumn};
use core::f32::consts::TAU;
use core::fmt;
use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex};
use std::sync::Arc;

/// A spectrum covers about this time (s), within the lengths below.
const WINDOW_S: f32 = 0.025;
const LEAST: usize = 64;
const MOST: usize = 512;

/// Spectra with a Hann window, each half a window after the one before.
#[derive(Clone)]
pub(super) struct Spectra {
    fft: Arc<dyn RealToComplex<f32>>,
    window: Vec<f32>,
    rate_hz: f32,
    samples: Vec<f32>,
    times: Vec<f64>,
    weighed: Vec<f32>,
    values: Vec<Complex<f32>>,
    scratch: Vec<Complex<f32>>,
    held: f32,
}

/// A plan cannot be printed.
impl fmt::Debug for Spectra {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Spectra").field("rate_hz", &self.rate_hz).finish_non_exhaustive()
    }
}

impl Spectra {
    pub(super) fn new(rate_hz: f32) -> Self {
        let len = length(rate_hz);
        let window = |k: usize| 0.5 - 0.5 * (TAU * k as f32 / len as f32).cos();
        let fft = RealFftPlanner::new().plan_fft_forward(len);
        Self {
            window: (0..len).map(window).collect(),
            rate_hz,
            samples: Vec::with_capacity(len),
            times: Vec::with_capacity(len),
            weighed: fft.make_input_vec(),
            values: fft.make_output_vec(),
            scratch: fft.make_scratch_vec(),
            fft,
            held: 0.0,
        }
    }

    /// The next samples do not join the last ones.
    pub(super) fn restart(&mut self) {
        self.samples.clear();
        self.times.clear();
    }

    /// Takes a reading; one that is not finite is that of before. A spectrum, where it completes one.
    pub(super) fn push(&mut self, t_s: f64, x: f32) -> Option<SpectrumColumn> {
        if x.is_finite() && x.abs() < grip_record::HUGE_READING {
            self.held = x;
        }
        self.samples.push(self.held);
        self.times.push(t_s);
        let len = self.window.len();
        if self.samples.len() < len {
            return None;
        }
        let span = [*self.times.first()?, t_s];
        let bins = self.bins();
        self.samples.drain(..len / 2);
        self.times.drain(..len / 2);
        Some(SpectrumColumn { span, top_hz: 0.5 * self.rate_hz, bins })
    }

    /// Power of each bin below half the sample rate: a sine of amplitude A shows A^2 / 2.
    fn bins(&mut self) -> Box<[u8]> {
        let len = self.samples.len() as f32;
        let mean = self.samples.iter().sum::<f32>() / len;
        for (weighed, (x, w)) in self.weighed.iter_mut().zip(self.samples.iter().zip(&self.window))
        {
            *weighed = (x - mean) * w;
        }
        // The buffers are those that the plan has made, so it has nothing to refuse.
        let done =
            self.fft.process_with_scratch(&mut self.weighed, &mut self.values, &mut self.scratch);
        debug_assert!(done.is_ok(), "{done:?}");
        // A Hann window halves amplitudes; a real signal shows each half at either sign of the frequency.
        let per_amplitude = 4.0 / len;
        let half = self.values.iter().take(self.window.len() / 2);
        half.map(|bin| byte(0.5 * (bin.norm() * per_amplitude).powi(2))).collect()
    }
}

/// A power of two near [`WINDOW_S`].
fn length(rate_hz: f32) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let wanted = (WINDOW_S * rate_hz) as usize;
    wanted.next_power_of_two().clamp(LEAST, MOST)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
fn byte(power: f32) -> u8 {
    ((10.0 * power.log10() - DB_BASE) / DB_STEP).round() as u8
}

#[cfg(test)]
mod tests {
    use super::{Spectra, SpectrumColumn, length};

    #[test]
    fn a_sine_stands_at_its_frequency_with_its_power() {
        let rate_hz = 10_000.0;
        let mut spectra = Spectra::new(rate_hz);
        let amplitude = 1e-6_f32;
        let columns: Vec<_> = (0..1000_u16)
            .filter_map(|n| {
                let t_s = f32::from(n) / rate_hz;
                let x = 2e-3 + amplitude * (core::f32::consts::TAU * 1250.0 * t_s).sin();
                spectra.push(f64::from(t_s), x)
            })
            .collect();
        let len = length(rate_hz);
        assert_eq!((len, columns.len()), (256, 1 + (1000 - 256) / 128));
        let column = &columns[1];
        let (top, highest) = column.bins.iter().enumerate().max_by_key(|bin| bin.1).unwrap();
        assert_eq!((column.bins.len(), top), (128, 32));
        let wanted_db = 10.0 * (0.5 * amplitude * amplitude).log10();
        assert!((SpectrumColumn::db(*highest) - wanted_db).abs() < 1.0);
        assert!(column.bins[100] < highest - 40);
        assert!((column.span[0] - 0.0128).abs() < 1e-6, "{:?}", column.span);
    }

    #[test]
    fn readings_that_are_none_make_no_spectrum_of_noise() {
        let mut spectra = Spectra::new(100.0);
        let bad = [f32::NAN, 1e30, f32::INFINITY, 1.0];
        let column = (0..64_u8)
            .filter_map(|n| spectra.push(f64::from(n), bad[usize::from(n % 4)]))
            .next()
            .unwrap();
        assert!(column.bins.iter().all(|byte| SpectrumColumn::db(*byte) < 0.0), "{column:?}");
    }
}
