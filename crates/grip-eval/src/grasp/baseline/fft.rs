//! Controller that raises the force by a step with every block of the stylus that vibrates (Holweg et al. 1996).
//!
//! The energy of the band that a slip fills, over blocks of 128 samples that do not overlap, is compared with that of the stylus in the air; each
//! block beyond the threshold raises the force by the same step, and nothing lowers it.

use super::{ForceLaw, Touch};
use core::f64::consts::TAU;
use slip_core::Sample;

const BLOCK: usize = 128;
/// The band (Hz).
const BAND_HZ: [f64; 2] = [60.0, 125.0];
/// Rise of the force by one block (N).
const STEP_N: f64 = 1.0;
/// Threshold over the mean energy in the air.
const MARGIN: f64 = 12.0;

/// The block-wise law.
#[derive(Clone, Debug)]
pub(crate) struct Fft {
    trial_n: f64,
    period_s: f64,
    bins: Vec<Vec<[f64; 2]>>,
    block: Vec<f64>,
    rest: (f64, u32),
    touch: Touch,
    held: bool,
    force_n: f64,
    slipping: bool,
    slips: u64,
}

impl Fft {
    pub(crate) fn new(trial_n: f64, rate_hz: f64) -> Self {
        let bins = (1..BLOCK / 2).map(|bin| bin as f64);
        let width_hz = rate_hz / 128.0;
        let [low, high] = BAND_HZ;
        // At a high rate one bin is wider than the band: the one that holds its middle.
        let inside = |bin: &f64| {
            let hz = bin * width_hz;
            (low..=high).contains(&hz) || (hz - 0.5 * (low + high)).abs() <= 0.5 * width_hz
        };
        Self {
            trial_n,
            period_s: 1.0 / rate_hz,
            bins: bins.filter(inside).map(weights).collect(),
            block: Vec::with_capacity(BLOCK),
            rest: (0.0, 0),
            touch: Touch::default(),
            held: false,
            force_n: trial_n,
            slipping: false,
            slips: 0,
        }
    }

    /// The energy of a block that this sample completes.
    fn energy(&mut self, sample: &Sample) -> Option<f64> {
        let x = f64::from(sample.stylus);
        self.block.push(if x.is_nan() { 0.0 } else { x });
        if self.block.len() < BLOCK {
            return None;
        }
        let mean = self.block.iter().sum::<f64>() / 128.0;
        let energy = |weights: &Vec<[f64; 2]>| {
            let parts = self.block.iter().zip(weights);
            let [re, im] = parts.fold([0.0; 2], |[re, im], (x, [cos, sin])| {
                [re + (x - mean) * cos, im + (x - mean) * sin]
            });
            re * re + im * im
        };
        let sum = self.bins.iter().map(energy).sum();
        self.block.clear();
        Some(sum)
    }
}

/// Real and imaginary weights of a bin of the discrete Fourier transform under a Hann window.
fn weights(bin: f64) -> Vec<[f64; 2]> {
    let turns = (0_u8..128).map(|i| TAU * f64::from(i) / 128.0);
    turns
        .map(|turn| {
            let window = 0.5 * (1.0 - turn.cos());
            [window * (turn * bin).cos(), window * (turn * bin).sin()]
        })
        .collect()
}

impl ForceLaw for Fft {
    fn learn(&mut self, sample: &Sample) {
        if let Some(energy) = self.energy(sample) {
            self.rest = (self.rest.0 + energy, self.rest.1 + 1);
        }
    }

    fn force_n(&mut self, sample: &Sample) -> f64 {
        if !self.touch.is_over(sample, self.trial_n, self.period_s) {
            return self.force_n;
        }
        if !self.held {
            self.held = true;
            self.block.clear();
        }
        if let Some(energy) = self.energy(sample) {
            let threshold = MARGIN * self.rest.0 / f64::from(self.rest.1.max(1));
            let slipping = energy > threshold;
            self.slips += u64::from(slipping && !self.slipping);
            self.force_n += if slipping { STEP_N } else { 0.0 };
            self.slipping = slipping;
        }
        self.force_n
    }

    fn slips(&self) -> u64 {
        self.slips
    }
}
