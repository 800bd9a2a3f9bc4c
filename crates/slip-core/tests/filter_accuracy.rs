//! The whole filter bank in `f32` against the same bands in `f64`: direct-form biquads, a recursion that shares nothing with the
//! state-variable sections under test but the transfer function.
//!
//! Six bands as shipped, a million samples at each of four rates: an offset of half of full scale that drifts to all of it, noise,
//! textures that come and go. Full scale is 1. The errors grow with the sample rate over the
//! lower corner, as those of the states do; the bounds below are one and a half to four times what was found.
#![expect(clippy::cast_possible_truncation, reason = "signals and bounds in f32")]

use core::f64::consts::{PI, SQRT_2, TAU};
use slip_core::{
    detector::{BANDS, DetectorConfig},
    filter::{Band, Envelope, FilterBank, MAX_CORNER},
};

const SAMPLES: u32 = 1_000_000;
const RATES_HZ: [f32; 4] = [1000.0, 2200.0, 10_000.0, 20_000.0];
const ENVELOPE_S: f32 = 5e-3;

/// Largest error of a band signal, of full scale: this...
const SIGNAL: f64 = 3e-7;
/// ... and this for each time that the lower corner fits into the sample rate.
const SIGNAL_PER_RATIO: f64 = 1e-8;
/// The same for the root of the mean energy of a band over 5 ms.
const RMS: f64 = 1e-7;
/// See [`SIGNAL_PER_RATIO`].
const RMS_PER_RATIO: f64 = 5e-9;
/// Largest error of the mean energy, of itself, while its root is above [`STRONG`].
const ENERGY: f64 = 2e-4;
/// Part of full scale.
const STRONG: f64 = 1e-2;

/// One section in transposed direct form II.
#[derive(Clone, Copy)]
struct Biquad {
    b: [f64; 3],
    a: [f64; 2],
    s: [f64; 2],
}

impl Biquad {
    /// Butterworth, by the bilinear transform with its corner prewarped.
    fn new(corner_hz: f64, rate_hz: f64, high_pass: bool) -> Self {
        let w = (PI * corner_hz / rate_hz).tan();
        let norm = 1.0 / (1.0 + SQRT_2 * w + w * w);
        let b = if high_pass {
            [norm, -2.0 * norm, norm]
        } else {
            [1.0, 2.0, 1.0].map(|b| b * w * w * norm)
        };
        let a = [2.0 * (w * w - 1.0) * norm, (1.0 - SQRT_2 * w + w * w) * norm];
        Self { b, a, s: [0.0; 2] }
    }

    fn step(&mut self, x: f64) -> f64 {
        let y = self.b[0] * x + self.s[0];
        self.s[0] = self.b[1] * x - self.a[0] * y + self.s[1];
        self.s[1] = self.b[2] * x - self.a[1] * y;
        y
    }
}

/// The corners of the shipped bands; one that does not fit the rate runs as the shear band, as in the detector.
fn bands(rate_hz: f32) -> [Band; BANDS] {
    let limit_hz = MAX_CORNER * rate_hz;
    let [shear, ..] = DetectorConfig::default().bands();
    DetectorConfig::default().bands().map(|band| {
        let band = if band.low_hz < 0.8 * limit_hz { band } else { shear };
        Band { low_hz: band.low_hz, high_hz: band.high_hz.min(limit_hz) }
    })
}

/// Uniform numbers from -1 to 1.
struct Noise(u64);

impl Noise {
    fn draw(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from((self.0 >> 33) as u32) / f64::from(1_u32 << 30) - 1.0
    }
}

/// Offset with drift, noise of 1e-4 and, in every second eighth of the run, a texture of 0.02 to 0.2 that speeds up through the bands.
fn signal(rate_hz: f64) -> impl Iterator<Item = f32> {
    let mut noise = Noise(7);
    let mut phase = 0.0;
    (0..SAMPLES).map(move |i| {
        let at = f64::from(i) / f64::from(SAMPLES);
        let eighth = (8.0 * at).floor();
        let within = 8.0 * at - eighth;
        let drift = 0.5 + 0.3 * at;
        let mut x = drift + 1e-4 * noise.draw();
        if eighth % 2.0 > 0.5 {
            phase = (phase + 20.0 * (0.3 * rate_hz / 20.0).powf(within) / rate_hz).fract();
            let size = if eighth < 4.0 { 0.02 } else { 0.2 };
            x += size * ((TAU * phase).sin().abs() - 0.6) * (within * PI).sin();
        }
        x as f32
    })
}

#[derive(Clone, Copy, Debug, Default)]
struct Worst {
    signal: f64,
    rms: f64,
    energy: f64,
}

/// Largest errors of each band.
fn worst(mut bank: FilterBank<BANDS>, corners: [Band; BANDS], rate_hz: f32) -> [Worst; BANDS] {
    let rate = f64::from(rate_hz);
    let mut envelope = Envelope::new(&[ENVELOPE_S; BANDS], rate_hz, [0.0; BANDS]);
    let mut exact = corners.map(|band| {
        let low_pass = Biquad::new(f64::from(band.high_hz), rate, false);
        (Biquad::new(f64::from(band.low_hz), rate, true), low_pass)
    });
    let weight = -(-1.0 / (f64::from(ENVELOPE_S) * rate)).exp_m1();
    let mut energies = [0.0_f64; BANDS];
    let mut worst = [Worst::default(); BANDS];
    for x in signal(rate) {
        let got = bank.step(x);
        bank.flush_tiny();
        let got_energy = envelope.step(&got);
        for b in 0..BANDS {
            let (high_pass, low_pass) = &mut exact[b];
            let want = low_pass.step(high_pass.step(f64::from(x)));
            energies[b] += weight * (want * want - energies[b]);
            let got_energy = f64::from(got_energy[b]);
            let worst = &mut worst[b];
            worst.signal = worst.signal.max((f64::from(got[b]) - want).abs());
            worst.rms = worst.rms.max((got_energy.sqrt() - energies[b].sqrt()).abs());
            if energies[b] > STRONG * STRONG {
                worst.energy = worst.energy.max((got_energy / energies[b] - 1.0).abs());
            }
        }
    }
    worst
}

#[test]
fn every_band_follows_its_reference_at_every_rate() {
    for rate_hz in RATES_HZ {
        let corners = bands(rate_hz);
        let bank = FilterBank::new(&corners, rate_hz).unwrap();
        let all = worst(bank, corners, rate_hz);
        for (band, (worst, corners)) in all.into_iter().zip(corners).enumerate() {
            println!(
                "{rate_hz:6} Hz band {band}: signal {:.1e}, rms {:.1e} of full scale, strong energy {:.1e} of itself",
                worst.signal, worst.rms, worst.energy
            );
            let ratio = f64::from(rate_hz / corners.low_hz);
            let (signal, rms) = (SIGNAL + SIGNAL_PER_RATIO * ratio, RMS + RMS_PER_RATIO * ratio);
            assert!(worst.energy > 0.0, "{rate_hz} Hz, band {band}: nothing strong in it");
            let within = worst.signal < signal && worst.rms < rms && worst.energy < ENERGY;
            assert!(within, "{rate_hz} Hz, band {band}: {worst:?}, bounds {signal:e} and {rms:e}");
        }
    }
}
