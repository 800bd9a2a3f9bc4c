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
    Fft { block: Vec<f64>, bins: Vec<Bin> },
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
        let bins = (first..=last).map(Bin::new).collect();
        Self::new(Rule::Fft { block: Vec::with_capacity(BLOCK), bins }, threshold)
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
                    self.statistic = bins.iter().map(|bin| bin.energy(block)).sum();
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

/// One bin of the discrete Fourier transform under a Hann window: the weights of its real and imaginary part.
#[derive(Clone, Debug)]
struct Bin {
    weights: Vec<[f64; 2]>,
    sums: [f64; 2],
}

impl Bin {
    fn new(bin: usize) -> Self {
        let weights: Vec<[f64; 2]> = (0..BLOCK)
            .map(|i| {
                let turn = TAU * i as f64 / BLOCK as f64;
                let window = 0.5 * (1.0 - turn.cos());
                [window * (turn * bin as f64).cos(), window * (turn * bin as f64).sin()]
            })
            .collect();
        let sums = [0, 1].map(|part| weights.iter().map(|weight| weight[part]).sum());
        Self { weights, sums }
    }

    /// Energy of a block in this bin, its mean taken off.
    fn energy(&self, block: &[f64]) -> f64 {
        let (mut sum, mut re, mut im) = (0.0, 0.0, 0.0);
        // About the first sample, so that a large offset costs no digits.
        let first = block.first().copied().unwrap_or(0.0);
        for (x, [cos, sin]) in block.iter().zip(&self.weights) {
            let x = x - first;
            sum += x;
            re += x * cos;
            im += x * sin;
        }
        let mean = sum / block.len() as f64;
        let [re, im] = [re - mean * self.sums[0], im - mean * self.sums[1]];
        re * re + im * im
    }
}

#[cfg(test)]
mod tests {
    use super::Bin;

    #[test]
    fn a_tone_shows_in_its_bin() {
        let tone: Vec<f64> =
            (0..128).map(|i| (core::f64::consts::TAU * 8.0 * f64::from(i) / 128.0).sin()).collect();
        // A Hann window halves the amplitude of its bin: (128/2 * 1/2)^2.
        let energy = |bin| Bin::new(bin).energy(&tone);
        assert!((energy(8) - 1024.0).abs() < 1.0, "{}", energy(8));
        assert!(energy(12) < 1e-9);
        let lifted: Vec<f64> = tone.iter().map(|x| x + 1e3).collect();
        assert!((Bin::new(8).energy(&lifted) - 1024.0).abs() < 1.0);
    }
}
