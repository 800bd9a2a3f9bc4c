//! One sample in, one band-passed value per band out; all bands advance together.

use super::svf::{CornerError, MAX_CORNER, Svf, SvfLanes};

/// States below this are set to zero; squared it is still a normal `f32`.
pub(super) const TINY: f32 = 1e-18;

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

#[cfg(test)]
mod tests {
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
