//! Older detectors, written from their published descriptions, on the same samples. Each gives one number a sample; its threshold is
//! set by a run without slip. They know nothing of the motion reference.
//!
//! - [`Peer::fft`]: energy of 60 to 125 Hz in blocks of 128 samples that do not overlap (block FFT of vibration sensors).
//! - [`Peer::pad`]: magnitude of the signal high-passed at 5 Hz over the grip force (Romano et al., IEEE Trans. Robotics 27
//!   (2011), force-scaled threshold on the high-passed pad force; the stylus stands in for the pad).
//! - [`Peer::single`]: magnitude of the signal high-passed at 20 Hz.

use super::trials::Alarm;
use core::f64::consts::TAU;
use slip_core::Sample;

const BLOCK: usize = 128;
/// An alarm lasts at least this long (samples).
const HOLD: u32 = 1000;

#[derive(Clone, Debug)]
enum Rule {
    Fft { block: Vec<f64>, bins: core::ops::RangeInclusive<usize> },
    HighPass { share: f64, mean: Option<f64>, by_force: bool },
}

/// One of them.
#[derive(Clone, Debug)]
pub struct Peer {
    rule: Rule,
    threshold: f64,
    statistic: f64,
    hold: u32,
}

impl Peer {
    /// The block FFT at `rate_hz`.
    #[must_use]
    pub fn fft(rate_hz: f64, threshold: f64) -> Self {
        let bin = rate_hz / BLOCK as f64;
        let first = (60.0 / bin).ceil().max(1.0) as usize;
        let last = ((125.0 / bin).floor() as usize).max(first);
        Self::new(Rule::Fft { block: Vec::with_capacity(BLOCK), bins: first..=last }, threshold)
    }

    /// The high-passed signal over the force.
    #[must_use]
    pub fn pad(rate_hz: f64, threshold: f64) -> Self {
        let share = 1.0 - (-TAU * 5.0 / rate_hz).exp();
        Self::new(Rule::HighPass { share, mean: None, by_force: true }, threshold)
    }

    /// The high-passed signal.
    #[must_use]
    pub fn single(rate_hz: f64, threshold: f64) -> Self {
        let share = 1.0 - (-TAU * 20.0 / rate_hz).exp();
        Self::new(Rule::HighPass { share, mean: None, by_force: false }, threshold)
    }

    fn new(rule: Rule, threshold: f64) -> Self {
        Self { rule, threshold, statistic: 0.0, hold: 0 }
    }
}

impl Alarm for Peer {
    fn step(&mut self, sample: &Sample) -> bool {
        let x = f64::from(sample.stylus);
        match &mut self.rule {
            Rule::Fft { block, bins } => {
                block.push(x);
                if block.len() == BLOCK {
                    self.statistic = bins.clone().map(|bin| energy(block, bin)).sum();
                    block.clear();
                }
            }
            Rule::HighPass { share, mean, by_force } => {
                let middle = mean.get_or_insert(x);
                let distance = x - *middle;
                *middle += *share * distance;
                let force =
                    if *by_force { sample.normal_force_n.map_or(1.0, f64::from) } else { 1.0 };
                self.statistic = distance.abs() / force;
            }
        }
        self.hold =
            if self.statistic > self.threshold { HOLD } else { self.hold.saturating_sub(1) };
        self.hold > 0
    }

    fn statistic(&self) -> f64 {
        self.statistic
    }
}

/// Energy of one bin of the discrete Fourier transform of the block, its mean taken off, under a Hann window.
fn energy(block: &[f64], bin: usize) -> f64 {
    let mean = block.iter().sum::<f64>() / block.len() as f64;
    let (mut re, mut im) = (0.0, 0.0);
    for (i, x) in block.iter().enumerate() {
        let turn = TAU * i as f64 / block.len() as f64;
        let value = (x - mean) * 0.5 * (1.0 - turn.cos());
        re += value * (turn * bin as f64).cos();
        im += value * (turn * bin as f64).sin();
    }
    re * re + im * im
}

#[cfg(test)]
mod tests {
    use super::energy;

    #[test]
    fn a_tone_shows_in_its_bin() {
        let tone: Vec<f64> =
            (0..128).map(|i| (core::f64::consts::TAU * 8.0 * f64::from(i) / 128.0).sin()).collect();
        // A Hann window halves the amplitude of its bin: (128/2 * 1/2)^2.
        assert!((energy(&tone, 8) - 1024.0).abs() < 1.0, "{}", energy(&tone, 8));
        assert!(energy(&tone, 12) < 1e-9);
    }
}
