//! Band-pass filters: band signals of the samples and their mean energy.
// Second-order sections: the low-pass and high-pass parts of a sample.

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
///
/// The topology is the trapezoidal state-variable filter (V. Zavalishin, *The Art of VA Filter Design*,
/// ch. 4; A. Simper, *Linear trapezoidal integrated SVF*, 2013). Its two states are the integrator
/// outputs, so in `f32` it keeps its accuracy where the corner lies far below the sample rate; a
/// direct-form biquad there subtracts nearly equal numbers. With g = tan(pi fc / fs), k = sqrt 2
/// (Butterworth), a1 = 1/(1 + g(g + k)), a2 = g a1, a3 = g a2:
///
/// ```text
/// v3 = x - ic2      v1 = a1 ic1 + a2 v3      v2 = ic2 + a2 ic1 + a3 v3
/// ic1 <- 2 v1 - ic1      ic2 <- 2 v2 - ic2
/// low = v2               high = x - k v1 - v2
/// ```
///
/// The transfer functions are those of the bilinear transform of the analogue Butterworth section.
/// Measured against the same recursion in `f64` (test `f32_follows_f64`): worst error 2e-6 of full scale
/// for corners from 2e-4 to 0.4 of the sample rate.
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
                *state = if state.abs() < TINY { 0.0 } else { *state };
            }
        }
    }
}

// Filter bank: one band-passed value per band for each sample; all bands advance together.

/// States below this are set to zero; squared it is still a normal `f32`.
pub(crate) const TINY: f32 = 1e-18;

/// The pass band of one detector channel.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Band {
    /// Lower -3 dB corner (Hz).
    pub low_hz: f32,
    /// Upper -3 dB corner (Hz); a corner above 0.4 of the sample rate is lowered to that.
    pub high_hz: f32,
}

/// `N` band-passes, each a second-order Butterworth high-pass followed by a low-pass.
///
/// Against the same bands in `f64`, a million samples with an offset of half of full scale, drift, noise and textures at 1 to 20 kHz:
/// an error of each band signal below 3e-7 + 1e-8 rate/`low_hz` of full scale (test `every_band_follows_its_reference_at_every_rate`).
#[derive(Clone, Copy, Debug)]
pub struct FilterBank<const N: usize> {
    high_pass: SvfLanes<N>,
    low_pass: SvfLanes<N>,
}

impl<const N: usize> FilterBank<N> {
    /// Filters for `bands` at `rate_hz`.
    ///
    /// # Errors
    /// Where a band's lower corner does not fit under its upper one or under 0.4 of the sample rate.
    pub fn new(bands: &[Band; N], rate_hz: f32) -> Result<Self, CornerError> {
        let mut high_pass = [Svf::butterworth(1.0, 1000.0)?; N];
        let mut low_pass = high_pass;
        for (i, band) in bands.iter().enumerate() {
            let upper = band.high_hz.min(MAX_CORNER * rate_hz);
            low_pass[i] = Svf::butterworth(upper, rate_hz)?;
            if band.low_hz >= upper {
                return Err(CornerError { corner_hz: band.low_hz, limit_hz: upper, rate_hz });
            }
            high_pass[i] = Svf::butterworth(band.low_hz, rate_hz)?;
        }
        Ok(Self { high_pass: SvfLanes::new(high_pass), low_pass: SvfLanes::new(low_pass) })
    }

    /// Forgets the past as if the input had always been `x`.
    pub fn prime(&mut self, x: f32) {
        self.high_pass.prime(x);
        self.low_pass.prime(0.0);
    }

    /// The band signals of the next sample. `x` must be finite.
    ///
    /// After long silence call [`FilterBank::flush_tiny`] now and then.
    #[inline]
    pub fn step(&mut self, x: f32) -> [f32; N] {
        self.low_pass.low(&self.high_pass.high(&[x; N]))
    }

    /// Takes a block of samples: the sum of squares of each band signal times its `scale`, where `offset` is taken off each sample
    /// before. States that have decayed below any signal are set to zero at its end.
    #[inline]
    pub fn energy(&mut self, block: &[f32], offset: f32, scale: &[f32; N]) -> [f32; N] {
        let mut sums = [0.0; N];
        for x in block {
            let y = self.step(x - offset);
            for ((sum, y), scale) in sums.iter_mut().zip(y).zip(scale) {
                let scaled = y * scale;
                *sum += scaled * scaled;
            }
        }
        self.flush_tiny();
        sums
    }

    /// Sets states that have decayed below any signal to zero: subnormal numbers are slow on many processors. From
    /// 1e-18 it takes at least ten time constants of a filter to get there, so once in some samples is enough.
    #[inline]
    pub fn flush_tiny(&mut self) {
        self.low_pass.flush_tiny();
        self.high_pass.flush_tiny();
    }
}

// Mean energy of the band signals over the last milliseconds.

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
mod svf_tests {
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

#[cfg(test)]
mod bank_tests {
    extern crate std;
    use super::{Band, FilterBank};

    #[test]
    fn bands_separate_tones() {
        let bands = [Band { low_hz: 20.0, high_hz: 90.0 }, Band { low_hz: 250.0, high_hz: 700.0 }];
        let mut rms = [[0.0_f32; 2]; 2];
        for (tone, row) in [45.0_f32, 420.0].into_iter().zip(rms.iter_mut()) {
            let mut bank = FilterBank::new(&bands, 10_000.0).unwrap();
            for i in 0..20_000_u16 {
                let x =
                    libm::sinf(core::f32::consts::TAU * tone * f32::from(i % 10_000) / 10_000.0);
                let y = bank.step(x);
                if i >= 10_000 {
                    row[0] += y[0] * y[0] / 5000.0;
                    row[1] += y[1] * y[1] / 5000.0;
                }
            }
        }
        let gain = |f: f32, band: Band| {
            1.0 / ((1.0 + (band.low_hz / f).powi(4)) * (1.0 + (f / band.high_hz).powi(4)))
        };
        for (tone, row) in [45.0_f32, 420.0].into_iter().zip(rms) {
            for (energy, band) in row.into_iter().zip(bands) {
                let analogue = gain(tone, band);
                assert!(
                    (energy - analogue).abs() < 0.01,
                    "{tone} Hz: {energy}, analogue {analogue}"
                );
            }
        }
    }

    #[test]
    fn a_block_gives_what_its_samples_give() {
        let bands = [Band { low_hz: 20.0, high_hz: 400.0 }, Band { low_hz: 250.0, high_hz: 700.0 }];
        let mut blocks = FilterBank::new(&bands, 10_000.0).unwrap();
        let mut single = blocks;
        let scale = [3.0_f32, 0.5];
        let wave = |i: u16| 1e-6 * libm::cosf(f32::from(i) * 0.37) + 2e-7 * f32::from(i % 13);
        let mut at = 0_u16;
        for len in (1..40_u16).cycle().take(400) {
            let block: std::vec::Vec<f32> = (at..at + len).map(|i| 1e-3 + wave(i)).collect();
            at = (at + len) % 10_000;
            let mut expected = [0.0_f32; 2];
            for x in &block {
                let y = single.step(x - 1e-3);
                for b in 0..2 {
                    expected[b] += (y[b] * scale[b]) * (y[b] * scale[b]);
                }
            }
            single.flush_tiny();
            assert_eq!(blocks.energy(&block, 1e-3, &scale), expected);
            assert!(expected[0] > 0.0);
        }
    }

    #[test]
    fn upper_corner_follows_a_low_sample_rate() {
        assert!(FilterBank::new(&[Band { low_hz: 100.0, high_hz: 3000.0 }], 1000.0).is_ok());
        let error =
            FilterBank::new(&[Band { low_hz: 700.0, high_hz: 3000.0 }], 1000.0).unwrap_err();
        assert!((error.limit_hz - 400.0).abs() < 1e-3);
    }

    #[test]
    fn silence_leaves_no_subnormals() {
        let mut bank = FilterBank::new(&[Band { low_hz: 20.0, high_hz: 400.0 }], 10_000.0).unwrap();
        bank.step(1.0);
        for _ in 0..200_000 {
            let y = bank.step(0.0);
            bank.flush_tiny();
            assert!(y[0] == 0.0 || y[0].is_normal());
        }
    }
}

#[cfg(test)]
mod envelope_tests {
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
